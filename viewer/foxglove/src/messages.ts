/** What the converter reads of a point_cloud_interfaces/msg/CompressedPointCloud2. */
export interface CompressedCloud {
  readonly header: { readonly stamp: Time; readonly frame_id: string };
  /** One frame. */
  readonly compressed_data: Uint8Array;
  readonly format: string;
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
