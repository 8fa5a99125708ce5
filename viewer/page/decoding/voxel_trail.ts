// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Voxels } from "@pcl_ext/codec";

/** A voxel that a stream saw at least once. */
interface SeenVoxel {
  x: number;
  y: number;
  z: number;
  intensity: number;
  time: number; // of the last frame that had it
  frames: number;
}

/** Fewer frames had a voxel that is noise: it does not stay. */
const fewestFrames = 2;

/** Remembers when each voxel of a stream was seen last. */
export class VoxelTrail {
  private readonly seen = new Map<string | number, SeenVoxel>();
  private resolution = 0;
  private lastTime = -Infinity;

  reset(): void {
    this.seen.clear();
    this.lastTime = -Infinity;
  }

  /** Adds a frame, and forgets what was seen earlier than `seconds` before. */
  add({ positions, intensities, resolution }: Voxels, time: number, seconds: number): void {
    if (resolution !== this.resolution || time < this.lastTime) this.seen.clear();
    this.resolution = resolution;
    this.lastTime = time;
    for (let i = 0; i < positions.length; i += 3) {
      const x = positions[i];
      const y = positions[i + 1];
      const z = positions[i + 2];
      const key = this.keyOf(x, y, z);
      const voxel = this.seen.get(key);
      const intensity = intensities ? intensities[i / 3] : 0;
      if (voxel) {
        if (voxel.time < time) ++voxel.frames;
        voxel.time = time;
        voxel.intensity = intensity;
      } else this.seen.set(key, { x, y, z, intensity, time, frames: 1 });
    }
    for (const [key, voxel] of this.seen) if (voxel.time < time - seconds) this.seen.delete(key);
  }

  /** Those that the last frame, of `time`, does not have. */
  past(time: number): SeenVoxel[] {
    const result: SeenVoxel[] = [];
    for (const voxel of this.seen.values()) {
      if (voxel.time < time && voxel.frames >= fewestFrames) result.push(voxel);
    }
    return result;
  }

  /** A number as long as 17 bits an axis are enough, which maps hold far better than texts. */
  private keyOf(x: number, y: number, z: number): string | number {
    const i = Math.floor(x / this.resolution) + 65536;
    const j = Math.floor(y / this.resolution) + 65536;
    const k = Math.floor(z / this.resolution) + 65536;
    if (((i | j | k) & ~131071) !== 0) return `${i},${j},${k}`;
    return (i * 131072 + j) * 131072 + k;
  }
}
