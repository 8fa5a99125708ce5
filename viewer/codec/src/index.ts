// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
export { Codec, type CodecOptions } from "./codec.js";
export type { Decoder } from "./decoder.js";
export { type LocalPositions, localPositions, needsDoubles } from "./grid.js";
export type { OutlierFilter } from "./outlier_filter.js";
export {
  CodecError,
  type CodedVoxels,
  type DecodeOptions,
  type DecoderLimits,
  type DensityUnit,
  type FieldDescription,
  type FrameDescription,
  type Grid,
  type IntensityRange,
  isPackedColour,
  type OutlierFilterSettings,
  type Status,
  type StatusCode,
  type Voxels,
} from "./types.js";
