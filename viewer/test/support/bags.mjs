// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Bags of clouds and transforms, as robots record them.
import { writeFileSync } from "node:fs";

import { beginMcap } from "./mcap_file.mjs";

/** Writes values as messages of ROS 2 have them, in CDR, or as those of ROS 1. */
class MessageWriter {
  constructor(isRos1) {
    this.isRos1 = isRos1;
    this.bytes = isRos1 ? [] : [0, 1, 0, 0];
  }

  number(size, write) {
    while (!this.isRos1 && (this.bytes.length - 4) % size !== 0) this.bytes.push(0);
    const value = Buffer.alloc(size);
    write(value);
    this.bytes.push(...value);
  }

  u8(value) { this.number(1, (to) => to.writeUInt8(value)); }
  u32(value) { this.number(4, (to) => to.writeUInt32LE(value)); }
  f64(value) { this.number(8, (to) => to.writeDoubleLE(value)); }

  string(text) {
    const bytes = [...Buffer.from(text), ...(this.isRos1 ? [] : [0])];
    this.u32(bytes.length);
    this.bytes.push(...bytes);
  }

  header(seconds, frameId) {
    if (this.isRos1) this.u32(0); // seq
    this.u32(Math.floor(seconds));
    this.u32(Math.round(1e9 * (seconds % 1)));
    this.string(frameId);
  }
}

/** A PointCloud2 of points [x, y, z], of which doubles are FLOAT64. */
function cloudMessage({ time, frameId, points, isDouble = false }) {
  const writer = new MessageWriter(false);
  const size = isDouble ? 8 : 4;
  writer.header(time, frameId);
  writer.u32(1); // height
  writer.u32(points.length);
  writer.u32(3);
  ["x", "y", "z"].forEach((name, i) => {
    writer.string(name);
    writer.u32(size * i);
    writer.u8(isDouble ? 8 : 7);
    writer.u32(1);
  });
  writer.u8(0);
  writer.u32(3 * size);
  writer.u32(3 * size * points.length);
  writer.u32(3 * size * points.length);
  const numbers = isDouble ? Float64Array.from(points.flat()) : Float32Array.from(points.flat());
  const bytes = Buffer.from(numbers.buffer);
  for (const byte of bytes) writer.bytes.push(byte);
  writer.u8(1);
  return Uint8Array.from(writer.bytes);
}

/** A TFMessage; poses are x, y, z, qx, qy, qz, qw. */
function transformMessage({ time, transforms }, isRos1) {
  const writer = new MessageWriter(isRos1);
  writer.u32(transforms.length);
  for (const { parent, child, pose, stamp = time } of transforms) {
    writer.header(stamp, parent);
    writer.string(child);
    pose.forEach((value) => writer.f64(value));
  }
  return Uint8Array.from(writer.bytes);
}

/** Writes a bag.
 * @param clouds { topic, time, frameId, points, isDouble } each, seconds and metres
 * @param transforms { isStatic, time, transforms: [{ parent, child, pose, stamp }] } each; stamps
 * are the time of the message where they are left out
 * @param isRos1 the transforms are messages of ROS 1, as encode keeps those of its bags
 */
export async function writeBag(path, clouds, transforms, isRos1 = false) {
  const { writer, bytes } = await beginMcap();
  const channels = new Map();
  const add = async (topic, type, isOfRos1, time, data) => {
    if (!channels.has(topic)) {
      const encoding = isOfRos1 ? "ros1msg" : "ros2msg";
      const schemaId = await writer.registerSchema({ name: type, encoding, data: new Uint8Array(0) });
      const messageEncoding = isOfRos1 ? "ros1" : "cdr";
      channels.set(topic, await writer.registerChannel({ schemaId, topic, messageEncoding, metadata: new Map() }));
    }
    const logTime = BigInt(Math.round(1e6 * time)) * 1000n;
    await writer.addMessage({ channelId: channels.get(topic), sequence: 0, logTime, publishTime: logTime, data });
  };
  const messages = [
    ...transforms.map((message) => ({ ...message, topic: message.isStatic ? "/tf_static" : "/tf" })),
    ...clouds,
  ].sort((a, b) => a.time - b.time);
  for (const message of messages)
    if (message.points) await add(message.topic, "sensor_msgs/msg/PointCloud2", false, message.time, cloudMessage(message));
    else
      await add(message.topic, isRos1 ? "tf2_msgs/TFMessage" : "tf2_msgs/msg/TFMessage", isRos1, message.time,
        transformMessage(message, isRos1));
  await writer.end();
  writeFileSync(path, bytes());
}
