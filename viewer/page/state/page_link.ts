// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { fieldOf, initialState, longestDecay, voxelScales } from "./viewer_state";
import type { ViewerState, ViewerStore } from "./viewer_state";

/** Values that a link carries, with the short names that they have in it. */
const shortNames = {
  colourBy: "colour",
  shape: "shape",
  threshold: "threshold",
  removesOutliers: "outliers",
  noise: "noise",
  voxelScale: "size",
  hiddenStreams: "hidden",
  up: "up",
  cutAbove: "cutabove",
  cutBelow: "cutbelow",
  followsSensor: "follow",
  decaySeconds: "decay",
  showsGrid: "grid",
  showsAxes: "axes",
  showsSensors: "sensors",
  showsCropBox: "crop",
  clock: "clock",
  theme: "theme",
} as const satisfies Partial<Record<keyof ViewerState, string>>;

type LinkedKey = keyof typeof shortNames;

const choices: Partial<Record<LinkedKey, readonly string[]>> = {
  colourBy: ["intensity", "height", "stream", "age", "recorded"],
  shape: ["cubes", "points"],
  noise: ["hide", "colour"],
  up: ["auto", "z", "-z", "y", "-y"],
  clock: ["utc", "local"],
  theme: ["auto", "light", "dark"],
};

/** The number in a link, within what the page's own controls allow. */
function numberIn(key: LinkedKey, number: number): number | undefined {
  if (!Number.isFinite(number)) return undefined;
  if (key === "voxelScale") return Math.min(voxelScales.max, Math.max(voxelScales.min, number));
  if (key === "decaySeconds") return Math.min(longestDecay, Math.max(0, number));
  return number;
}

/** A camera that looks somewhere, within coordinates that are drawn. */
function isCamera(values: number[]): boolean {
  return values.length === 6 && values.every((value) => Math.abs(value) <= 1e9) &&
    [0, 1, 2].some((axis) => values[axis] !== values[axis + 3]);
}

/** The value in a link; undefined if it is none. */
function parse(key: LinkedKey, text: string): unknown {
  const initial = initialState[key];
  if (typeof initial === "boolean") return text === "1" ? true : text === "0" ? false : undefined;
  if (typeof initial === "number") return numberIn(key, Number(text));
  return choices[key]?.includes(text) || (key === "colourBy" && fieldOf(text)) ? text : undefined;
}

function format(value: unknown): string {
  return typeof value === "boolean" ? (value ? "1" : "0") : String(value);
}

/** Camera and time, which are no part of the state. */
export interface LinkedView {
  camera: number[] | null; // position and target
  time: number | null;
}

/** The state of what a link may say, where it says nothing. */
export function unlinkedState(): Partial<ViewerState> {
  return Object.fromEntries(Object.keys(shortNames).map((key) => [key, initialState[key as LinkedKey]]));
}

export function readLink(hash: string): { state: Partial<ViewerState>; view: LinkedView } {
  const link = new URLSearchParams(hash.replace(/^#/, ""));
  const state: Record<string, unknown> = {};
  for (const [key, name] of Object.entries(shortNames)) {
    const text = link.get(name);
    const isList = Array.isArray(initialState[key as LinkedKey]);
    const value = text === null ? undefined : isList ? link.getAll(name).filter(Boolean) : parse(key as LinkedKey, text);
    if (value !== undefined) state[key] = value;
  }
  const camera = (link.get("camera") ?? "").split(",").map(Number);
  const time = Number(link.get("time") ?? NaN);
  return {
    state: state as Partial<ViewerState>,
    view: {
      camera: isCamera(camera) ? camera : null,
      time: Number.isFinite(time) ? time : null,
    },
  };
}

/** Position and target of a camera, to a ten-thousandth of the distance between them. */
function rounded(camera: number[]): number[] {
  const distance = Math.hypot(...[0, 1, 2].map((axis) => camera[axis] - camera[axis + 3]));
  const digits = Math.min(12, Math.max(0, Math.ceil(4 - Math.log10(distance || 1e-9))));
  return camera.map((value) => Number(value.toFixed(digits)));
}

export function writeLink(state: ViewerState, view: LinkedView): string {
  const link = new URLSearchParams();
  for (const key of Object.keys(shortNames) as LinkedKey[]) {
    const value = state[key];
    // A list has its parameter once for each entry, as entries may contain commas.
    if (Array.isArray(value)) for (const entry of value) link.append(shortNames[key], entry);
    else if (value !== initialState[key]) link.set(shortNames[key], format(value));
  }
  // Rounded up, as the frame of a time is the last one that is not after it.
  if (view.time !== null) link.set("time", String(Math.ceil(view.time * 1e6 - 1e-4) / 1e6));
  if (view.camera) link.set("camera", rounded(view.camera).join(","));
  return "#" + link.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/** Takes the file out of the address, as another one is shown. */
export function forgetLinkedFile(): void {
  const address = new URL(location.href);
  if (!address.searchParams.has("file")) return;
  address.searchParams.delete("file");
  try {
    history.replaceState(null, "", address);
  } catch {
    // As below.
  }
}

/** Keeps the page's address up to date, so that it can be sent. */
export function keepLinkUpToDate(store: ViewerStore, view: () => LinkedView): () => void {
  let timer = 0;
  const update = (): void => {
    window.clearTimeout(timer);
    timer = window.setTimeout(() => {
      try {
        history.replaceState(null, "", writeLink(store.get(), view()));
      } catch {
        // Some embedded pages have no address of their own; then there is none to keep.
      }
    }, 400);
  };
  return update;
}
