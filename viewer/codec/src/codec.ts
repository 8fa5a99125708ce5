// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Decoder, limitValues } from "./decoder.js";
import { Instance, pageSize, type Called, type Result } from "./instance.js";
import { OutlierFilter, filterSettings } from "./outlier_filter.js";
import {
  CodecError,
  type DecoderLimits,
  type FrameDescription,
  type OutlierFilterSettings,
  type Status,
  type StatusCode,
} from "./types.js";

/** Most headers have fewer bytes, so that what follows them need not be copied. */
const usualHeaderBytes = 2048;

export interface CodecOptions {
  /** Most memory of all decoders and filters together, bytes; rounded down to pages of
   * 64 KiB, at least 2 MiB. Default: 2^30, which frames within the default limits can
   * exceed only where they are constructed for it. */
  readonly maximumMemory?: number;
}

/** The codec: makes decoders and filters, and reads headers of frames.
 *
 * All decoders and filters of a codec share its memory. If that is exhausted, the call
 * returns the code "OutOfMemory", and the codec goes on with new memory: its decoders then
 * return "MissingReference" until their next I-frame, and its filters begin anew. To
 * separate streams that are not trusted from others, load a codec for each.
 */
export class Codec {
  private instances = 1;
  private isRestarting = false;

  private constructor(
    private readonly module: WebAssembly.Module,
    private readonly maximumPages: number,
    private instance: Instance | null,
  ) {}

  /** Loads the module.
   * @param wasm the bytes of `codec.wasm`, or a module compiled of them, which several
   *   codecs and threads can share
   * @throws WebAssembly.CompileError, WebAssembly.LinkError: these are other bytes
   * @throws RangeError if there is no memory for it
   */
  static async load(
    wasm: BufferSource | WebAssembly.Module,
    options: CodecOptions = {},
  ): Promise<Codec> {
    const pages = pagesOf(options);
    const module = wasm instanceof WebAssembly.Module ? wasm : await WebAssembly.compile(wasm);
    return new Codec(module, pages, await Instance.create(module, pages));
  }

  /** The same at once, for programs that cannot wait, such as plug-ins.
   * @throws as load(); RangeError in Chromium before version 118 on the main thread of a page
   */
  static loadNow(wasm: BufferSource | WebAssembly.Module, options: CodecOptions = {}): Codec {
    const pages = pagesOf(options);
    const module = wasm instanceof WebAssembly.Module ? wasm : new WebAssembly.Module(wasm);
    return new Codec(module, pages, Instance.createNow(module, pages));
  }

  /** Reads the header of the frame at the beginning of some bytes. Its checksum is not
   * verified.
   * @param bytes of the frame; its header has a few hundred, but where a lidar's rows and columns
   *   are kept some 20 for each row more; the published layout tells its size only when all are there
   */
  describeFrame(
    bytes: Uint8Array,
    limits: DecoderLimits = {},
  ): { readonly status: Status; readonly description: FrameDescription | null } {
    const values = limitValues(limits);
    const describe = (size: number) =>
      this.call((instance) =>
        descriptionOf(
          instance.withBytes(bytes.subarray(0, size), (address, count) =>
            instance.exports.describe_frame(address, count, ...values),
          ),
        ),
      );
    let described = describe(usualHeaderBytes);
    if (described.value?.status.code === "Truncated" && bytes.length > usualHeaderBytes)
      described = describe(values[0]);
    if (described.failure !== null) return { status: described.failure, description: null };
    const { status, description } = described.value;
    if (description === null) return { status, description };
    const size = this.measure(bytes, limits);
    return { status, description: { ...description, bytes: size.status.ok ? size.bytes : null } };
  }

  /** Tells how many bytes the frame at the beginning of some bytes has, for bytes that
   * arrive in pieces. A frame of version 1 is known by its first 100 bytes or so; one of
   * the published layout when it is complete, and is decoded for it.
   * @returns bytes of the whole frame, of which fewer may be there; null: more bytes are
   *   needed to know it
   * @throws CodecError if no frame begins there; `bytesToSkip` may be dropped
   */
  frameSize(bytes: Uint8Array, limits: DecoderLimits = {}): number | null {
    const { status, bytes: size } = this.measure(bytes, limits);
    if (status.ok) return size;
    if (status.code === "Truncated") return null;
    throw new CodecError(status.code, status.message, size);
  }

  /** Makes a decoder for one stream.
   * @throws CodecError "InvalidSettings" if a limit is outside its range
   */
  createDecoder(limits: DecoderLimits = {}): Decoder {
    return new Decoder(this, limits);
  }

  /** Makes a filter of outliers for one stream.
   * @throws CodecError "InvalidSettings" if a setting is outside its range
   */
  createOutlierFilter(settings: OutlierFilterSettings = {}): OutlierFilter {
    const values = filterSettings(settings);
    const checked = this.call((instance) => instance.setFilterSettings(values));
    const status = checked.failure ?? checked.value;
    if (!status.ok) throw new CodecError(status.code, status.message);
    return new OutlierFilter(this, values);
  }

  /** Bytes of memory that decoders and filters have taken so far. It does not shrink, but
   * is used again. */
  get memoryBytes(): number {
    return this.instance?.memoryBytes ?? 0;
  }

  /** Number of the present instance of the module; another one after each trap.
   * @internal */
  get generation(): number {
    return this.instances;
  }

  /** Calls the module. A trap becomes a status, and the next call has a new instance.
   * @internal */
  call<T>(run: (instance: Instance) => T): Called<T> {
    try {
      this.instance ??= this.restart();
      return { failure: null, value: run(this.instance) };
    } catch (error) {
      if (error instanceof CodecError) throw error;
      return { failure: this.abandonInstance(error), value: null };
    }
  }

  private measure(
    bytes: Uint8Array,
    limits: DecoderLimits,
  ): { readonly status: Status; readonly bytes: number } {
    const values = limitValues(limits);
    const measured = this.call((instance) => {
      const result = instance.withBytes(bytes.subarray(0, values[0]), (address, size) =>
        instance.exports.frame_size(address, size, ...values),
      );
      return { status: result.status(0), bytes: result.u32(12) };
    });
    return measured.failure === null ? measured.value : { status: measured.failure, bytes: 1 };
  }

  /** A new instance. Where none can be made at once there is one a little later, unless
   * memory is short. */
  private restart(): Instance {
    try {
      return Instance.createNow(this.module, this.maximumPages);
    } catch (error) {
      if (!this.isRestarting) {
        this.isRestarting = true;
        Instance.create(this.module, this.maximumPages)
          .then((instance) => (this.instance ??= instance))
          .catch(() => undefined) // the next call tries again
          .finally(() => (this.isRestarting = false));
      }
      throw error;
    }
  }

  private abandonInstance(error: unknown): Status {
    const isOutOfMemory =
      error instanceof RangeError || (this.instance?.exports.is_out_of_memory() ?? 1) !== 0;
    this.instance = null;
    ++this.instances;
    const code: StatusCode = isOutOfMemory ? "OutOfMemory" : "Trap";
    const reason = isOutOfMemory ? "out of memory" : `the decoder failed (${String(error)})`;
    const message = `${reason}; streams continue with their next I-frames`;
    return { ok: false, code, message };
  }
}

/** Pages of memory that a codec may take.
 * @throws CodecError "InvalidSettings"
 */
function pagesOf({ maximumMemory = 2 ** 30 }: CodecOptions): number {
  const pages = Math.floor(maximumMemory / pageSize);
  if (!(pages >= 32 && pages <= 65536))
    throw new CodecError("InvalidSettings", "maximumMemory must be 2 MiB to 4 GiB");
  return pages;
}

/** Reads a DescribedFrame. */
function descriptionOf(result: Result): {
  readonly status: Status;
  readonly description: FrameDescription | null;
} {
  const status = result.status(112);
  if (!status.ok) return { status, description: null };
  const isPublished = result.u32(128) !== 0;
  const isIFrame = result.u32(140) !== 0;
  const tellsVoxels = isIFrame || !isPublished;
  const grid = isIFrame ? result.grid(0) : null;
  const description: FrameDescription = {
    format: isPublished ? "published" : "version1",
    frameNumber: result.u32(136),
    kind: isIFrame ? "I" : "P",
    bytes: null,
    effort: isPublished ? null : ((["fast", "balanced", "small"] as const)[result.u32(132)] ?? null),
    voxels: tellsVoxels ? result.u32(144) : null,
    points: tellsVoxels ? result.u32(148) : null,
    grid,
    resolution: grid?.resolution ?? null,
    intensityRange: isIFrame ? result.intensityRange(48) : null,
    colourBits: isIFrame ? result.u32(152) : null,
    hasPointCounts: isIFrame ? result.u32(156) !== 0 : null,
    stamp: result.u32(88) !== 0 ? result.u64(80) : null,
    stampDifference: result.u32(124) !== 0 ? result.i64(104) : null,
    frameId: result.u32(160) !== 0 ? result.text(92) : null,
    hasPointsInOrder: result.u32(164) !== 0,
  };
  return { status, description };
}
