// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { CdrReader } from "./cdr";
import type { StampedTransform } from "./transforms";

/** The types of /tf and /tf_static: of ROS 2, of ROS 1, and of ROS 1 before tf2. */
const types = ["tf2_msgs/msg/TFMessage", "tf2_msgs/TFMessage", "tf/tfMessage"];

export function isTransformType(type: string): boolean {
  return types.includes(type);
}

/** True for the topic of transforms that do not change; it may be in a namespace. */
export function isStaticTopic(topic: string): boolean {
  return /(^|\/)tf_static$/.test(topic);
}

/** The layout that ROS 1 writes: without gaps between values, and strings without a zero at their end. */
class Ros1Reader {
  private readonly view: DataView;
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  u32(): number {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }

  f64(): number {
    this.at += 8;
    return this.view.getFloat64(this.at - 8, true);
  }

  string(): string {
    const size = this.u32();
    if (size > this.bytes.length - this.at) throw new RangeError("the message ends early");
    this.at += size;
    return new TextDecoder().decode(this.bytes.subarray(this.at - size, this.at));
  }
}

/** In ROS 1 names may begin with a slash, and mean the same. */
function frameName(name: string): string {
  return name.replace(/^\//, "");
}

/** Null if the bytes are no such message. */
export function readTransforms(bytes: Uint8Array, encoding: string): StampedTransform[] | null {
  try {
    const isRos1 = encoding === "ros1";
    const reader = isRos1 ? new Ros1Reader(bytes) : new CdrReader(bytes);
    const transforms: StampedTransform[] = [];
    for (let count = reader.u32(); count > 0; --count) {
      if (isRos1) reader.u32(); // seq
      const seconds = isRos1 ? reader.u32() : reader.u32() | 0;
      const stamp = 1e9 * seconds + reader.u32();
      const parent = frameName(reader.string());
      const child = frameName(reader.string());
      const [x, y, z, qx, qy, qz, qw] = Array.from({ length: 7 }, () => reader.f64());
      transforms.push({ parent, child, stamp, pose: [x, y, z, qx, qy, qz, qw] });
    }
    return transforms;
  } catch {
    return null;
  }
}
