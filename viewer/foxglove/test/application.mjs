// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// An application that has the extension, as far as converters of messages see it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { isDeepStrictEqual } from "node:util";
import { strFromU8, unzipSync } from "fflate";

const { version } = JSON.parse(readFileSync(new URL("../package.json", import.meta.url), "utf8"));
export const archivePath = new URL(`../dist/pcl_ext-${version}.foxe`, import.meta.url);
export const inArchive = unzipSync(readFileSync(archivePath));
export const ros2Name = "point_cloud_interfaces/msg/CompressedPointCloud2";
export const ros1Name = "point_cloud_interfaces/CompressedPointCloud2";

/** Loads the extension as Lichtblick does, and tells what it registers and says. */
export function startApplication() {
  const module = { exports: {} };
  const run = new Function("module", "require", strFromU8(inArchive["dist/extension.js"]));
  run(module, () => undefined);
  const converters = [];
  module.exports.activate({ mode: "production", registerMessageConverter: (one) => converters.push(one) });
  const alerts = [];
  const listed = new Map(); // by the ids
  const emitAlert = (alert, id) => {
    if (isDeepStrictEqual(listed.get(id), alert)) return;
    listed.set(id, alert);
    alerts.push({ ...alert, id });
  };
  return {
    converters,
    /** What came into the list of alerts, which ignores one that is there already. */
    alerts,
    /** As when another recording is opened. */
    clearAlerts() {
      alerts.length = 0;
      listed.clear();
    },
    /** What a panel gets of a message, if that is the message's own cloud, and not an older one that is kept. */
    convertNew(topic, message, schemaName) {
      const cloud = this.convert(topic, message, schemaName);
      return isDeepStrictEqual(cloud?.timestamp, message.header.stamp) ? cloud : undefined;
    },
    /** What a panel gets of a message. */
    convert(topic, message, schemaName = ros2Name) {
      const event = { topic, schemaName, receiveTime: { sec: 0, nsec: 0 }, message, sizeInBytes: 0 };
      const { converter } = converters.find(({ fromSchemaName }) => fromSchemaName === schemaName);
      return converter(message, event, {}, { emitAlert });
    },
  };
}

let messages = 0;

/** Each has a time of its own, unless it is given. */
export function messageOf(frame, { sec = 1, nsec = ++messages, frameId = "map", format = "pcl_ext/version1" } = {}) {
  return Object.freeze({ header: { stamp: { sec, nsec }, frame_id: frameId }, compressed_data: frame, format });
}

const readers = [null, "getUint8", "getInt8", "getUint16", "getInt16", "getUint32", "getInt32", "getFloat32", "getFloat64"];

/** The fields of a foxglove.PointCloud by their names: arrays of numbers. */
export function fieldsOf({ fields, point_stride: stride, data }) {
  assert.equal(data.length % stride, 0);
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const count = data.length / stride;
  const read = ({ offset, type }) =>
    Array.from({ length: count }, (_, i) => view[readers[type]](i * stride + offset, true));
  return Object.fromEntries(fields.map((field) => [field.name, read(field)]));
}

const comparedClouds = new WeakMap(); // by the voxels that they were equal to

/** Whether a cloud has exactly the voxels that the native codec decodes. */
export function isSame(cloud, voxels) {
  const { pose, fields, data } = cloud;
  const compared = comparedClouds.get(voxels);
  if (compared) return isDeepStrictEqual({ pose, fields }, compared.layout) && Buffer.compare(data, compared.data) === 0;
  const isEqual = hasValues(fieldsOf(cloud), voxels) && hasPositions(cloud, voxels);
  if (isEqual) comparedClouds.set(voxels, { layout: { pose, fields }, data });
  return isEqual;
}

/** Equal, or where the pose has an offset, equal but for the rounding of two floats. */
function hasPositions(cloud, { count, positions }) {
  const { x, y, z } = fieldsOf(cloud);
  const offset = Object.values(cloud.pose.position);
  const isFar = offset.some((coordinate) => coordinate !== 0);
  const most = isFar ? 2 ** -22 * positions.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0) : 0;
  const isNear = (value, i, axis) => Math.abs(value + offset[axis] - positions[3 * i + axis]) <= most;
  return (
    isDeepStrictEqual(cloud.pose.orientation, { x: 0, y: 0, z: 0, w: 1 }) &&
    [x, y, z].every((values, axis) => values.length === count && values.every((value, i) => isNear(value, i, axis)))
  );
}

function hasValues(fields, { count, intensities, colours, pointCounts }) {
  const has = (names, values) =>
    names.every((name, first) => {
      if (values === null) return !(name in fields);
      const isEqual = (value, i) => value === values[first + i * names.length];
      return fields[name].length === count && fields[name].every(isEqual);
    });
  return (
    has(["intensity"], intensities) &&
    has(["red", "green", "blue"], colours) &&
    has(["alpha"], colours && new Uint8Array(count).fill(255)) &&
    has(["point_count"], pointCounts)
  );
}
