// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { UpAxis } from "../scene/up_axis";
import { Store } from "./store";

export type ColourBy = "intensity" | "height" | "stream" | "age" | "recorded" | `field:${string}`;
export type Theme = "auto" | "light" | "dark";

/** What the viewer does, all of it; what it shows of a recording is in the FrameIndex and the scene. */
export interface ViewerState {
  // What is drawn, and how.
  colourBy: ColourBy;
  shape: "cubes" | "points";
  /** Voxels below it count as noise; in the unit of the intensities. */
  threshold: number;
  removesOutliers: boolean;
  noise: "hide" | "colour";
  voxelScale: number; // of the voxel's edge
  hiddenStreams: readonly string[];
  up: UpAxis | "auto"; // of the coordinates
  /** Heights between which voxels are drawn. */
  cutAbove: number;
  cutBelow: number;
  followsSensor: boolean; // the first one that moves, with the camera
  decaySeconds: number; // for which frames stay that others followed
  showsGrid: boolean;
  showsAxes: boolean;
  showsSensors: boolean;
  showsCropBox: boolean;
  theme: Theme;
  // Time.
  isPlaying: boolean;
  speed: number;
  clock: "utc" | "local"; // for dates
  moment: number; // of the FrameIndex
  // The source.
  source: "none" | "opening" | "recording" | "live";
  name: string;
  isOpening: boolean; // a source, while another one may be shown
  isConnected: boolean; // live
  hasEnded: boolean; // live: no frames will follow
  allStreams: number; // live: of the source
  liveStreams: number; // live: of these with frames that come
  hasProblem: boolean; // live: the server says that its source is disturbed
  isFrozen: boolean; // live: frames come, but the picture stays
  indexedShare: number;
  // Panels.
  showsHelp: boolean;
  showsPanel: boolean; // on narrow screens
}

/** All heights are drawn. */
export const noCut = { cutAbove: Infinity, cutBelow: -Infinity };

export const initialState: ViewerState = {
  colourBy: "intensity",
  shape: "cubes",
  threshold: 0,
  removesOutliers: false,
  noise: "hide",
  voxelScale: 1,
  hiddenStreams: [],
  up: "auto",
  ...noCut,
  followsSensor: false,
  decaySeconds: 0,
  showsGrid: true,
  showsAxes: true,
  showsSensors: true,
  showsCropBox: true,
  theme: "auto",
  isPlaying: false,
  speed: 1,
  clock: "utc",
  moment: 0,
  source: "none",
  name: "",
  isOpening: false,
  isConnected: false,
  hasEnded: false,
  allStreams: 0,
  liveStreams: 0,
  hasProblem: false,
  isFrozen: false,
  indexedShare: 0,
  showsHelp: false,
  showsPanel: false,
};

export const voxelScales = { min: 0.2, max: 1.5 };

export const longestDecay = 30; // seconds

/** Seconds that voxels stay visible when they are coloured by the time they were seen last. */
export const trailSeconds = 2;

/** The field that voxels are coloured by, by its name in fieldChoices(); null: by something else. */
export function fieldOf(colourBy: string): string | null {
  return colourBy.startsWith("field:") ? colourBy.slice("field:".length) : null;
}

export type ViewerStore = Store<ViewerState>;

export function createStore(): ViewerStore {
  return new Store(initialState);
}
