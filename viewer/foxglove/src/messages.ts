// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** What the converter reads of a point_cloud_interfaces/msg/CompressedPointCloud2. */
export interface CompressedCloud {
  readonly header: Header;
  /** One frame. */
  readonly compressed_data: Uint8Array;
  readonly format: string;
}

export interface Header {
  readonly stamp: Time;
  readonly frame_id: string;
}

/** Why a message cannot be decoded, or null. The decoder would take another type than bytes for a failure of its own,
 * and begin anew.
 * @param message what an application gives, a CompressedCloud or anything else
 */
export function faultOf(message: unknown): { kind: "Message" | "Format"; problem: string } | null {
  const { header, compressed_data: data, format } = fieldsOf(message);
  if (typeof format !== "string") return { kind: "Message", problem: "a message has no format" };
  if (!/^pcl_ext(\/|$)/.test(format)) return { kind: "Format", problem: `format ‘${format}’ is not of pcl_ext` };
  const { stamp, frame_id: frameId } = fieldsOf(header);
  const { sec, nsec } = fieldsOf(stamp);
  if (typeof frameId !== "string" || typeof sec !== "number" || typeof nsec !== "number")
    return { kind: "Message", problem: "a message has no header with stamp and frame_id" };
  // By name, as the bytes may come from another realm, with another Uint8Array.
  if (Object.prototype.toString.call(data) !== "[object Uint8Array]" || (data as Uint8Array).length === 0)
    return { kind: "Message", problem: "a message has no bytes of type Uint8Array" };
  return null;
}

function fieldsOf(value: unknown): Readonly<Record<string, unknown>> {
  return typeof value === "object" && value !== null ? (value as Record<string, unknown>) : {};
}

export interface Time {
  readonly sec: number;
  readonly nsec: number;
}

/** A foxglove.PointCloud. */
export interface PointCloud extends PackedPoints {
  timestamp: Time;
  frame_id: string;
}

export function cloudOf({ stamp, frame_id }: Header, points: PackedPoints): PointCloud {
  return { timestamp: stamp, frame_id, ...points };
}

/** The part of it that a frame determines. */
export interface PackedPoints {
  /** Where the origin of the points is in the coordinates of frame_id. */
  pose: {
    position: { x: number; y: number; z: number };
    orientation: { x: number; y: number; z: number; w: number };
  };
  point_stride: number;
  fields: { name: string; offset: number; type: number }[];
  data: Uint8Array;
}
