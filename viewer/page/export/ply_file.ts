// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { PackedVoxels } from "../decoding/messages";
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

interface Property {
  type: "float" | "double" | "ushort" | "uint" | "uchar";
  name: string;
  of: (entry: ExportedLayer, voxel: number) => number;
}

const bytesOf = { float: 4, double: 8, ushort: 2, uint: 4, uchar: 1 };

function write(view: DataView, at: number, type: Property["type"], value: number): void {
  if (type === "double") view.setFloat64(at, value, true);
  else if (type === "float") view.setFloat32(at, value, true);
  else if (type === "uint") view.setUint32(at, value, true);
  else if (type === "ushort") view.setUint16(at, value, true);
  else view.setUint8(at, value);
}

/** What is written of each voxel: what one of the streams has. */
function propertiesOf(layers: readonly ExportedLayer[]): Property[] {
  const properties: Property[] = [];
  const add = (type: Property["type"], name: string, of: Property["of"]): void => {
    properties.push({ type, name, of });
  };
  const some = (has: (voxels: PackedVoxels) => boolean): boolean =>
    layers.some(({ layer }) => layer.voxels !== null && has(layer.voxels));
  const isFar = layers.some(needsDoubles);
  ["x", "y", "z"].forEach((name, axis) => {
    add(isFar ? "double" : "float", name, ({ layer }, voxel) => layer.coordinateOf(voxel, axis));
  });
  if (some((voxels) => voxels.hasIntensities))
    add("float", "intensity", ({ layer }, voxel) =>
      layer.voxels?.hasIntensities && layer.arrays ? layer.arrays.intensities[voxel] : NaN);
  add("ushort", "stream", ({ stream }) => stream);
  if (some((voxels) => voxels.hasPointCounts))
    add("uint", "points", ({ layer }, voxel) => layer.arrays?.pointCounts[voxel] ?? 0);
  if (some((voxels) => voxels.hasColours))
    ["red", "green", "blue"].forEach((name, channel) => {
      add("uchar", name, ({ layer }, voxel) => layer.arrays?.paint[4 * voxel + channel] ?? 0);
    });
  const field = layers.map(({ layer }) => layer.voxels?.field).find((name) => name);
  if (field) {
    let unique = field.replaceAll(/\s/g, "_");
    while (properties.some(({ name }) => name === unique)) unique += "_";
    add("double", unique, ({ layer }, voxel) => layer.arrays?.field?.[voxel] ?? NaN);
  }
  return properties;
}

/** A binary PLY file of the voxels that are drawn; null if there is none. Of each its centre and stream, and what is
 * known of intensity, points, colour, and the field that colours it. */
export function plyOf(layers: readonly ExportedLayer[], rule: DrawingRule, comment: string): Blob | null {
  const chosen: { entry: ExportedLayer; voxel: number }[] = [];
  for (const entry of layers)
    for (let i = 0; i < (entry.layer.voxels?.count ?? 0); ++i)
      if (isDrawn(entry.layer, i, rule)) chosen.push({ entry, voxel: i });
  if (chosen.length === 0) return null;
  const properties = propertiesOf(layers);
  const header = [
    "ply",
    "format binary_little_endian 1.0",
    `comment ${inOneLine(comment)}`,
    "comment points are centres of voxels",
    ...layers.map(({ stream, name, layer }) =>
      `comment stream ${stream} is ${inOneLine(name)}, voxel edge ${Number(layer.edge.toPrecision(6))} m`),
    `element vertex ${chosen.length}`,
    ...properties.map(({ type, name }) => `property ${type} ${name}`),
    "end_header", "",
  ].join("\n");
  const size = properties.reduce((sum, { type }) => sum + bytesOf[type], 0);
  const view = new DataView(new ArrayBuffer(size * chosen.length));
  let at = 0;
  for (const { entry, voxel } of chosen)
    for (const { type, of } of properties) {
      write(view, at, type, of(entry, voxel));
      at += bytesOf[type];
    }
  return new Blob([header, view.buffer], { type: "application/octet-stream" });
}
