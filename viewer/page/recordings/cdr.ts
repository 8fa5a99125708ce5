// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** What of a point_cloud_interfaces/msg/CompressedPointCloud2 the page needs. */
export interface CompressedCloud {
  stamp: bigint; // nanoseconds
  frameId: string;
  /** The frame; a view of the message's bytes. */
  frame: Uint8Array;
  format: string;
}

const text = new TextDecoder();

/** Reads values of the Common Data Representation, either byte order, as ROS 2 writes them. */
export class CdrReader {
  private readonly view: DataView;
  private readonly isLittle: boolean;
  private at = 4; // after the encapsulation header, from which alignment counts

  constructor(private readonly bytes: Uint8Array) {
    if (bytes.length < 4) throw new RangeError("no encapsulation header");
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.isLittle = (bytes[1] & 1) === 1;
  }

  u8(): number {
    return this.view.getUint8(this.at++);
  }

  u32(): number {
    this.at = 4 + ((this.at - 4 + 3) & ~3);
    const value = this.view.getUint32(this.at, this.isLittle);
    this.at += 4;
    return value;
  }

  f64(): number {
    this.at = 4 + ((this.at - 4 + 7) & ~7);
    const value = this.view.getFloat64(this.at, this.isLittle);
    this.at += 8;
    return value;
  }

  take(count: number): Uint8Array {
    if (count > this.bytes.length - this.at) throw new RangeError("the message ends early");
    this.at += count;
    return this.bytes.subarray(this.at - count, this.at);
  }

  string(): string {
    const bytes = this.take(this.u32()); // with a zero at its end
    return text.decode(bytes.subarray(0, Math.max(0, bytes.length - 1)));
  }
}

/** Null if the bytes are no such message. */
export function readCompressedCloud(bytes: Uint8Array): CompressedCloud | null {
  try {
    const reader = new CdrReader(bytes);
    const stamp = BigInt(reader.u32() | 0) * 1_000_000_000n + BigInt(reader.u32());
    const frameId = reader.string();
    reader.u32(); // height
    reader.u32(); // width
    const fields = reader.u32();
    if (fields > 4096) return null;
    for (let i = 0; i < fields; ++i) {
      reader.string();
      reader.u32();
      reader.u8();
      reader.u32();
    }
    reader.u8(); // is_bigendian
    reader.u32(); // point_step
    reader.u32(); // row_step
    const frame = reader.take(reader.u32());
    reader.u8(); // is_dense
    return { stamp, frameId, frame, format: reader.string() };
  } catch {
    return null;
  }
}
