// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { McapIndexedReader } from "@mcap/core";

import { BlockReader } from "./byte_source";
import type { ByteSource } from "./byte_source";
import { decompressChunk } from "./chunk_decompression";
import type { ChunkPlace, RecordingListener } from "./frame_places";
import type { McapStreams } from "./mcap_streams";
import * as records from "./mcap_records";

const chunkHeaderAtMost = 72;

/** The summary at the end of the file; null if there is no whole one. */
async function readSummary(source: ByteSource): Promise<McapIndexedReader | null> {
  try {
    return await McapIndexedReader.Initialize({
      readable: {
        size: async () => BigInt(source.size),
        read: async (offset, size) => source.read(Number(offset), Number(size)),
      },
    });
  } catch {
    return null;
  }
}

/** Indexes a file of a recording record by record, whatever of it is damaged. */
export class McapScan {
  private readonly blocks: BlockReader;
  private isWhole = false; // its end was found
  private isDamaged = false;
  private isChunkLost = false; // the last one
  private summary: Promise<McapIndexedReader | null> | null = null;

  constructor(
    private readonly source: ByteSource,
    private readonly file: number,
    private readonly streams: McapStreams,
    private readonly listener: RecordingListener,
  ) {
    this.blocks = new BlockReader(source);
  }

  /** False if the file ends early, as after a crash of the recorder. */
  async run(report: (offset: number) => void): Promise<boolean> {
    let at: number = records.magic.length;
    while (at < this.source.size && !this.isWhole) {
      const next = await this.readRecord(at);
      at = next ?? (await this.placeAfter(at));
      report(at);
    }
    if (this.isDamaged) {
      await this.addChannelsOfSummary();
      this.streams.addSilentStreams(this.file);
    }
    return this.isWhole && (await this.endsWithMagic());
  }

  /** False where the summary after the frames is cut off. */
  private async endsWithMagic(): Promise<boolean> {
    const size = records.magic.length;
    const end = await this.source.read(Math.max(0, this.source.size - size), size);
    return records.magic.every((byte, i) => end[i] === byte);
  }

  /** Channels whose descriptions are lost with the chunk that has them are known by the summary. */
  private async addChannelsOfSummary(): Promise<void> {
    this.summary ??= readSummary(this.source);
    const summary = await this.summary;
    for (const channel of summary?.channelsById.values() ?? [])
      this.streams.addChannel(this.file, channel, summary?.schemasById.get(channel.schemaId)?.name ?? "");
  }

  private damage(offset: number, message: string): void {
    this.isDamaged = true;
    this.listener.addDamage({ file: this.source.name, offset, message });
  }

  /** Of a chunk that is lost the indexes behind it tell how many messages of which times it had. */
  private async loseChunk(): Promise<void> {
    this.isChunkLost = true;
    await this.addChannelsOfSummary();
  }

  /** The next index or chunk after damage, as the summary tells; the end of the file if there is none. */
  private async placeAfter(offset: number): Promise<number> {
    this.summary ??= readSummary(this.source);
    const chunks = (await this.summary)?.chunkIndexes ?? [];
    if (chunks.some((chunk) => Number(chunk.chunkStartOffset) === offset)) await this.loseChunk();
    const places = chunks.flatMap((chunk) => [chunk.chunkStartOffset, ...chunk.messageIndexOffsets.values()].map(Number));
    return places.sort((a, b) => a - b).find((place) => place > offset) ?? this.source.size;
  }

  /** Reads the record at a place; returns where the next one begins, or null if that is unknown. */
  private async readRecord(at: number): Promise<number | null> {
    const head = (await this.blocks.bytesAt(at, records.recordHeaderSize)).slice();
    if (head.length < records.recordHeaderSize) {
      this.damage(at, "the file ends within a record");
      return null;
    }
    const header = records.readRecordHeader(head);
    const begin = at + records.recordHeaderSize;
    const end = begin + header.size;
    if (header.opcode === records.opcode.dataEnd || header.opcode === records.opcode.footer) {
      this.isWhole = true;
      return end;
    }
    if (header.opcode === 0 || header.size > records.maxRecordSize) {
      this.damage(at, "the length of a record is wrong");
      return null;
    }
    if (header.opcode === records.opcode.chunk) await this.readChunk(begin, header.size);
    else if (end > this.source.size) this.damage(at, "the file ends within a record");
    else await this.readPlainRecord(header.opcode, at, header.size);
    return end;
  }

  private async readPlainRecord(opcode: number, at: number, size: number): Promise<void> {
    const isOfUse =
      opcode === records.opcode.message ||
      opcode === records.opcode.schema ||
      opcode === records.opcode.channel ||
      (opcode === records.opcode.messageIndex && this.isChunkLost);
    if (!isOfUse) return;
    const bytes = await this.blocks.bytesAt(at, records.recordHeaderSize + size);
    const content = bytes.subarray(records.recordHeaderSize);
    this.takeRecord(opcode, content, at + records.recordHeaderSize, null, at);
  }

  private takeRecord(
    opcode: number,
    content: Uint8Array,
    offset: number,
    chunk: ChunkPlace | null,
    fileOffset: number,
  ): void {
    if (opcode === records.opcode.message && content.length >= records.messageHeaderSize)
      this.streams.addMessage(this.file, content, {
        file: this.file,
        chunk,
        offset: offset + records.messageHeaderSize,
        length: content.length - records.messageHeaderSize,
        fileOffset,
      });
    else if (opcode === records.opcode.schema || opcode === records.opcode.channel)
      this.streams.addDescription(this.file, opcode, content);
    else if (opcode === records.opcode.messageIndex) this.streams.addLostMessages(this.file, content);
  }

  private async readChunk(begin: number, size: number): Promise<void> {
    const at = begin - records.recordHeaderSize;
    const head = await this.blocks.bytesAt(begin, Math.min(chunkHeaderAtMost, size));
    const header = records.readChunkHeader(head);
    if (!header || header.recordsOffset + header.recordsLength > size) {
      this.damage(at, "a chunk's header is damaged; its frames are lost");
      return this.loseChunk();
    }
    const place: ChunkPlace = {
      offset: begin + header.recordsOffset,
      length: header.recordsLength,
      compression: header.compression,
      size: header.size,
    };
    const stored = await this.blocks.bytesAt(place.offset, place.length);
    const isCutOff = stored.length < place.length;
    const { bytes, problem } = decompressChunk(place.compression, stored, place.size);
    if (!isCutOff && (problem || !records.hasChecksum(bytes, header.crc))) {
      this.damage(at, `a chunk is damaged: ${problem ?? "its checksum is wrong"}; its frames are lost`);
      return this.loseChunk();
    }
    this.isChunkLost = false;
    const isPlain = place.compression === "";
    const end = records.forEachRecord(bytes, (opcode, content, offset) =>
      this.takeRecord(opcode, content, isPlain ? place.offset + offset : offset, isPlain ? null : place,
        isPlain ? place.offset + offset : at));
    if (isCutOff) this.damage(isPlain ? place.offset + end : at, "the file ends within a chunk");
  }
}
