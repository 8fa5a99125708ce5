// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** What is in the clouds: that of native decoding. */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapStreamReader } from "@mcap/core";

import { data, streamNames } from "../../codec/test/files.mjs";
import { buildReference, decodedNatively } from "../../codec/test/reference.mjs";
import { cellRecording, pathInFolder, pclExt } from "../../test/support/fixtures.mjs";
import { fieldsOf, isSame, messageOf, startApplication } from "./application.mjs";
import { codec, streamOf } from "./recordings.mjs";

test("intensities, colours and numbers of points in streams of all kinds", async () => {
  const application = startApplication();
  const found = new Set();
  for (const name of (await streamNames("golden/")).filter((each) => each !== "disorder")) {
    const { frames, voxels } = streamOf(fileURLToPath(new URL(`golden/${name}.pcxi`, data)));
    for (const [i, frame] of frames.entries()) {
      const cloud = application.convert(name, messageOf(frame));
      assert.ok(isSame(cloud, voxels[i]), `frame ${i} of ${name}`);
      for (const field of cloud.fields) found.add(field.name);
    }
  }
  for (const name of ["intensity", "red", "alpha", "point_count"]) assert.ok(found.has(name), name);
  assert.deepEqual(application.alerts, []);
});

test("a recording as an application reads it, with two topics", () => {
  const application = startApplication();
  const reader = new McapStreamReader();
  const recording = cellRecording(20, 2);
  reader.append(readFileSync(recording));
  const schemas = new Map();
  const channels = new Map();
  const shown = new Map();
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type !== "Message") continue;
    const { topic, schemaId } = channels.get(record.channelId);
    const { name, data: text } = schemas.get(schemaId);
    const definition = parse(new TextDecoder().decode(text), { ros2: true });
    const message = new MessageReader(definition).readMessage(record.data);
    const cloud = application.convert(topic, message, name);
    assert.equal(BigInt(cloud.timestamp.sec) * 1_000_000_000n + BigInt(cloud.timestamp.nsec), record.logTime);
    assert.equal(cloud.frame_id, message.header.frame_id);
    shown.set(topic, [...(shown.get(topic) ?? []), cloud]);
  }
  assert.equal(shown.size, 2);
  for (const [topic, clouds] of shown) {
    const path = pathInFolder(`${topic.replaceAll("/", "_")}.pcxi`);
    pclExt("cut", recording, "-o", path, "--streams", topic, "-q");
    const voxels = decodedNatively(path);
    assert.equal(clouds.length, 20);
    assert.ok(clouds.every((cloud, i) => isSame(cloud, voxels[i])), topic);
  }
});

test("further fields have their names, types and values", () => {
  // The points of a TestPoint, see reference.cpp: x, y, z, label, time, normal.
  const points = [
    [0.5, 0.5, 0.5, -7, 1700000000.125, 0.25, -1],
    [5.5, 2.5, -3.5, 2147483647, -Infinity, 1, 0.5],
  ];
  const view = new DataView(new ArrayBuffer(32 * points.length));
  points.forEach(([x, y, z, label, time, ...normal], i) => {
    [x, y, z].forEach((value, axis) => view.setFloat32(32 * i + 4 * axis, value, true));
    view.setInt32(32 * i + 12, label, true);
    view.setFloat64(32 * i + 16, time, true);
    normal.forEach((value, k) => view.setFloat32(32 * i + 24 + 4 * k, value, true));
  });
  const frame = execFileSync(buildReference(), ["encode", "0"], { input: new Uint8Array(view.buffer) });
  const cloud = startApplication().convert("/points", messageOf(new Uint8Array(frame)));
  const names = ["x", "y", "z", "label", "time", "normal_0", "normal_1"];
  assert.deepEqual(cloud.fields.map(({ name }) => name), names);
  assert.deepEqual(cloud.fields.map(({ offset }) => offset), [0, 4, 8, 12, 16, 24, 28]);
  assert.deepEqual(cloud.fields.map(({ type }) => type), [7, 7, 7, 6, 8, 7, 7]);
  assert.equal(cloud.point_stride, 32);
  const fields = fieldsOf(cloud);
  const decoded = points.map((_, i) => names.map((name) => fields[name][i]));
  assert.deepEqual(decoded.sort((a, b) => a[0] - b[0]), points);
});

/** Writes points of [x, y, z] as a binary PCD file with doubles. */
function writePcd(path, points, width = points.length) {
  const header = ["VERSION .7", "FIELDS x y z", "SIZE 8 8 8", "TYPE F F F", "COUNT 1 1 1", `WIDTH ${width}`,
    `HEIGHT ${points.length / width}`, `POINTS ${points.length}`, "DATA binary", ""].join("\n");
  writeFileSync(path, Buffer.concat([Buffer.from(header), Buffer.from(Float64Array.from(points.flat()).buffer)]));
}

/** The points of such a file, in its order; PCL's writer leaves zeros after them. */
function readPcd(path) {
  const bytes = readFileSync(path);
  const begin = bytes.indexOf("DATA binary\n") + "DATA binary\n".length;
  const [, count] = /FIELDS x y z\nSIZE 8 8 8\n[^]*POINTS (\d+)/.exec(bytes.toString("latin1", 0, begin));
  return Array.from({ length: Number(count) }, (_, i) =>
    [0, 1, 2].map((axis) => bytes.readDoubleLE(begin + 24 * i + 8 * axis)),
  );
}

test("a lidar of 256 rows, which are all in the header of an I-frame", () => {
  const points = Array.from({ length: 256 * 256 }, (_, i) => {
    const [row, column] = [Math.floor(i / 256), i % 256];
    const [azimuth, elevation] = [(2 * Math.PI * column) / 256, (row - 128) / 256];
    const ray = [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
    const range = Math.min(...ray.map((part, axis) => [4, 6, 2][axis] / Math.abs(part))); // a room
    return ray.map((part) => range * part);
  });
  const [cloud, recording] = ["lidar.pcd", "lidar.pcxi"].map((name) => pathInFolder(name));
  writePcd(cloud, points, 256);
  pclExt("encode", cloud, "-o", recording, "-r", 0.005, "--law", "none", "--keep-points", "-q");
  const { frames, voxels } = streamOf(recording);
  assert.equal(codec.describeFrame(frames[0].subarray(0, 2048)).status.code, "Truncated");
  assert.ok(isSame(startApplication().convert("/lidar", messageOf(frames[0])), voxels[0]));
});

test("coordinates of maps keep their precision: the pose has their offset", () => {
  const utm = [691234.5, 5335678.25, 520];
  const steps = Array.from({ length: 500 }, (_, i) => [i % 7, (i * 3) % 11, (i * 5) % 50]);
  const [cloud, recording, decoded] = ["map.pcd", "map.pcxi", "map"].map((name) => pathInFolder(name));
  writePcd(cloud, steps.map((step) => step.map((count, axis) => utm[axis] + 0.3 * count)));
  pclExt("encode", cloud, "-o", recording, "-r", 0.05, "--law", "none", "--overwrite", "-q");
  pclExt("decode", recording, "-o", decoded, "--pcd", "binary", "--overwrite", "-q");
  const expected = readPcd(`${decoded}/000000.pcd`);
  const { pose, ...points } = startApplication().convert("/map", messageOf(streamOf(recording).frames[0]));
  const { x, y, z } = fieldsOf(points);
  assert.equal(x.length, expected.length);
  const error = (value, i, axis) => Math.abs(value + Object.values(pose.position)[axis] - expected[i][axis]);
  [x, y, z].forEach((values, axis) => assert.ok(values.every((value, i) => error(value, i, axis) < 1e-5)));
});
