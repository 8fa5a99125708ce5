// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { IntensityAxis } from "./intensity_axis";

/** With more different values than this the highest ones of all have the same colour, as of intensities. */
const fewValues = 64;

/** The axis for the values of a field in the frames that are shown; null if they have none. */
export function fieldAxisOf(lists: readonly Float64Array[]): IntensityAxis | null {
  const total = lists.reduce((sum, list) => sum + list.length, 0);
  const every = Math.max(1, Math.floor(total / 50_000));
  const sample: number[] = [];
  let min = Infinity;
  let max = -Infinity;
  let isWhole = true;
  for (const list of lists)
    list.forEach((value, i) => {
      if (!Number.isFinite(value)) return;
      min = Math.min(min, value);
      max = Math.max(max, value);
      isWhole &&= Number.isInteger(value);
      if (i % every === 0) sample.push(value);
    });
  if (min > max) return null;
  const sorted = Float64Array.from(sample).sort();
  const common = sorted[Math.floor(0.99 * sorted.length)] ?? max;
  const bright = common > min && new Set(sorted).size > fewValues ? common : max;
  return new IntensityAxis(min, max, isWhole ? 1 : (max - min) / 1000, false, bright);
}
