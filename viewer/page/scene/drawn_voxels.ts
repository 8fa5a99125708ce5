// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Vector3 } from "three";

import { isOutlier } from "../decoding/packed_voxels";
import type { VoxelLayer } from "./voxel_layer";

/** The rule by which voxels are drawn; the shader has the same one. */
export interface DrawingRule {
  threshold: number;
  hidesNoise: boolean;
}

/** True if the voxel is noise, by the outlier filter or by the threshold, where there are intensities. */
export function isNoise(layer: VoxelLayer, voxel: number, threshold: number): boolean {
  const arrays = layer.arrays;
  if (arrays === null) return false;
  const isBelow = layer.voxels?.hasIntensities === true && arrays.intensities[voxel] < threshold;
  return isOutlier(arrays, voxel) || isBelow;
}

/** Voxels of the frame itself that are no noise. */
export function countKept(layer: VoxelLayer, threshold: number): number {
  const count = layer.voxels?.count ?? 0;
  let kept = 0;
  for (let i = 0; i < count; ++i) if (!isNoise(layer, i, threshold)) ++kept;
  return kept;
}

/** A box that holds most of the voxels: single ones far away do not count. */
export function boundsOf(
  layers: readonly VoxelLayer[],
  threshold: number,
): { min: [number, number, number]; max: [number, number, number] } | null {
  const axes: number[][] = [[], [], []];
  for (const layer of layers) {
    if (!layer.mesh.visible || !layer.arrays || !layer.voxels) continue;
    const step = Math.max(1, Math.floor(layer.voxels.count / 4000));
    for (let i = 0; i < layer.voxels.count; i += step)
      if (!isNoise(layer, i, threshold))
        layer.placeOf(i).forEach((value, axis) => axes[axis].push(value));
  }
  if (axes[0].length === 0) return null;
  const at = (values: number[], share: number): number =>
    values[Math.min(values.length - 1, Math.floor(share * values.length))];
  for (const values of axes) values.sort((a, b) => a - b);
  return {
    min: [at(axes[0], 0.002), at(axes[1], 0.002), at(axes[2], 0.002)],
    max: [at(axes[0], 0.998), at(axes[1], 0.998), at(axes[2], 0.998)],
  };
}

/** A voxel with its place among those of its stream. */
export interface PickedVoxel {
  layer: number;
  voxel: number;
  distance: number;
}

/** The first voxel that a ray meets. */
export function pick(
  layers: readonly VoxelLayer[],
  origin: readonly [number, number, number],
  direction: readonly [number, number, number],
  scale: number,
  rule: DrawingRule,
): PickedVoxel | null {
  let best: PickedVoxel | null = null;
  layers.forEach((layer, layerIndex) => {
    if (!layer.mesh.visible || !layer.arrays) return;
    const positions = layer.arrays.positions;
    const count = positions.length / 3;
    // In the coordinates of the frame voxels are along the axes.
    const inverse = layer.pose.clone().invert();
    const from = new Vector3(...origin).applyMatrix4(inverse).toArray();
    const towards = new Vector3(...direction).transformDirection(inverse).toArray();
    const half = 0.5 * layer.edge * Math.max(scale, 0.5);
    for (let i = 0; i < count; ++i) {
      let near = 0;
      let far = best ? best.distance : Infinity;
      for (let axis = 0; axis < 3; ++axis) {
        const toCentre = positions[3 * i + axis] - from[axis];
        const a = (toCentre - half) / towards[axis];
        const b = (toCentre + half) / towards[axis];
        near = Math.max(near, Math.min(a, b));
        far = Math.min(far, Math.max(a, b));
      }
      if (near > far || near === 0) continue;
      if (rule.hidesNoise && isNoise(layer, i, rule.threshold)) continue;
      best = { layer: layerIndex, voxel: i, distance: near };
    }
  });
  return best;
}
