// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The WebAssembly module in one of its instances, see codec_interface.cpp. */
import {
  compressionCodes,
  fieldTypes,
  ok,
  outlierRemovalCodes,
  type FieldDescription,
  type Grid,
  type IntensityRange,
  type Status,
  type StatusCode,
} from "./types.js";

/** Address in the memory of an instance; 0: none. */
export type Address = number;

/** Limits of a decoder as the module takes them: bytes of a frame, voxels, points, values
 * of fields. */
export type LimitValues = readonly [number, number, number, number];

/** Settings of a filter as the module takes them: the number of the unit, and of each
 * setting its name in the library and one number or three. */
export interface FilterSettings {
  readonly unit: number;
  readonly values: readonly (readonly [name: Uint8Array, x: number, y: number, z: number])[];
}

/** What the module exports. */
interface Exports {
  _initialize(): void;
  set_up(): void;
  is_out_of_memory(): number;
  allocate(size: number): Address;
  release(bytes: Address): void;
  create_decoder(...limits: LimitValues): Address;
  destroy_decoder(decoder: Address): void;
  decode(decoder: Address, bytes: Address, size: number): Address;
  field_values(decoder: Address, field: number, value: number): Address;
  describe_frame(bytes: Address, size: number, ...limits: LimitValues): Address;
  frame_size(bytes: Address, size: number, ...limits: LimitValues): Address;
  set_filter_unit(unit: number): void;
  set_filter_setting(name: Address, size: number, x: number, y: number, z: number): Address;
  create_outlier_filter(): Address;
  destroy_outlier_filter(filter: Address): void;
  reset_outlier_filter(filter: Address): void;
  judge(filter: Address, decoder: Address): Address;
}

export const pageSize = 65536;

/** Pages of memory at the start, at least those of data and stack of the module. */
export const initialPages = 8;

/** The part of memory where a result lies, to be read by offsets. */
export class Result {
  constructor(
    private readonly buffer: ArrayBufferLike,
    private readonly begin: Address,
  ) {}

  private get view(): DataView {
    return new DataView(this.buffer, this.begin);
  }

  u32(offset: number): number {
    return this.view.getUint32(offset, true);
  }

  i32(offset: number): number {
    return this.view.getInt32(offset, true);
  }

  i64(offset: number): bigint {
    return this.view.getBigInt64(offset, true);
  }

  u64(offset: number): bigint {
    return this.view.getBigUint64(offset, true);
  }

  f64(offset: number): number {
    return this.view.getFloat64(offset, true);
  }

  /** A Span of characters. */
  text(offset: number): string {
    const bytes = new Uint8Array(this.buffer, this.u32(offset), this.u32(offset + 4));
    return new TextDecoder().decode(bytes.slice());
  }

  /** An Outcome, of a CompressionStatus. */
  status(offset: number): Status {
    return this.outcome(offset, compressionCodes);
  }

  /** An Outcome, of an OutlierRemovalStatus. */
  filterStatus(offset: number): Status {
    return this.outcome(offset, outlierRemovalCodes);
  }

  /** A Grid. */
  grid(offset: number): Grid {
    return {
      resolution: this.f64(offset),
      origin: [this.f64(offset + 8), this.f64(offset + 16), this.f64(offset + 24)],
      firstIndex: [this.i32(offset + 32), this.i32(offset + 36), this.i32(offset + 40)],
      depth: this.u32(offset + 44),
    };
  }

  /** A Scale; null: no intensities. */
  intensityRange(offset: number): IntensityRange | null {
    const bits = this.u32(offset + 24);
    if (bits === 0) return null;
    return {
      min: this.f64(offset),
      max: this.f64(offset + 8),
      step: this.f64(offset + 16),
      bits,
      compandedRange: this.u32(offset + 28),
    };
  }

  /** DescribedFields: their number at an offset, and after it their address. */
  fields(offset: number): FieldDescription[] {
    const descriptions = new Result(this.buffer, this.u32(offset + 4));
    return Array.from({ length: this.u32(offset) }, (_, i) => ({
      name: descriptions.text(16 * i),
      type: fieldTypes[descriptions.u32(16 * i + 8) - 1] ?? "float64",
      count: descriptions.u32(16 * i + 12),
    }));
  }

  /** Copy of the array whose address is at an offset; null: there is none. */
  floats(offset: number, count: number): Float32Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new Float32Array(this.buffer, begin, count).slice();
  }

  bytes(offset: number, count: number): Uint8Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new Uint8Array(this.buffer, begin, count).slice();
  }

  shorts(offset: number, count: number): Uint16Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new Uint16Array(this.buffer, begin, count).slice();
  }

  words(offset: number, count: number): Uint32Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new Uint32Array(this.buffer, begin, count).slice();
  }

  doubles(offset: number, count: number): Float64Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new Float64Array(this.buffer, begin, count).slice();
  }

  longs(offset: number, count: number): BigUint64Array<ArrayBuffer> | null {
    const begin = this.u32(offset);
    return begin === 0 ? null : new BigUint64Array(this.buffer, begin, count).slice();
  }

  private outcome(offset: number, codes: readonly StatusCode[]): Status {
    const code = codes[this.u32(offset)] ?? "Trap";
    if (code === "Ok" && this.u32(offset + 8) === 0) return ok;
    return { ok: code === "Ok", code, message: this.text(offset + 4) };
  }
}

/** One instance of the module, with a memory of its own. After a trap it must not be used
 * again. */
export class Instance {
  private constructor(
    readonly exports: Exports,
    private readonly memory: WebAssembly.Memory,
  ) {
    exports._initialize();
    exports.set_up();
  }

  /** @throws RangeError if there is no memory for it */
  static async create(module: WebAssembly.Module, maximumPages: number): Promise<Instance> {
    const memory = createMemory(maximumPages);
    const instance = await WebAssembly.instantiate(module, importsWith(memory));
    return new Instance(exportsOf(instance), memory);
  }

  /** The same at once.
   * @throws RangeError if there is no memory for it; Chromium before version 118 always does
   *   on the main thread of a page
   */
  static createNow(module: WebAssembly.Module, maximumPages: number): Instance {
    const memory = createMemory(maximumPages);
    return new Instance(exportsOf(new WebAssembly.Instance(module, importsWith(memory))), memory);
  }

  /** Calls a function with bytes, which are copied into the memory for the call. */
  withBytes(
    bytes: Uint8Array,
    call: (address: Address, size: number) => Address,
  ): Result {
    const address = this.exports.allocate(bytes.length);
    new Uint8Array(this.memory.buffer, address, bytes.length).set(bytes);
    const result = call(address, bytes.length);
    this.exports.release(address);
    return this.result(result);
  }

  /** Sets the settings of the filter that is created next. */
  setFilterSettings(settings: FilterSettings): Status {
    this.exports.set_filter_unit(settings.unit);
    let status = ok;
    for (const [name, x, y, z] of settings.values)
      if (status.ok)
        status = this.withBytes(name, (address, size) =>
          this.exports.set_filter_setting(address, size, x, y, z),
        ).filterStatus(0);
    return status;
  }

  /** To be read before the next call, which may move the memory. */
  result(address: Address): Result {
    return new Result(this.memory.buffer, address);
  }

  /** Bytes of the memory. */
  get memoryBytes(): number {
    return this.memory.buffer.byteLength;
  }
}

function createMemory(maximumPages: number): WebAssembly.Memory {
  return new WebAssembly.Memory({ initial: initialPages, maximum: maximumPages });
}

function importsWith(memory: WebAssembly.Memory): WebAssembly.Imports {
  const fillRandom = (address: Address, size: number): void =>
    setRandom(new Uint8Array(memory.buffer, address, size));
  return { env: { memory, fill_random: fillRandom } };
}

function exportsOf(instance: WebAssembly.Instance): Exports {
  return instance.exports as unknown as Exports;
}

/** Fills bytes at random, so that nobody can prepare streams whose blocks collide in hash
 * tables. */
function setRandom(bytes: Uint8Array<ArrayBuffer>): void {
  // node 18 has no global crypto.
  if (typeof globalThis.crypto === "object") globalThis.crypto.getRandomValues(bytes);
  else for (let i = 0; i < bytes.length; ++i) bytes[i] = Math.floor(256 * Math.random());
}

/** Outcome of a call into the module: what it returned, or why it failed. */
export type Called<T> =
  | { readonly failure: null; readonly value: T }
  | { readonly failure: Status; readonly value: null };

/** The module with an instance that is replaced after a trap. */
export interface RunningModule {
  /** Number of the present instance of the module; another one after each trap. */
  readonly generation: number;
  /** Calls the module. A trap becomes a status, and the next call has a new instance. */
  call<T>(run: (instance: Instance) => T): Called<T>;
}
