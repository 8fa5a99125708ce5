// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Decompress } from "fzstd";
import { decompressBlock } from "lz4js";

/** Larger chunks are damage: recorders write some megabytes. */
const maxChunkBytes = 1 << 28;

/** What could be decompressed of a chunk that may be cut off. */
export interface DecompressedChunk {
  bytes: Uint8Array;
  /** Why there is no more, if the chunk is damaged. */
  problem: string | null;
}

/** Collects decompressed pieces up to the size that the chunk declares. */
class Output {
  readonly bytes: Uint8Array;
  used = 0;

  constructor(size: number) {
    this.bytes = new Uint8Array(size);
  }

  add(piece: Uint8Array): void {
    if (piece.length > this.bytes.length - this.used)
      throw new RangeError("more bytes than the chunk declares");
    this.bytes.set(piece, this.used);
    this.used += piece.length;
  }
}

function decompressZstd(compressed: Uint8Array, output: Output): void {
  const stream = new Decompress((piece) => output.add(piece));
  stream.push(compressed, true);
}

/** Walks the blocks of LZ4 frames; lz4js itself reads no checksums of blocks and no part of a frame. */
function decompressLz4(compressed: Uint8Array, output: Output): void {
  const view = new DataView(compressed.buffer, compressed.byteOffset, compressed.byteLength);
  let at = 0;
  while (at < compressed.length) {
    if (view.getUint32(at, true) !== 0x184d2204) throw new RangeError("no LZ4 frame");
    const flags = view.getUint8(at + 4);
    at += 7 + (flags & 0x08 ? 8 : 0) + (flags & 0x01 ? 4 : 0);
    for (;;) {
      const word = view.getUint32(at, true);
      at += 4;
      if (word === 0) break;
      const size = word & 0x7fffffff;
      if (size > compressed.length - at) throw new RangeError("the chunk ends early");
      if (word >>> 31) output.add(compressed.subarray(at, at + size));
      else {
        const end = decompressBlock(compressed, output.bytes, at, size, output.used);
        if (end > output.bytes.length) throw new RangeError("more bytes than the chunk declares");
        output.used = end;
      }
      at += size + (flags & 0x10 ? 4 : 0);
    }
    at += flags & 0x04 ? 4 : 0;
  }
}

/** Decompresses the records of a chunk, as many as are whole. */
export function decompressChunk(
  compression: string,
  compressed: Uint8Array,
  size: number,
): DecompressedChunk {
  if (compression === "") return { bytes: compressed, problem: null };
  if (compression !== "zstd" && compression !== "lz4")
    return { bytes: new Uint8Array(0), problem: `its compression “${compression}” is unknown` };
  if (size > maxChunkBytes)
    return { bytes: new Uint8Array(0), problem: `it declares ${size} bytes` };
  const output = new Output(size);
  let problem: string | null = null;
  try {
    (compression === "zstd" ? decompressZstd : decompressLz4)(compressed, output);
    if (output.used < size) problem = "it has fewer bytes than it declares";
  } catch (error) {
    problem = `it cannot be decompressed (${(error as Error).message})`;
  }
  return { bytes: output.bytes.subarray(0, output.used), problem };
}
