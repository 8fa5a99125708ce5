// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Decoder } from "./decoder.js";
import type { Address, FilterSettings, Instance, RunningModule } from "./instance.js";
import { CodecError, densityUnits, noDecodedFrame, type OutlierFilterSettings, type Status } from "./types.js";

/** The settings as the module takes them; it has their defaults and checks their ranges. */
export function filterSettings(settings: OutlierFilterSettings): FilterSettings {
  const { unit: unitName = "automatic", ...given } = settings;
  const { maxBlocks = 0 } = given;
  if (!Number.isInteger(maxBlocks) || maxBlocks < 0 || maxBlocks >= 2 ** 32)
    throw new CodecError(
      "InvalidSettings",
      `maxBlocks is ${maxBlocks}; it must be a whole number below 2^32`,
    );
  const unit = densityUnits.indexOf(unitName);
  if (unit < 0) throw new CodecError("InvalidSettings", `unknown unit ${String(unitName)}`);
  const values = Object.entries(given).filter(([, value]) => value !== undefined);
  return {
    unit,
    values: values.map(([key, value]) => {
      const name = key.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
      const [x = NaN, y = NaN, z = NaN] = [value].flat().map(Number);
      return [new TextEncoder().encode(name), x, y, z];
    }),
  };
}

/** Tells noise from surfaces in the voxels of one stream, by their neighbourhood in this and
 * previous frames: `VoxelOutlierRemoval` of the library. Made by
 * `Codec.createOutlierFilter`; free() releases its memory.
 */
export class OutlierFilter {
  private address: Address = 0;
  private generation = 0; // of the instance that has the address
  private isFree = false;

  /** @internal */
  constructor(
    private readonly codec: RunningModule,
    private readonly settings: FilterSettings,
  ) {}

  /** Judges the frame that a decoder of the same codec decoded last. To be called once for
   * each decoded frame of a stream, in order.
   * @returns isNoise: [count] 1: noise, 0: not, in the order of the frame's voxels; null if
   *   none was judged: status.code is then "NoDecodedFrame", "UnsupportedResolution" (0.001
   *   to 0.2 m), "NoDensities" (the unit needs intensities) or "OutOfMemory"
   * @throws CodecError "InvalidInput" after free() of either, or if the decoder is of another
   *   codec
   */
  judge(decoder: Decoder): {
    readonly status: Status;
    readonly isNoise: Uint8Array<ArrayBuffer> | null;
  } {
    this.requireNotFree();
    decoder.requireNotFree();
    if (decoder.codec !== this.codec)
      throw new CodecError("InvalidInput", "the decoder belongs to another codec");
    const judged = this.codec.call((instance) => {
      const filter = this.addressIn(instance);
      const address = instance.exports.judge(filter, decoder.addressIn(instance));
      if (address === 0) return { status: noDecodedFrame, isNoise: null };
      const result = instance.result(address);
      const status = result.filterStatus(0);
      const isNoise = result.bytes(16, result.u32(12)) ?? new Uint8Array();
      return { status, isNoise: status.ok ? isNoise : null };
    });
    return judged.failure === null ? judged.value : { status: judged.failure, isNoise: null };
  }

  /** Drops the history, as at the start of a stream or after a jump in it. */
  reset(): void {
    this.requireNotFree();
    if (this.isInInstance())
      this.codec.call((instance) => instance.exports.reset_outlier_filter(this.address));
  }

  /** Releases the memory of the filter, which must not be used any more. */
  free(): void {
    if (!this.isFree && this.isInInstance())
      this.codec.call((instance) => instance.exports.destroy_outlier_filter(this.address));
    this.isFree = true;
  }

  private addressIn(instance: Instance): Address {
    if (!this.isInInstance()) {
      instance.setFilterSettings(this.settings);
      this.address = instance.exports.create_outlier_filter();
      this.generation = this.codec.generation;
    }
    return this.address;
  }

  private isInInstance(): boolean {
    return this.generation === this.codec.generation;
  }

  private requireNotFree(): void {
    if (this.isFree) throw new CodecError("InvalidInput", "the filter was freed");
  }
}
