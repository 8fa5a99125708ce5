// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { LocalPositions, Voxels } from "@pcl_ext/codec";

/** A voxel that a stream saw at least once. */
interface SeenVoxel {
  x: number; // edges from the first frame's origin
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
  /** Of the frame that was seen first, in its coordinates. */
  private first: LocalPositions["origin"] = [0, 0, 0];
  /** Of the last frame that had voxels. */
  origin: LocalPositions["origin"] = [0, 0, 0];
  /** From the first to that, edges. */
  private moved: [number, number, number] = [0, 0, 0];
  private lastTime = -Infinity;

  reset(): void {
    this.seen.clear();
    this.lastTime = -Infinity;
  }

  /** Adds a frame, and forgets what was seen earlier than `seconds` before. */
  add({ intensities, resolution }: Voxels, { origin, positions }: LocalPositions, time: number, seconds: number): void {
    if (resolution !== this.resolution || time < this.lastTime) this.seen.clear();
    this.resolution = resolution;
    this.lastTime = time;
    const edges = (metres: number): number => Math.round(metres / resolution);
    if (positions.length > 0) {
      if (this.seen.size === 0) this.first = origin;
      this.origin = origin;
      this.moved = [edges(origin[0] - this.first[0]), edges(origin[1] - this.first[1]), edges(origin[2] - this.first[2])];
    }
    for (let i = 0; i < positions.length; i += 3) {
      const x = edges(positions[i]) + this.moved[0];
      const y = edges(positions[i + 1]) + this.moved[1];
      const z = edges(positions[i + 2]) + this.moved[2];
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

  /** From `origin` on, metres. */
  positionOf({ x, y, z }: SeenVoxel): [number, number, number] {
    const [i, j, k] = this.moved;
    return [(x - i) * this.resolution, (y - j) * this.resolution, (z - k) * this.resolution];
  }

  /** A number as long as 17 bits an axis are enough, which maps hold far better than texts. */
  private keyOf(x: number, y: number, z: number): string | number {
    const i = x + 65536;
    const j = y + 65536;
    const k = z + 65536;
    if (((i | j | k) & ~131071) !== 0) return `${i},${j},${k}`;
    return (i * 131072 + j) * 131072 + k;
  }
}
