// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ShownFrame } from "./messages";
import { bytesOf, totalCount } from "./packed_voxels";
import type { BufferPool } from "./packed_voxels";

const maxBytes = 160 << 20;

/** Frames decoded last, so that a step back needs not decode from the I-frame again. */
export class ShownFrameCache {
  private readonly frames = new Map<string, ShownFrame>();
  private bytes = 0;

  clear(): void {
    this.frames.clear();
    this.bytes = 0;
  }

  /** Keeps a copy of a frame. */
  add(frame: ShownFrame): void {
    const key = `${frame.stream}:${frame.number}`;
    if (this.frames.has(key)) return;
    const voxels = frame.voxels;
    const used = voxels ? bytesOf(totalCount(voxels), voxels.field !== null) : 0;
    this.frames.set(key, { ...frame, voxels: voxels && { ...voxels, buffer: voxels.buffer.slice(0, used) } });
    this.bytes += used;
    for (const [oldest, old] of this.frames) {
      if (this.bytes <= maxBytes) break;
      this.bytes -= old.voxels?.buffer.byteLength ?? 0;
      this.frames.delete(oldest);
    }
  }

  /** A copy in a buffer of the pool. */
  find(stream: number, number: number, pool: BufferPool): ShownFrame | null {
    const frame = this.frames.get(`${stream}:${number}`);
    if (!frame?.voxels) return frame ? { ...frame } : null;
    const buffer = pool.take(frame.voxels.buffer.byteLength);
    new Uint8Array(buffer).set(new Uint8Array(frame.voxels.buffer));
    return { ...frame, voxels: { ...frame.voxels, buffer } };
  }
}
