import { initialState } from "./viewer_state";
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
  showsGrid: "grid",
  showsAxes: "axes",
  showsSensors: "sensors",
  showsCropBox: "crop",
  theme: "theme",
} as const satisfies Partial<Record<keyof ViewerState, string>>;

type LinkedKey = keyof typeof shortNames;

const choices: Partial<Record<LinkedKey, readonly string[]>> = {
  colourBy: ["intensity", "height", "stream", "age", "recorded"],
  shape: ["cubes", "points"],
  noise: ["hide", "colour"],
  theme: ["auto", "light", "dark"],
};

/** The value in a link; undefined if it is none. */
function parse(key: LinkedKey, text: string): unknown {
  const initial = initialState[key];
  if (Array.isArray(initial)) return text.split(",").filter((name) => name !== "");
  if (typeof initial === "boolean") return text === "1" ? true : text === "0" ? false : undefined;
  if (typeof initial === "number") return Number.isFinite(Number(text)) ? Number(text) : undefined;
  return choices[key]?.includes(text) ? text : undefined;
}

function format(value: unknown): string {
  if (Array.isArray(value)) return value.join(",");
  return typeof value === "boolean" ? (value ? "1" : "0") : String(value);
}

/** Camera and time, which are no part of the state. */
export interface LinkedView {
  camera: number[] | null; // position and target
  time: number | null;
}

export function readLink(hash: string): { state: Partial<ViewerState>; view: LinkedView } {
  const link = new URLSearchParams(hash.replace(/^#/, ""));
  const state: Record<string, unknown> = {};
  for (const [key, name] of Object.entries(shortNames)) {
    const text = link.get(name);
    const value = text === null ? undefined : parse(key as LinkedKey, text);
    if (value !== undefined) state[key] = value;
  }
  const camera = (link.get("camera") ?? "").split(",").map(Number);
  const time = Number(link.get("time") ?? NaN);
  return {
    state: state as Partial<ViewerState>,
    view: {
      camera: camera.length === 6 && camera.every(Number.isFinite) ? camera : null,
      time: Number.isFinite(time) ? time : null,
    },
  };
}

export function writeLink(state: ViewerState, view: LinkedView): string {
  const link = new URLSearchParams();
  for (const key of Object.keys(shortNames) as LinkedKey[])
    if (format(state[key]) !== format(initialState[key])) link.set(shortNames[key], format(state[key]));
  if (view.time !== null) link.set("time", view.time.toFixed(3));
  if (view.camera) link.set("camera", view.camera.map((value) => value.toFixed(3)).join(","));
  return "#" + link.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
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
