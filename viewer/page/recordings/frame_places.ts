// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Limits for looking at frames without decoding them. */
export const limitsOfIndexing = { maxFrameBytes: 2 ** 28, maxVoxels: 2 ** 32 - 1, maxPoints: 2 ** 32 - 1 };

/** Bytes at the beginning of a frame that hold its header: with a lidar's rows and columns some 20 for each row. Not the
 * whole frame, as one of the published layout that is given whole is decoded to describe it. */
export const headBytes = 2 ** 14;

/** Where a frame's message or bytes lie. */
export interface FramePlace {
  /** Of the recording's files. */
  file: number;
  /** The compressed chunk that the message is in; null: the bytes lie in the file itself. */
  chunk: ChunkPlace | null;
  /** In the file or in the decompressed chunk. */
  offset: number;
  length: number;
  /** In the file, for messages to people. */
  fileOffset: number;
}

export interface ChunkPlace {
  offset: number; // of the compressed records in the file
  length: number;
  compression: string;
  size: number; // when decompressed
}

/** A part of a file that could not be read. */
export interface Damage {
  file: string;
  offset: number;
  message: string;
}

/** A frame as it is found when a recording is indexed. */
export interface FoundFrame {
  stream: number;
  /** Null: it is lost, and no more is known than that it was there. */
  place: FramePlace | null;
  /** Nanoseconds; null: unknown, the frame has the time of the one before. */
  time: bigint | null;
  bytes: number;
  isIFrame: boolean;
  /** Number that the encoder gave it; null where its header cannot be read. */
  number: number | null;
  voxels: number; // or points, if it has these in order
  hasPoints: boolean;
}

export interface RecordedStream {
  name: string;
  metadata: Record<string, string>;
}

/** Where the frames and the damage of a recording go as they are found. */
export interface RecordingListener {
  addStream(stream: RecordedStream): number;
  addFrame(frame: FoundFrame): void;
  addDamage(damage: Damage): void;
  addRemark(message: string): void;
  /** Share of the file that is indexed, 0 to 1. */
  progress(share: number): void;
}
