// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Address, Instance, LimitValues, Result, RunningModule } from "./instance.js";
import {
  CodecError,
  noDecodedFrame,
  ok,
  type DecodeOptions,
  type DecoderLimits,
  type Status,
  type Voxels,
} from "./types.js";

/** The limits, with defaults.
 * @throws CodecError "InvalidSettings"
 */
export function limitValues(limits: DecoderLimits): LimitValues {
  const {
    maxFrameBytes = 2 ** 28,
    maxVoxels = 2 ** 26,
    maxPoints = 2 ** 30,
    maxFieldValues = 2 ** 30,
  } = limits;
  const all = { maxFrameBytes, maxVoxels, maxPoints, maxFieldValues };
  for (const [name, value] of Object.entries(all))
    if (!Number.isInteger(value) || value < 1 || value >= 2 ** 32)
      throw new CodecError(
        "InvalidSettings",
        `${name} is ${value}; it must be a whole number from 1 to 2^32 - 1`,
      );
  return [maxFrameBytes, maxVoxels, maxPoints, maxFieldValues];
}

/** Decodes the frames of one stream, in their order.
 *
 * Any bytes are safe: decoding ends in bounded time and memory, and a frame is decoded
 * completely or not at all. After a frame that fails the stream continues with the next one
 * that depends on a decoded one, at the latest with the next I-frame. Made by
 * `Codec.createDecoder`; free() releases its memory.
 */
export class Decoder {
  private readonly limits: LimitValues;
  private address: Address = 0;
  private generation = 0; // of the instance that has the address
  private isFree = false;

  /** @internal */
  constructor(
    /** @internal */
    readonly codec: RunningModule,
    limits: DecoderLimits,
  ) {
    this.limits = limitValues(limits);
  }

  /** Decodes the first frame found in some bytes. Bytes before it are skipped and counted.
   * @param frame bytes, of which those after the first frame are not read
   * @returns the voxels, or why there are none, or with a message in an Ok status how many points
   *   were left out, as they are outside the grid of voxels; and the number of bytes after which the next
   *   call may continue: the end of the frame, or after a failure where another frame may
   *   begin, which is above 0 if there are bytes. Codes: status.code "MissingReference" until the
   *   next I-frame after a lost frame, "OldFrame" for a late or repeated one, "Corrupt",
   *   "Truncated", "LimitExceeded", "NoFrame", "UnsupportedVersion", "EndOfStream" for no
   *   bytes, "OutOfMemory"
   * @throws CodecError "InvalidInput" after free()
   */
  decode(
    frame: Uint8Array,
    options: DecodeOptions = {},
  ): {
    readonly status: Status;
    readonly voxels: Voxels | null;
    readonly bytesRead: number;
  } {
    this.requireNotFree();
    // No byte after is read: these are skipped at most, and then the frame has as many.
    const bytes = frame.subarray(0, 2 * this.limits[0]);
    const decoded = this.codec.call((instance) => {
      const decoder = this.addressIn(instance);
      const result = instance.withBytes(bytes, (address, size) =>
        instance.exports.decode(decoder, address, size),
      );
      const status = result.status(104);
      const voxels = status.ok ? voxelsOf(result, options) : null;
      return { status, voxels, bytesRead: result.u32(136) };
    });
    if (decoded.failure === null) return decoded.value;
    return { status: decoded.failure, voxels: null, bytesRead: Math.min(1, bytes.length) };
  }

  /** One value of a field for each voxel of the last frame. Where voxels have several points
   * it is the mean, or of integers the most frequent one, the lowest of several.
   * @param field index in `Voxels.fields` of that frame
   * @param value which one of the field's values, below its `count`
   * @returns [count] in the order of the voxels, integers and floats as they are; null if
   *   there are none: status.code is then "NoDecodedFrame" or "OutOfMemory"
   * @throws CodecError "InvalidInput" if the frame has no such field or value, and after free()
   */
  fieldValues(
    field: number,
    value = 0,
  ): { readonly status: Status; readonly values: Float64Array<ArrayBuffer> | null } {
    this.requireNotFree();
    const found = this.codec.call((instance) => {
      const address = instance.exports.field_values(this.addressIn(instance), field, value);
      if (address === 0) return { status: noDecodedFrame, values: null };
      const result = instance.result(address);
      const values = result.doubles(4, result.u32(0));
      if (values === null)
        throw new CodecError("InvalidInput", `the frame has no value ${value} of a field ${field}`);
      return { status: ok, values };
    });
    return found.failure === null ? found.value : { status: found.failure, values: null };
  }

  /** Releases the memory of the decoder, which must not be used any more. */
  free(): void {
    if (!this.isFree && this.isInInstance())
      this.codec.call((instance) => instance.exports.destroy_decoder(this.address));
    this.isFree = true;
  }

  /** The decoder in an instance of the module; a new one after a trap.
   * @internal */
  addressIn(instance: Instance): Address {
    if (!this.isInInstance()) {
      this.address = instance.exports.create_decoder(...this.limits);
      this.generation = this.codec.generation;
    }
    return this.address;
  }

  private isInInstance(): boolean {
    return this.generation === this.codec.generation;
  }

  /** @internal */
  requireNotFree(): void {
    if (this.isFree) throw new CodecError("InvalidInput", "the decoder was freed");
  }
}

/** Reads a DecodedFrame. */
function voxelsOf(result: Result, options: DecodeOptions): Voxels {
  const count = result.u32(116);
  const grid = result.grid(0);
  const hasStamp = result.u32(88) !== 0;
  const stamp = hasStamp ? result.u64(80) : 0n;
  return {
    count,
    positions: result.floats(140, 3 * count) ?? new Float32Array(),
    intensities: result.floats(144, count),
    colours: result.bytes(148, 3 * count),
    pointCounts: result.words(152, count),
    fields: result.fields(164),
    resolution: grid.resolution,
    grid,
    intensityRange: result.intensityRange(48),
    stamp: stamp !== 0n ? stamp : null,
    frameId: (hasStamp && result.text(92)) || null,
    isIFrame: result.u32(124) !== 0,
    frameNumber: result.u32(120),
    bytes: result.u32(128),
    skippedBytes: result.u32(132),
    coded:
      options.coded === true
        ? {
            keys: result.longs(156, count) ?? new BigUint64Array(),
            symbols: result.shorts(160, count),
          }
        : null,
  };
}
