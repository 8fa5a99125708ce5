// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Values of fields are those that the encoder was given. */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";

import { loadCodec, stream, streamNames } from "./files.mjs";
import { buildReference } from "./reference.mjs";

const program = buildReference();

/** Points in voxels of 1 m: where, label, time, normal. Sums of their values are exact. */
const points = [
  [[0.5, 0.5, 0.5], -7, 1700000000.125, [0.25, -1]],
  [[1.2, 0.5, 0.5], 3, 1700000000.25, [1, 0]],
  [[1.4, 0.5, 0.5], -2, 1700000000.75, [2, NaN]],
  [[1.6, 0.5, 0.5], -2, 1700000000.5, [6, 0]],
  [[1.8, 0.5, 0.5], 3, 1700000000.5, [3, 0]],
  [[5.5, 2.5, -3.5], 2147483647, -Infinity, [NaN, 0.5]],
  [[5.5, 3.2, -3.5], -2147483648, 0.1, [0.1, 1]],
  [[5.5, 3.4, -3.5], 40, 0.1, [0.1, 2]],
  [[5.5, 3.6, -3.5], 40, 0.1, [0.1, 4]],
];

/** The same of voxels: of the labels the most frequent or lowest, of the others the mean without NaN. */
const voxels = new Map([
  ["0,0,0", [-7, 1700000000.125, [0.25, -1]]],
  ["1,0,0", [-2, 1700000000.5, [3, 0]]],
  ["5,2,-4", [2147483647, -Infinity, [NaN, 0.5]]],
  ["5,3,-4", [40, (0.1 + 0.1 + 0.1) / 3, [Math.fround(0.1), Math.fround(7 / 3)]]],
]);

/** The points as the program takes them. */
function bytesOfPoints() {
  const view = new DataView(new ArrayBuffer(32 * points.length));
  points.forEach(([position, label, time, normal], i) => {
    position.forEach((value, axis) => view.setFloat32(32 * i + 4 * axis, value, true));
    view.setInt32(32 * i + 12, label, true);
    view.setFloat64(32 * i + 16, time, true);
    normal.forEach((value, k) => view.setFloat32(32 * i + 24 + 4 * k, value, true));
  });
  return new Uint8Array(view.buffer);
}

const fields = [
  { name: "label", type: "int32", count: 1 },
  { name: "time", type: "float64", count: 1 },
  { name: "normal", type: "float32", count: 2 },
];

for (const [what, hasCounts] of [["points", 1], ["voxels", 0]])
  test(`fields of ${what}`, async () => {
    const codec = await loadCodec();
    const decoder = codec.createDecoder();
    const frame = execFileSync(program, ["encode", String(hasCounts)], { input: bytesOfPoints() });
    const decoded = decoder.decode(new Uint8Array(frame)).voxels;
    assert.deepEqual(decoded.fields, fields);
    assert.equal(decoded.pointCounts !== null, hasCounts === 1);
    assert.equal(decoded.count, voxels.size);
    const valuesOf = (field, value) => {
      const { status, values } = decoder.fieldValues(field, value);
      assert.ok(status.ok);
      assert.equal(values.length, decoded.count);
      return values;
    };
    const [labels, times, ...normals] = [valuesOf(0), valuesOf(1), valuesOf(2, 0), valuesOf(2, 1)];
    for (let i = 0; i < decoded.count; ++i) {
      const place = decoded.positions.subarray(3 * i, 3 * i + 3).map(Math.floor).join();
      assert.deepEqual([labels[i], times[i], normals.map((values) => values[i])], voxels.get(place), place);
    }
    for (const wrong of [[3], [0, 1], [2, 2], [-1], [NaN, 4096]])
      assert.throws(() => decoder.fieldValues(...wrong), { code: "InvalidInput" });
    assert.equal(decoder.decode(new Uint8Array(frame).subarray(1)).voxels, null);
    assert.equal(decoder.fieldValues(0).status.code, "NoDecodedFrame");
    decoder.free();
    assert.throws(() => decoder.fieldValues(0), { code: "InvalidInput" });
  });

test("the limit of values is that of the decoder", async () => {
  const codec = await loadCodec();
  const frame = new Uint8Array(execFileSync(program, ["encode", "1"], { input: bytesOfPoints() }));
  const most = 4 * points.length;
  const statusWith = (maxFieldValues) => codec.createDecoder({ maxFieldValues }).decode(frame).status.code;
  assert.deepEqual([statusWith(most), statusWith(most - 1)], ["Ok", "LimitExceeded"]);
});

test("each field of the golden streams has as many values as voxels", async () => {
  const names = (await streamNames("golden/")).filter((name) => /fields|scans|colours/.test(name));
  const found = new Set();
  for (const name of names) {
    const decoder = (await loadCodec()).createDecoder();
    const bytes = await stream(`golden/${name}.pcxi`);
    for (let at = 0; at < bytes.length; ) {
      const { status, voxels, bytesRead } = decoder.decode(bytes.subarray(at));
      assert.ok(status.ok);
      at += bytesRead;
      for (const [field, { name, type, count }] of voxels.fields.entries()) {
        found.add(`${name} ${type} ${count}`);
        for (let value = 0; value < count; ++value)
          assert.equal(decoder.fieldValues(field, value).values.length, voxels.count);
      }
    }
  }
  assert.ok(found.size >= 5, [...found].join());
});
