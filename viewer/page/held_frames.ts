// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ShownFrame } from "./decoding/messages";

/** The newest frame of each stream of a live source, until the next picture. */
export class HeldFrames {
  private readonly frames = new Map<number, ShownFrame>();

  constructor(private readonly recycle: (buffer: ArrayBuffer) => void) {}

  hold(frame: ShownFrame): void {
    const before = this.frames.get(frame.stream)?.voxels;
    if (before) this.recycle(before.buffer);
    this.frames.set(frame.stream, frame);
  }

  forget(streams: readonly number[]): void {
    for (const stream of streams) {
      const voxels = this.frames.get(stream)?.voxels;
      if (voxels) this.recycle(voxels.buffer);
      this.frames.delete(stream);
    }
  }

  takeAll(): ShownFrame[] {
    const frames = [...this.frames.values()];
    this.frames.clear();
    return frames;
  }

  clear(): void {
    for (const { voxels } of this.takeAll()) if (voxels) this.recycle(voxels.buffer);
  }
}
