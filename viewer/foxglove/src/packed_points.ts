// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import {
  type Decoder,
  type FieldDescription,
  isPackedColour,
  localPositions,
  needsDoubles,
  type Voxels,
} from "@pcl_ext/codec";

import type { PackedPoints } from "./messages";

/** How foxglove.PackedElementField calls a type, and how it is written. */
const numericTypes = {
  uint8: { id: 1, size: 1, set: (view: DataView, at: number, value: number) => view.setUint8(at, value) },
  int8: { id: 2, size: 1, set: (view: DataView, at: number, value: number) => view.setInt8(at, value) },
  uint16: { id: 3, size: 2, set: (view: DataView, at: number, value: number) => view.setUint16(at, value, true) },
  int16: { id: 4, size: 2, set: (view: DataView, at: number, value: number) => view.setInt16(at, value, true) },
  uint32: { id: 5, size: 4, set: (view: DataView, at: number, value: number) => view.setUint32(at, value, true) },
  int32: { id: 6, size: 4, set: (view: DataView, at: number, value: number) => view.setInt32(at, value, true) },
  float32: { id: 7, size: 4, set: (view: DataView, at: number, value: number) => view.setFloat32(at, value, true) },
  float64: { id: 8, size: 8, set: (view: DataView, at: number, value: number) => view.setFloat64(at, value, true) },
} as const;

/** The values of a field: those at `first`, `first + step`, ... */
interface Column {
  type: FieldDescription["type"];
  values: ArrayLike<number>;
  first?: number;
  step?: number;
}

/** One point for each voxel of a decoder's last frame, at the voxel's centre.
 * @returns null if memory was short
 */
export function packPoints(voxels: Voxels, decoder: Decoder): PackedPoints | null {
  const { origin, positions } = needsDoubles(voxels.grid) ? localPositions(voxels)
    : { origin: [0, 0, 0], positions: voxels.positions };
  const columns = new Map<string, Column>();
  const add = (name: string, column: Column) => columns.set(freeName(name, columns), column);
  ["x", "y", "z"].forEach((name, first) => add(name, { type: "float32", values: positions, first, step: 3 }));
  const { count, intensities, colours, pointCounts } = voxels;
  // As when clouds are decoded natively, a field takes the place of an intensity of its name.
  const hasIntensityField = voxels.fields.some(({ name, count: values }) => name === "intensity" && values === 1);
  if (intensities && !hasIntensityField) add("intensity", { type: "float32", values: intensities });
  if (colours) {
    ["red", "green", "blue"].forEach((name, first) =>
      add(name, { type: "uint8", values: colours, first, step: 3 }),
    );
    add("alpha", { type: "uint8", values: new Uint8Array(count).fill(255) });
  }
  if (pointCounts) add("point_count", { type: "uint32", values: pointCounts });
  for (const [index, field] of voxels.fields.entries()) {
    if (colours && isPackedColour(field)) continue;
    for (let i = 0; i < field.count; ++i) {
      const name = field.count === 1 ? field.name : `${field.name}_${i}`;
      const { values } = decoder.fieldValues(index, i);
      if (!values) return null;
      add(name, { type: field.type, values });
    }
  }
  const [x, y, z] = origin;
  const pose = { position: { x, y, z }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
  return { pose, ...interleave(columns, count) };
}

/** A name that no column has: "_" is added to one that is taken, as decoding in Python does. */
function freeName(name: string, columns: ReadonlyMap<string, Column>): string {
  while (columns.has(name)) name += "_";
  return name;
}

function interleave(columns: Map<string, Column>, count: number): Omit<PackedPoints, "pose"> {
  let point_stride = 0;
  const fields = [...columns].map(([name, { type }]) => {
    const offset = point_stride;
    point_stride += numericTypes[type].size;
    return { name, offset, type: numericTypes[type].id };
  });
  const data = new Uint8Array(count * point_stride);
  const view = new DataView(data.buffer);
  let at = 0;
  for (const { type, values, first = 0, step = 1 } of columns.values()) {
    const { set, size } = numericTypes[type];
    for (let i = 0; i < count; ++i) set(view, at + i * point_stride, values[first + i * step] as number);
    at += size;
  }
  return { point_stride, fields, data };
}
