// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Outcomes of a call. See `CompressionCode` and `OutlierRemovalCode` of the C++ library;
 * the last two are this package's own. */
export type StatusCode =
  | (typeof compressionCodes)[number]
  | (typeof outlierRemovalCodes)[number]
  /** A decoder, or a filter about it, was asked for a frame that it has not, as after a failure. */
  | "NoDecodedFrame"
  /** The WebAssembly module failed in a way that should not happen. */
  | "Trap";

/** Names of CompressionCode, in its order. */
export const compressionCodes = [
  "Ok",
  "InvalidSettings",
  "InvalidInput",
  "OutputFailed",
  "EndOfStream",
  "NoFrame",
  "UnsupportedVersion",
  "Truncated",
  "Corrupt",
  "LimitExceeded",
  "MissingReference",
  "InputFailed",
  "OldFrame",
  "OutOfMemory",
] as const;

/** Names of OutlierRemovalCode, in its order. */
export const outlierRemovalCodes = [
  "Ok",
  "InvalidSettings",
  "UnsupportedResolution",
  "NoDensities",
  "DifferentCloud",
] as const;

/** Outcome of a call: a code for programs and a message for people. */
export interface Status {
  readonly ok: boolean;
  readonly code: StatusCode;
  /** What is wrong; with `ok` a warning, or empty. English, one line. */
  readonly message: string;
}

/** @internal */
export const ok: Status = { ok: true, code: "Ok", message: "" };

/** Of calls that ask for the last frame where there is none.
 * @internal */
export const noDecodedFrame: Status = {
  ok: false,
  code: "NoDecodedFrame",
  message: "the decoder has not decoded its last frame, or none yet",
};

/** Thrown where there is no status to return. */
export class CodecError extends Error {
  readonly code: StatusCode;
  /** `Codec.frameSize`: bytes to drop, after which a frame may begin; else 0. */
  readonly bytesToSkip: number;

  constructor(code: StatusCode, message: string, bytesToSkip = 0) {
    super(message);
    this.name = "CodecError";
    this.code = code;
    this.bytesToSkip = bytesToSkip;
  }
}

/** Limits of decoding, for bytes that are not trusted; whole numbers from 1 to 2^32 - 1. A decoder
 * also refuses frames of few bytes and much content: more than 2^23 voxels, 2^20 blocks of 4 x 4 x 4
 * voxels, 2^24 points or 2^26 values of fields, if there is no byte for 64, 8, 256 or 512 of them. */
export interface DecoderLimits {
  /** Bytes of one frame, and bytes skipped while looking for one. Default: 2^28. */
  readonly maxFrameBytes?: number;
  /** Voxels of one frame, or points of one that has these in order. Default: 2^26, at most 2^28. */
  readonly maxVoxels?: number;
  /** Points of one frame, where voxels have numbers of points, or rows * columns of one that has
   * its points in order. Default: 2^30; above
   * 16 `maxVoxels` counts as that. */
  readonly maxPoints?: number;
  /** Values of the fields of one frame, of eight bytes each. Default: 2^30. */
  readonly maxFieldValues?: number;
}

/** Intensities of a stream: `min` + number * `step`. */
export interface IntensityRange {
  /** The lowest intensity that a voxel can have, in the unit of the stream. */
  readonly min: number;
  /** The highest one. */
  readonly max: number;
  /** From one number to the next. Companded scales do not have all numbers. */
  readonly step: number;
  /** There are at most 2^bits different intensities; 1 to 16. */
  readonly bits: number;
  /** The highest number of a companded scale; 0: a linear scale, which has all numbers. */
  readonly compandedRange: number;
}

/** The grid of a frame's voxels, axis-aligned in the frame's coordinates. */
export interface Grid {
  /** Edge of a voxel, metres. */
  readonly resolution: number;
  /** x, y, z of the lattice's origin, metres. */
  readonly origin: readonly [number, number, number];
  /** Voxels from the origin to the grid's lower corner, along x, y and z. */
  readonly firstIndex: readonly [number, number, number];
  /** The grid has 2^depth voxels along each axis; 1 to 21. */
  readonly depth: number;
}

/** What a frame contains as coded: for those who need exact integers. */
export interface CodedVoxels {
  /** Morton keys, strictly ascending: bit 3n of a key is bit n of the voxel's position
   * along z from the grid's lower corner, bit 3n + 1 that along y, bit 3n + 2 along x. */
  readonly keys: BigUint64Array;
  /** Symbols of the intensity scale; null without intensities. */
  readonly symbols: Uint16Array | null;
}

/** Datatypes of fields, in the order of FieldType. */
export const fieldTypes = [
  "int8",
  "uint8",
  "int16",
  "uint16",
  "int32",
  "uint32",
  "float32",
  "float64",
] as const;

/** A further field of the points or voxels, as ring, time or label. */
export interface FieldDescription {
  readonly name: string;
  readonly type: (typeof fieldTypes)[number];
  /** Values of a point. */
  readonly count: number;
}

/** Whether a field is the colour of each point in four bytes. Its mean over the points of a voxel is
 * no colour: `Voxels.colours` has that. */
export function isPackedColour({ name, count }: FieldDescription): boolean {
  return count === 1 && (name === "rgb" || name === "rgba");
}

/** A decoded frame. The arrays are copies that belong to the caller, who may transfer them
 * to another thread. All have the same order, that of the voxels' Morton keys. */
export interface Voxels {
  /** Number of voxels. */
  readonly count: number;
  /** [3 * count] x, y, z of the voxels' centres, metres, in the frame's coordinates. */
  readonly positions: Float32Array;
  /** [count] in the unit of the stream; null: the stream has none. */
  readonly intensities: Float32Array | null;
  /** [3 * count] red, green, blue, 0 to 255; null: the stream has none. */
  readonly colours: Uint8Array | null;
  /** [count] points in each voxel, from 1; null: the stream does not have them. */
  readonly pointCounts: Uint32Array | null;
  /** Further fields, whose values `Decoder.fieldValues` gives; empty: the stream has none. */
  readonly fields: readonly FieldDescription[];
  /** Edge of a voxel, metres. */
  readonly resolution: number;
  readonly grid: Grid;
  /** null without intensities. */
  readonly intensityRange: IntensityRange | null;
  /** Time of the frame, microseconds; null: the frame has none, or 0. */
  readonly stamp: bigint | null;
  /** Name of the coordinate frame; null: the frame has none, or an empty one. */
  readonly frameId: string | null;
  /** Decodes without other frames. */
  readonly isIFrame: boolean;
  /** Number of the frame in its stream, from 1. */
  readonly frameNumber: number;
  /** Bytes of the frame. */
  readonly bytes: number;
  /** Bytes before the frame that belong to none. */
  readonly skippedBytes: number;
  /** Only if asked for, see `DecodeOptions.coded`. */
  readonly coded: CodedVoxels | null;
}

export interface DecodeOptions {
  /** Also return `Voxels.coded`. Default: false. */
  readonly coded?: boolean;
}

/** What the header of a frame tells without the frames before it. */
export interface FrameDescription {
  readonly format: "version1" | "published";
  /** Number of the frame in its stream, from 1. */
  readonly frameNumber: number;
  /** "I" decodes without other frames. */
  readonly kind: "I" | "P";
  /** The whole frame; null: more bytes are needed to know it. */
  readonly bytes: number | null;
  /** null: the published layout, which has none. */
  readonly effort: "fast" | "balanced" | "small" | null;
  /** Number of voxels; null: P-frames of the published layout do not tell it. With points in order as
   * many as points: how many voxels these occupy is known when they are decoded. */
  readonly voxels: number | null;
  /** Points in the voxels: as many as voxels, unless these have numbers of points. Missing
   * points of an organised cloud are not among them. null where `voxels` is. */
  readonly points: number | null;
  /** I-frames only, else null. */
  readonly grid: Grid | null;
  /** Edge of a voxel, metres; I-frames only, else null. */
  readonly resolution: number | null;
  /** null: a P-frame, or no intensities. */
  readonly intensityRange: IntensityRange | null;
  /** Bits of a colour channel, 0: no colours; I-frames only, else null. */
  readonly colourBits: number | null;
  /** I-frames only, else null. */
  readonly hasPointCounts: boolean | null;
  /** Microseconds; null: a P-frame, or the frame has none. */
  readonly stamp: bigint | null;
  /** P-frames: microseconds from the last stamp of the stream; else null. */
  readonly stampDifference: bigint | null;
  /** Name of the coordinate frame; null: the frame has none, or a P-frame that has that of
   * the frame before it. */
  readonly frameId: string | null;
  /** The frame has its points in the order of their sensor. A decoder gives the voxels that these
   * occupy. */
  readonly hasPointsInOrder: boolean;
}

/** What the filter of outliers derives densities from, see `DensityUnit` of the library:
 * "faces" for the quadratic law of intensity, "points" for counts of depth cameras,
 * "rays" for snow, rain and dust in frames of lidars, "voxels" for native intensities or
 * none; "automatic" is "faces" from the first frame with a depth model on, else "rays" from
 * the first frame on that is the scan of a lidar, else "voxels". */
export type DensityUnit = (typeof densityUnits)[number];

/** Names of DensityUnit, in its order. */
export const densityUnits = ["automatic", "faces", "points", "voxels", "rays"] as const;

/** Settings that some units have. */
interface UnitSettings {
  /** Intensity of a completely covered voxel face, until a frame has a depth model. Finite,
   * above 0; default: 255. */
  readonly fullIntensity?: number;
  /** Position of the lidar in the coordinates of the voxels, metres, finite; frames that
   * are scans of a lidar have it themselves, and the angles. Default: [0, 0, 0]. */
  readonly sensorPosition?: readonly [number, number, number];
  /** Angles between rays of a row, and between rows, radians, 0.0001 to 1. Default: 0.0035
   * and 0.007, which are 0.2 and 0.4 degrees. */
  readonly azimuthStep?: number;
  readonly elevationStep?: number;
  /** Intensities are numbers of points (law count); used where frames have none themselves.
   * Else each voxel counts as one point. Default: false. */
  readonly intensitiesAreCounts?: boolean;
  /** Also use the voxels of previous frames. Default: true. */
  readonly useHistory?: boolean;
}

/** What each unit has of them. */
interface NamesOfUnits {
  automatic: "useHistory" | "intensitiesAreCounts";
  faces: "useHistory" | "fullIntensity";
  points: "useHistory";
  voxels: "useHistory";
  rays: "sensorPosition" | "azimuthStep" | "elevationStep" | "intensitiesAreCounts";
}

type SettingsOf<Unit extends DensityUnit> = Pick<UnitSettings, NamesOfUnits[Unit]>;

/** See `VoxelOutlierRemovalSettings` of the library: those of a unit, by default
 * "automatic", and those of all units. */
export type OutlierFilterSettings = (
  | ({ readonly unit?: "automatic" } & SettingsOf<"automatic">)
  | { [Unit in DensityUnit]: { readonly unit: Unit } & SettingsOf<Unit> }[DensityUnit]
) & {
  /** Voxels of lower log-odds (natural logarithm) are noise. Finite; default: 0. */
  readonly minLogOdds?: number;
  /** Most blocks of 4 x 4 x 4 voxels to keep between two frames, about 270 bytes each.
   * Default: 2^17. */
  readonly maxBlocks?: number;
};
