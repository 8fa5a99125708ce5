// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
const grouped = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

export function formatCount(value: number): string {
  return grouped.format(value);
}

/** A count with its noun, which has an s for all numbers but 1. */
export function formatCounted(value: number, noun: string): string {
  return `${formatCount(value)} ${noun}${value === 1 ? "" : "s"}`;
}

/** 3 significant digits, without an exponent. */
export function formatNumber(value: number): string {
  if (Number.isInteger(value)) return grouped.format(value);
  const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.abs(value) || 1)));
  return value.toFixed(Math.min(digits, 6));
}

/** A value of a field with all its digits. */
export function formatValue(value: number): string {
  if (Number.isSafeInteger(value)) return grouped.format(value);
  return String(Math.fround(value) === value ? Number(value.toPrecision(7)) : value); // of floats no more than they hold
}

/** A value in a range, with the digits that tell it from others there. */
export function formatInRange(value: number, range: number): string {
  if (Math.abs(value) > 1e15 || range === 0) return formatValue(value);
  const digits = Math.max(0, 2 - Math.floor(Math.log10(range)));
  return digits === 0 || Number.isInteger(value) ? grouped.format(value) : value.toFixed(Math.min(digits, 12));
}

export function formatBytes(bytes: number): string {
  return formatBytesPerSecond(bytes).replace("/s", "");
}

export function formatBytesPerSecond(bytes: number): string {
  if (bytes >= 1e6) return `${(bytes / 1e6).toFixed(2)} MB/s`;
  return `${bytes >= 1e5 ? grouped.format(bytes / 1000) : (bytes / 1000).toFixed(1)} kB/s`;
}

export function formatSeconds(seconds: number): string {
  return `${seconds.toFixed(2)} s`;
}

/** How long something has not come: whole seconds, from a minute on with minutes, from an hour on with hours. */
export function formatSilence(seconds: number): string {
  const whole = Math.floor(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor(whole / 60) % 60} min`;
}

export function formatTenths(seconds: number): string {
  return `${seconds.toFixed(1)} s`;
}

/** Places of voxels, in millimetres or, where their edge is shorter than a centimetre, finer. */
export function formatMetres(metres: readonly number[], edge: number): string {
  const digits = Math.min(12, Math.max(3, 1 - Math.floor(Math.log10(edge))));
  return `${metres.map((value) => value.toFixed(digits)).join(", ")} m`;
}

/** Date and time of day, if a time has them: simulated clocks begin at 0. */
export function formatDate(startNanoseconds: bigint, seconds: number, clock: "utc" | "local"): [string, string] | null {
  const ms = Number(startNanoseconds / 1000n) / 1000 + 1000 * seconds;
  if (ms < 1e11 || ms > 8e15) return null;
  const minutes = clock === "utc" ? 0 : -new Date(ms).getTimezoneOffset();
  const [day, time] = new Date(Math.round(ms) + 60_000 * minutes).toISOString().replace("Z", "").split("T");
  const ahead = new Date(60_000 * Math.abs(minutes)).toISOString().slice(11, 16);
  return [day, `${time} ${clock === "utc" ? "UTC" : `${minutes < 0 ? "−" : "+"}${ahead}`}`];
}
