// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Vector3 } from "three";

import { isOutlier } from "../decoding/packed_voxels";
import type { Bounds } from "./camera_fit";
import type { Up } from "./up_axis";
import type { VoxelLayer } from "./voxel_layer";

/** The rule by which voxels are drawn; the shader has the same one. */
export interface DrawingRule {
  threshold: number;
  hidesNoise: boolean;
  up: Up;
  /** Heights. */
  cutBelow: number;
  cutAbove: number;
}

/** True if the voxel is noise, by the outlier filter or by the threshold, where there are intensities. */
export function isNoise(layer: VoxelLayer, voxel: number, threshold: number): boolean {
  const arrays = layer.arrays;
  if (arrays === null) return false;
  const isBelow = layer.voxels?.hasIntensities === true && arrays.intensities[voxel] < threshold;
  return isOutlier(arrays, voxel) || isBelow;
}

/** True if the voxel lies where the scene is cut off. */
function isCut(layer: VoxelLayer, voxel: number, { up, cutBelow, cutAbove }: DrawingRule): boolean {
  if (cutBelow === -Infinity && cutAbove === Infinity) return false;
  const height = up.sign * layer.coordinateOf(voxel, up.axis);
  const margin = 0.001 * layer.edge; // for the GPU's rounding, as a voxel's centre may lie at the cut
  return height < cutBelow - margin || height > cutAbove + margin;
}

export function isDrawn(layer: VoxelLayer, voxel: number, rule: DrawingRule): boolean {
  return !(rule.hidesNoise && isNoise(layer, voxel, rule.threshold)) && !isCut(layer, voxel, rule);
}

/** Voxels of the frame itself that are drawn. */
export function countDrawn(layer: VoxelLayer, rule: DrawingRule): number {
  const count = layer.voxels?.count ?? 0;
  let drawn = 0;
  for (let i = 0; i < count; ++i) if (isDrawn(layer, i, rule)) ++drawn;
  return drawn;
}

/** Voxels of the frame itself that are no noise. */
export function countKept(layer: VoxelLayer, threshold: number): number {
  const count = layer.voxels?.count ?? 0;
  let kept = 0;
  for (let i = 0; i < count; ++i) if (!isNoise(layer, i, threshold)) ++kept;
  return kept;
}

/** Places of some of a stream's voxels that are no noise, sorted along each axis. */
function sortedPlaces(layer: VoxelLayer, threshold: number): Float64Array[] {
  const count = layer.voxels?.count ?? 0;
  const step = Math.max(1, Math.floor(count / 8000));
  const voxels: number[] = [];
  for (let i = 0; i < count; i += step) if (!isNoise(layer, i, threshold)) voxels.push(i);
  return [0, 1, 2].map((axis) => Float64Array.from(voxels, (voxel) => layer.coordinateOf(voxel, axis)).sort());
}

/** A box in which most of a stream's voxels lie: along each axis all but 1 % at either end, and of these what is near. */
function mainBounds(layer: VoxelLayer, threshold: number): Bounds | null {
  const axes = sortedPlaces(layer, threshold);
  const count = axes[0].length;
  if (count === 0) return null;
  const low = axes.map((values) => values[Math.floor(0.01 * count)]);
  const high = axes.map((values) => values[Math.min(count - 1, Math.floor(0.99 * count))]);
  const near = 0.25 * Math.max(...high.map((value, axis) => value - low[axis]));
  const min = low.map((value, axis) => Math.max(axes[axis][0], value - near));
  const max = high.map((value, axis) => Math.min(axes[axis][count - 1], value + near));
  return { min: min as Bounds["min"], max: max as Bounds["max"] };
}

/** A box in which most voxels of each stream that is drawn lie: single ones far away do not count. */
export function boundsOf(layers: readonly VoxelLayer[], threshold: number): Bounds | null {
  const boxes = layers.flatMap((layer) => (layer.group.visible ? (mainBounds(layer, threshold) ?? []) : []));
  if (boxes.length === 0) return null;
  const join = (ends: number[][], choose: (...values: number[]) => number): [number, number, number] =>
    [0, 1, 2].map((axis) => choose(...ends.map((end) => end[axis]))) as [number, number, number];
  return { min: join(boxes.map(({ min }) => min), Math.min), max: join(boxes.map(({ max }) => max), Math.max) };
}

/** A voxel with its place among those of its stream. */
export interface PickedVoxel {
  layer: number;
  voxel: number;
  distance: number;
}

/** The first voxel that a ray meets.
 * @param leastHalf of an edge, for each metre of distance: small voxels are drawn larger, and a finger is not exact
 */
export function pick(
  layers: readonly VoxelLayer[],
  origin: Vector3,
  direction: Vector3,
  scale: number,
  leastHalf: number,
  rule: DrawingRule,
): PickedVoxel | null {
  let best: PickedVoxel | null = null;
  for (const [layerIndex, layer] of layers.entries()) {
    if (!layer.group.visible || !layer.arrays) continue;
    const positions = layer.arrays.positions;
    const count = positions.length / 3;
    // In their own coordinates voxels are along the axes.
    const inverse = layer.pose.clone().invert();
    const from = origin.clone().applyMatrix4(inverse).toArray();
    const towards = direction.clone().transformDirection(inverse).toArray();
    const half = 0.5 * layer.edge * Math.max(scale, 0.5);
    for (let voxel = 0; voxel < count; ++voxel) {
      let depth = 0;
      for (let axis = 0; axis < 3; ++axis) depth += towards[axis] * (positions[3 * voxel + axis] - from[axis]);
      const reach = Math.max(half, leastHalf * depth);
      let near = 0;
      let far = best ? best.distance : Infinity;
      for (let axis = 0; axis < 3; ++axis) {
        const toCentre = positions[3 * voxel + axis] - from[axis];
        const a = (toCentre - reach) / towards[axis];
        const b = (toCentre + reach) / towards[axis];
        near = Math.max(near, Math.min(a, b));
        far = Math.min(far, Math.max(a, b));
      }
      if (near > far || near === 0 || !isDrawn(layer, voxel, rule)) continue;
      best = { layer: layerIndex, voxel, distance: near };
    }
  }
  return best;
}
