// An application that has the extension, as far as converters of messages see it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
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
  return {
    converters,
    alerts,
    /** What a panel gets of a message. */
    convert(topic, message, schemaName = ros2Name) {
      const event = { topic, schemaName, receiveTime: message.header.stamp, message, sizeInBytes: 0 };
      const { converter } = converters.find(({ fromSchemaName }) => fromSchemaName === schemaName);
      return converter(message, event, {}, { emitAlert: (alert, id) => alerts.push({ ...alert, id }) });
    },
  };
}

export function messageOf(frame, { sec = 1, nsec = 2, frameId = "map", format = "pcl_ext/version1" } = {}) {
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

/** Whether a cloud has exactly the voxels that the native codec decodes. */
export function isSame(cloud, { count, positions, intensities, colours, pointCounts }) {
  const fields = fieldsOf(cloud);
  const equal = (name, values, first = 0, step = 1) =>
    fields[name].length === count && fields[name].every((value, i) => value === values[first + i * step]);
  const triples = (names, values) => names.every((name, axis) => equal(name, values, axis, 3));
  return (
    Object.values(cloud.pose.position).every((coordinate) => coordinate === 0) &&
    triples(["x", "y", "z"], positions) &&
    (intensities ? equal("intensity", intensities) : true) &&
    (colours ? triples(["red", "green", "blue"], colours) && fields.alpha.every((a) => a === 255) : !("red" in fields)) &&
    (pointCounts ? equal("point_count", pointCounts) : !("point_count" in fields))
  );
}
