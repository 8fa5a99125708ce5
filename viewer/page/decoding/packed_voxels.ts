// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { PackedVoxels } from "./messages";

/** Bytes of voxels: position 12, intensity 4, points 4, seconds since it was seen 4, colour 3, noise 1, and 8 of a field. */
export function bytesOf(count: number, hasField: boolean): number {
  return count * (hasField ? 36 : 28);
}

/** The arrays in a buffer of packed voxels; the frame's own voxels first, then past ones. */
export interface VoxelArrays {
  /** Metres from the voxels' origin, as floats do not hold the coordinates of maps. */
  positions: Float32Array;
  intensities: Float32Array;
  pointCounts: Uint32Array;
  ages: Float32Array;
  /** Red, green, blue, and 255 for noise. */
  paint: Uint8Array;
  /** Values of the field, exactly; NaN: none. */
  field: Float64Array | null;
}

/** Whether the outlier filter takes a voxel for noise. */
export function isOutlier(arrays: VoxelArrays, voxel: number): boolean {
  return arrays.paint[4 * voxel + 3] === 255;
}

export function arraysOf(buffer: ArrayBuffer, count: number, hasField: boolean): VoxelArrays {
  const begin = hasField ? 8 * count : 0; // the largest numbers first, which must be aligned
  return {
    positions: new Float32Array(buffer, begin, 3 * count),
    intensities: new Float32Array(buffer, begin + 12 * count, count),
    pointCounts: new Uint32Array(buffer, begin + 16 * count, count),
    ages: new Float32Array(buffer, begin + 20 * count, count),
    paint: new Uint8Array(buffer, begin + 24 * count, 4 * count),
    field: hasField ? new Float64Array(buffer, 0, count) : null,
  };
}

export function totalCount(voxels: PackedVoxels): number {
  return voxels.count + voxels.pastCount;
}

/** Buffers that go back and forth between worker and page, so that no frame leaves garbage. */
export class BufferPool {
  private free: ArrayBuffer[] = [];

  take(bytes: number): ArrayBuffer {
    const fit = this.free.findIndex((buffer) => buffer.byteLength >= bytes);
    if (fit >= 0) return this.free.splice(fit, 1)[0];
    return new ArrayBuffer(Math.ceil((bytes * 1.25) / 65536) * 65536);
  }

  give(buffer: ArrayBuffer): void {
    if (buffer.byteLength === 0) return;
    this.free.push(buffer);
    this.free.sort((a, b) => a.byteLength - b.byteLength);
    if (this.free.length > 32) this.free.shift();
  }
}
