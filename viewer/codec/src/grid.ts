// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { CodecError, type Grid, type Voxels } from "./types.js";

/** Centre of a voxel on an axis, metres, in the frame's coordinates. */
function centre(grid: Grid, axis: 0 | 1 | 2, position: number): number {
  return (grid.firstIndex[axis] + position + 0.5) * grid.resolution + grid.origin[axis];
}

/** As VoxelGrid::needsDoubles() of the library: true if floats do not hold the centres of all
 * voxels of the grid to 1/16 of an edge, as where it lies at the coordinates of maps. */
export function needsDoubles(grid: Grid): boolean {
  const farthest = grid.resolution * (2 ** 20 + 0.25);
  const last = 2 ** grid.depth - 1;
  return ([0, 1, 2] as const).some(
    (axis) => centre(grid, axis, 0) < -farthest || centre(grid, axis, last) > farthest,
  );
}

/** Centres of voxels from that of one of them on, which floats hold wherever the cloud lies. */
export interface LocalPositions {
  /** The centre of that voxel, x, y, z, metres, in the frame's coordinates; 0 without voxels. */
  readonly origin: readonly [number, number, number];
  /** [3 * count] x, y, z, metres from there, in the order of the voxels. */
  readonly positions: Float32Array<ArrayBuffer>;
}

/** Local positions of a frame's voxels.
 * @param voxels decoded with `DecodeOptions.coded`
 * @throws CodecError "InvalidInput" if they were decoded otherwise
 */
export function localPositions({ count, coded, grid }: Voxels): LocalPositions {
  if (!coded) throw new CodecError("InvalidInput", "the frame was decoded without its keys");
  const positions = new Float32Array(3 * count);
  if (count === 0) return { origin: [0, 0, 0], positions };
  const keys = new Uint32Array(coded.keys.buffer); // the lower half of each first
  const isDeep = grid.depth > 10;
  const indexOf = (voxel: number, axis: number): number => {
    const bit = 2 - axis;
    const low = keys[2 * voxel] as number;
    const index = everyThirdBit(low >>> bit); // levels 0 to 9
    if (!isDeep) return index;
    const high = keys[2 * voxel + 1] as number;
    const middle = (low >>> 30) | (high << 2);
    return index | (everyThirdBit(middle >>> bit) << 10) | (((high >>> (28 + bit)) & 1) << 20);
  };
  // The grid's corner may be far away, and the first and last voxel may be strays.
  const amid = count >> 1;
  const [x, y, z] = [indexOf(amid, 0), indexOf(amid, 1), indexOf(amid, 2)];
  const { resolution } = grid;
  for (let i = 0; i < count; ++i) {
    positions[3 * i] = (indexOf(i, 0) - x) * resolution;
    positions[3 * i + 1] = (indexOf(i, 1) - y) * resolution;
    positions[3 * i + 2] = (indexOf(i, 2) - z) * resolution;
  }
  return { origin: [centre(grid, 0, x), centre(grid, 1, y), centre(grid, 2, z)], positions };
}

/** Bits 0, 3, 6, ... 27 of a number, beside each other. */
function everyThirdBit(bits: number): number {
  bits &= 0x09249249;
  bits = (bits | (bits >>> 2)) & 0x030c30c3;
  bits = (bits | (bits >>> 4)) & 0x0300f00f;
  bits = (bits | (bits >>> 8)) & 0x030000ff;
  return (bits | (bits >>> 16)) & 0x3ff;
}
