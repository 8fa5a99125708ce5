// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ByteSource } from "./byte_source";

const blockSize = 1 << 18;
const blocksInMemory = 256;

/** Keeps the blocks of a source that were read last, as the frames of several streams lie close together. */
export class CachedBytes implements ByteSource {
  private readonly blocks = new Map<number, Promise<Uint8Array>>();

  constructor(private readonly source: ByteSource) {}

  get name(): string {
    return this.source.name;
  }

  get size(): number {
    return this.source.size;
  }

  async read(offset: number, length: number): Promise<Uint8Array> {
    const end = Math.min(offset + length, this.size);
    if (end <= offset) return new Uint8Array(0);
    if (end - offset > 4 * blockSize) return this.source.read(offset, end - offset);
    const first = Math.floor(offset / blockSize);
    const last = Math.floor((end - 1) / blockSize);
    const begin = first * blockSize;
    if (first === last) return (await this.block(first)).subarray(offset - begin, end - begin);
    const blocks: Promise<Uint8Array>[] = [];
    for (let i = first; i <= last; ++i) blocks.push(this.block(i));
    const bytes = new Uint8Array((last - first + 1) * blockSize);
    (await Promise.all(blocks)).forEach((block, i) => bytes.set(block, i * blockSize));
    return bytes.subarray(offset - begin, end - begin);
  }

  private block(index: number): Promise<Uint8Array> {
    let block = this.blocks.get(index);
    this.blocks.delete(index);
    block ??= this.source.read(index * blockSize, blockSize);
    this.blocks.set(index, block); // the last one is that of the latest use
    block.catch(() => this.blocks.delete(index));
    for (const oldest of this.blocks.keys()) {
      if (this.blocks.size <= blocksInMemory) break;
      this.blocks.delete(oldest);
    }
    return block;
  }
}
