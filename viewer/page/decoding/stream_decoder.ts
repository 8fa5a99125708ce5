// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { localPositions } from "@pcl_ext/codec";
import type { Codec, Decoder, DensityUnit, LocalPositions, OutlierFilter, Status, Voxels } from "@pcl_ext/codec";

import { fieldChoices } from "./field_choices";
import type { FieldChoice } from "./field_choices";
import type { DecodingSettings, FrameFailure, PackedVoxels, ShownFrame } from "./messages";
import { arraysOf, bytesOf } from "./packed_voxels";
import type { BufferPool } from "./packed_voxels";
import { VoxelTrail } from "./voxel_trail";

/** What the outlier filter judges a stream by, from its metadata, as automaticUnitOf() of the program. */
export function densityUnitOf(metadata: Readonly<Record<string, string | undefined>>): DensityUnit {
  const { intensity_law: law, sensor } = metadata;
  if (law === "count") return sensor === "lidar" ? "voxels" : "points"; // few points are no sign of a lidar's noise
  if (law === "quadratic") return "faces";
  return "automatic"; // faces where frames have a depth model, rays where they are a lidar's scans, else voxels
}

/** A frame to decode, and what the page is told of it besides its voxels. */
export interface FrameToDecode {
  stream: number;
  number: number;
  time: number; // seconds
  bytes: Uint8Array;
  frameId: string | null;
  stamp: bigint | null; // nanoseconds
}

function failureOf({ ok, code }: Status): FrameFailure | null {
  if (ok || code === "MissingReference" || code === "OldFrame") return null;
  return code === "OutOfMemory" || code === "LimitExceeded" ? "TooLarge" : "Damaged";
}

/** Decodes the frames of one stream in their order, with the outlier filter and the trail of past voxels. */
export class StreamDecoder {
  private decoder: Decoder;
  private filter: OutlierFilter | null = null;
  private readonly trail = new VoxelTrail();
  private isStepLost = false;
  private lastFailure: FrameFailure | null = null;

  constructor(
    private readonly codec: Codec,
    private readonly unit: DensityUnit,
  ) {
    this.decoder = codec.createDecoder();
  }

  free(): void {
    this.decoder.free();
    this.filter?.free();
  }

  /** Forgets all frames, as before a frame that does not follow the last one. */
  restart(): void {
    this.decoder.free();
    this.decoder = this.codec.createDecoder();
    this.filter?.reset();
    this.trail.reset();
  }

  /** Forgets when voxels were seen, as before frames whose times begin again. */
  forgetTimes(): void {
    this.trail.reset();
  }

  /** Why the last frame failed by itself, not for want of those before it; null: it did not. */
  get failure(): FrameFailure | null {
    return this.lastFailure;
  }

  /** True after a failure until the next I-frame: a live source is asked for one. */
  get wantsIFrame(): boolean {
    return this.isStepLost;
  }

  /** Decodes a frame. Without a pool its voxels are not wanted, only the state after it. */
  decode(frame: FrameToDecode, settings: DecodingSettings, pool: BufferPool | null): ShownFrame {
    const begin = performance.now();
    const { status, voxels } = this.decodeBytes(frame.bytes);
    const choices = fieldChoices(voxels?.fields ?? []);
    const shown: ShownFrame = {
      stream: frame.stream,
      number: frame.number,
      time: frame.time,
      voxels: null,
      problem: status.ok ? null : status.message,
      warning: (status.ok && status.message) || null,
      filterProblem: null,
      frameId: frame.frameId,
      stamp: frame.stamp,
      placement: null,
      resolution: voxels?.resolution ?? 0,
      intensityRange: voxels?.intensityRange ?? null,
      fields: [...choices.keys()],
      isIFrame: voxels?.isIFrame ?? false,
      bytes: frame.bytes.length,
      decodeMs: 0,
    };
    this.isStepLost = !status.ok;
    this.lastFailure = failureOf(status);
    if (voxels) {
      shown.frameId ??= voxels.frameId;
      const isNoise = settings.removesOutliers ? this.judge(shown) : null;
      const places = localPositions(voxels);
      if (settings.trailSeconds > 0)
        this.trail.add(voxels, places, frame.time, settings.trailSeconds);
      shown.decodeMs = performance.now() - begin;
      const field = pool ? this.fieldValues(choices.get(settings.field ?? "")) : null;
      if (pool) shown.voxels = this.pack(voxels, { places, isNoise, field }, settings, frame.time, pool);
    }
    return shown;
  }

  /** An I-frame that is older than the last frame begins the stream again, as of a bag played in a loop. */
  private decodeBytes(bytes: Uint8Array): { status: Status; voxels: Voxels | null } {
    const result = this.decoder.decode(bytes, { coded: true });
    if (result.status.code !== "OldFrame") return result;
    const { description } = this.codec.describeFrame(bytes);
    if (description?.kind !== "I") return result;
    this.restart();
    return this.decoder.decode(bytes, { coded: true });
  }

  private judge(shown: ShownFrame): Uint8Array | null {
    this.filter ??= this.codec.createOutlierFilter({ unit: this.unit });
    const { status, isNoise } = this.filter.judge(this.decoder);
    if (!status.ok) shown.filterProblem = status.message;
    return isNoise;
  }

  private fieldValues(choice: FieldChoice | undefined): Float64Array | null {
    return choice ? this.decoder.fieldValues(...choice).values : null;
  }

  private pack(
    voxels: Voxels,
    { places, isNoise, field }: { places: LocalPositions; isNoise: Uint8Array | null; field: Float64Array | null },
    settings: DecodingSettings,
    time: number,
    pool: BufferPool,
  ): PackedVoxels {
    const past = settings.trailSeconds > 0 ? this.trail.past(time) : [];
    const total = voxels.count + past.length;
    const buffer = pool.take(bytesOf(total, field !== null));
    const arrays = arraysOf(buffer, total, field !== null);
    arrays.positions.set(places.positions);
    if (voxels.intensities) arrays.intensities.set(voxels.intensities);
    else arrays.intensities.fill(0);
    if (voxels.pointCounts) arrays.pointCounts.set(voxels.pointCounts);
    arrays.ages.fill(0);
    if (field) arrays.field?.fill(NaN, voxels.count).set(field);
    for (let i = 0; i < voxels.count; ++i) {
      for (let c = 0; c < 3; ++c) arrays.paint[4 * i + c] = voxels.colours ? voxels.colours[3 * i + c] : 160;
      arrays.paint[4 * i + 3] = isNoise && isNoise[i] ? 255 : 0;
    }
    past.forEach((voxel, j) => {
      const i = voxels.count + j;
      arrays.positions.set(this.trail.positionOf(voxel), 3 * i);
      arrays.intensities[i] = voxel.intensity;
      arrays.pointCounts[i] = 0;
      arrays.ages[i] = time - voxel.time;
      arrays.paint.set([160, 160, 160, 0], 4 * i);
    });
    return {
      count: voxels.count,
      pastCount: past.length,
      origin: voxels.count > 0 ? places.origin : this.trail.origin,
      buffer,
      hasIntensities: voxels.intensities !== null,
      hasColours: voxels.colours !== null,
      hasPointCounts: voxels.pointCounts !== null,
      isJudged: isNoise !== null,
      field: field && settings.field,
    };
  }
}
