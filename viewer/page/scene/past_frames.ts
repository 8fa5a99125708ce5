// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { VoxelLayer } from "./voxel_layer";

/** In all of them; where there are more, the oldest frames go. About 60 bytes each. */
const mostVoxels = 4_000_000;
const mostFrames = 512;

interface PastFrame {
  stream: number;
  time: number; // seconds
  layer: VoxelLayer;
}

/** Frames that streams have shown before, which stay in the scene for the decay time. */
export class PastFrames {
  private frames: PastFrame[] = []; // as they came
  private voxels = 0;
  private readonly unused: VoxelLayer[] = [];

  constructor(private readonly onUnused: (layer: VoxelLayer) => void) {}

  get layers(): readonly { stream: number; layer: VoxelLayer }[] {
    return this.frames;
  }

  /** Keeps the layer that a stream has drawn until now; returns another one to be drawn in, if there is one. */
  keep(stream: number, time: number, layer: VoxelLayer): VoxelLayer | null {
    this.frames.push({ stream, time, layer });
    this.voxels += layer.count;
    while (this.voxels > mostVoxels || this.frames.length > mostFrames) this.remove(this.frames[0]);
    return this.unused.pop() ?? null;
  }

  /** Takes what a stream has shown from now on or too long ago: before a frame of it at this time. */
  trim(stream: number, time: number, decaySeconds: number): void {
    for (const frame of this.frames.filter((past) => past.stream === stream))
      if (frame.time >= time || frame.time < time - decaySeconds) this.remove(frame);
  }

  clear(): void {
    for (const frame of [...this.frames]) this.remove(frame);
    for (const layer of this.unused.splice(0)) layer.dispose();
  }

  private remove(frame: PastFrame): void {
    this.frames = this.frames.filter((past) => past !== frame);
    this.voxels -= frame.layer.count;
    this.onUnused(frame.layer);
    this.unused.push(frame.layer);
  }
}
