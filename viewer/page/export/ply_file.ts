// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { isDrawn } from "../scene/drawn_voxels";
import type { DrawingRule } from "../scene/drawn_voxels";
import type { VoxelLayer } from "../scene/voxel_layer";

/** A stream's voxels with its number in the file. */
export interface ExportedLayer {
  layer: VoxelLayer;
  stream: number;
  name: string;
}

/** Floats hold coordinates up to it to a quarter of a millimetre. */
const farthestFloat = 8192;

/** Whether coordinates are saved as doubles, as those of maps. */
function needsDoubles({ layer: { box } }: ExportedLayer): boolean {
  return !box.isEmpty() && [...box.min.toArray(), ...box.max.toArray()].some((value) => Math.abs(value) > farthestFloat);
}

function inOneLine(text: string): string {
  return text.replaceAll(/[\r\n]/g, " ");
}

/** A binary PLY file of the voxels that are drawn; null if there is none. Of each its centre, intensity and stream,
 * and points and colour where they are known. */
export function plyOf(layers: readonly ExportedLayer[], rule: DrawingRule, comment: string): Blob | null {
  const chosen: { entry: ExportedLayer; voxel: number }[] = [];
  for (const entry of layers)
    for (let i = 0; i < (entry.layer.voxels?.count ?? 0); ++i)
      if (isDrawn(entry.layer, i, rule)) chosen.push({ entry, voxel: i });
  if (chosen.length === 0) return null;
  const hasColours = layers.some(({ layer }) => layer.voxels?.hasColours);
  const isFar = layers.some(needsDoubles);
  const hasCounts = layers.some(({ layer }) => layer.voxels?.hasPointCounts);
  const header = [
    "ply",
    "format binary_little_endian 1.0",
    `comment ${inOneLine(comment)}`,
    "comment points are centres of voxels",
    ...layers.map(({ stream, name, layer }) =>
      `comment stream ${stream} is ${inOneLine(name)}, voxel edge ${Number(layer.edge.toPrecision(6))} m`),
    `element vertex ${chosen.length}`,
    ...["x", "y", "z"].map((axis) => `property ${isFar ? "double" : "float"} ${axis}`),
    "property float intensity",
    "property ushort stream",
    ...(hasCounts ? ["property uint points"] : []),
    ...(hasColours ? ["property uchar red", "property uchar green", "property uchar blue"] : []),
    "end_header", "",
  ].join("\n");
  const size = (isFar ? 30 : 18) + (hasCounts ? 4 : 0) + (hasColours ? 3 : 0);
  const view = new DataView(new ArrayBuffer(size * chosen.length));
  let at = 0;
  for (const { entry, voxel } of chosen) {
    const arrays = entry.layer.arrays;
    if (!arrays) continue;
    for (const value of entry.layer.placeOf(voxel)) {
      if (isFar) view.setFloat64(at, value, true);
      else view.setFloat32(at, value, true);
      at += isFar ? 8 : 4;
    }
    view.setFloat32(at, arrays.intensities[voxel], true);
    view.setUint16(at + 4, entry.stream, true);
    at += 6;
    if (hasCounts) {
      view.setUint32(at, arrays.pointCounts[voxel], true);
      at += 4;
    }
    for (let c = 0; hasColours && c < 3; ++c) view.setUint8(at++, arrays.paint[4 * voxel + c]);
  }
  return new Blob([header, view.buffer], { type: "application/octet-stream" });
}
