// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Damage } from "../recordings/frame_places";
import type { Placement } from "../recordings/transforms";

/** A file to open: one of the user's, one of a server, or one in the page. */
export type OpenFile =
  | { name: string; blob: Blob }
  | { name: string; url: string }
  | { name: string; bytes: Uint8Array };

export interface StreamDescription {
  name: string;
  metadata: Record<string, string>;
  /** A live source had it before, and has it no more. */
  isGone?: boolean;
}

/** A frame that a stream shall show. */
export interface WantedFrame {
  stream: number;
  number: number; // in the order of the stream, from 0
}

/** How frames are decoded, besides which. */
export interface DecodingSettings {
  removesOutliers: boolean;
  /** Seconds that voxels stay visible after they were seen last; 0: voxels of the frame only. */
  trailSeconds: number;
  /** Of fieldChoices(), whose values voxels have with them; null: none. */
  field: string | null;
}

export type ToWorker =
  | { type: "load"; wasm: ArrayBuffer }
  /** `source`: the page's number for it. What was open stays until it has frames. */
  | { type: "open"; source: number; files: OpenFile[] }
  | { type: "openLive"; source: number }
  | { type: "liveStreams"; streams: { id: number; name: string; metadata: Record<string, string> }[] }
  /** `at`: when it came, which its liveShown tells again. */
  | { type: "liveFrame"; message: ArrayBuffer; at: number }
  | { type: "settings"; settings: DecodingSettings }
  | { type: "show"; source: number; request: number; frames: WantedFrame[] }
  | { type: "recycle"; buffer: ArrayBuffer };

/** Frames of a recording as they are indexed; one entry of each array for a frame. */
export interface FrameBatch {
  streams: Uint16Array;
  times: Float64Array; // seconds since `startTime`
  bytes: Uint32Array;
  voxels: Uint32Array; // or points, where hasPoints is 1
  hasPoints: Uint8Array;
  isIFrame: Uint8Array;
  /** 1 where frames before this one are missing, or its header cannot be read. */
  isGap: Uint8Array;
}

/** The voxels of a frame in one buffer, which the page gives back when it has drawn others. */
export interface PackedVoxels {
  count: number;
  /** Those after the frame's own voxels, which were seen before and are no longer there. */
  pastCount: number;
  /** That their positions are told from, in the coordinates of the frame, metres. */
  origin: readonly [number, number, number];
  buffer: ArrayBuffer;
  hasIntensities: boolean;
  hasColours: boolean;
  hasPointCounts: boolean;
  isJudged: boolean; // by the outlier filter
  /** That of the settings, if the stream has it. */
  field: string | null;
}

export interface ShownFrame {
  stream: number;
  number: number;
  time: number; // seconds since `startTime`
  /** Null: nothing is drawn, for the reason in `problem`. */
  voxels: PackedVoxels | null;
  problem: string | null;
  /** What of the frame is not drawn. */
  warning: string | null;
  /** The outlier filter's remark on this frame. */
  filterProblem: string | null;
  frameId: string | null;
  /** Of the cloud, nanoseconds; null: unknown. */
  stamp: bigint | null;
  /** By the transforms of the recording; null: it has none, and coordinates are drawn as they are. */
  placement: Placement | null;
  resolution: number;
  intensityRange: { min: number; max: number; step: number } | null;
  fields: readonly string[]; // names of fieldChoices()
  isIFrame: boolean;
  bytes: number;
  decodeMs: number;
}

/** A frame is damaged within, or takes more memory than the page has for it. */
export type FrameFailure = "Damaged" | "TooLarge";

export type FromWorker =
  | { type: "loaded" }
  /** What follows is of this source. */
  | { type: "opened"; source: number }
  /** This one has nothing to show: what was open stays. */
  | { type: "refused"; source: number; message: string; damage: Damage[] }
  | { type: "failed"; message: string }
  | { type: "streams"; streams: StreamDescription[] }
  | { type: "frames"; startTime: bigint; batch: FrameBatch; hasTimes: boolean }
  | { type: "damage"; damage: Damage }
  | { type: "remark"; message: string }
  /** A frame that cannot be decoded by itself; those that depend on it are lost, too. */
  | { type: "undecodable"; stream: number; name: string; number: number; problem: string; failure: FrameFailure }
  /** More frames of coordinates have a place: those that are drawn may have another one. */
  | { type: "placesChanged" }
  | { type: "progress"; share: number }
  | { type: "indexed"; isWhole: boolean }
  | { type: "shown"; request: number; frames: ShownFrame[] }
  /** The stamps of a live source have begun again: times of frames before mean nothing any more. */
  | { type: "clockBegan" }
  /** `isOld`: the frame was there before the page. */
  | { type: "liveShown"; frame: ShownFrame; serverId: number; wantsIFrame: boolean; at: number; isOld: boolean };
