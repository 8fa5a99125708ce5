// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { crc32 } from "@foxglove/crc";
import { McapStreamReader } from "@mcap/core";
import type { McapTypes } from "@mcap/core";

/** The kinds of records that matter here; see https://mcap.dev/spec. */
export const opcode = { footer: 2, schema: 3, channel: 4, message: 5, chunk: 6, messageIndex: 7, dataEnd: 15 } as const;
export const recordHeaderSize = 9;
export const magic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
/** Longer records are damage. */
export const maxRecordSize = 1 << 29;

export function isMcap(bytes: Uint8Array): boolean {
  return bytes.length >= magic.length && magic.every((byte, i) => bytes[i] === byte);
}

export interface RecordHeader {
  opcode: number;
  size: number; // of the content
}

export function readRecordHeader(bytes: Uint8Array): RecordHeader {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return { opcode: view.getUint8(0), size: Number(view.getBigUint64(1, true)) };
}

/** Reads a record with @mcap/core. */
export function parseRecord(record: Uint8Array): McapTypes.TypedMcapRecord | undefined {
  const reader = new McapStreamReader({ noMagicPrefix: true });
  reader.append(record);
  return reader.nextRecord();
}

export interface MessageHeader {
  channel: number;
  logTime: bigint;
}

export const messageHeaderSize = 22;

export function readMessageHeader(content: Uint8Array): MessageHeader {
  const view = new DataView(content.buffer, content.byteOffset, content.byteLength);
  return { channel: view.getUint16(0, true), logTime: view.getBigUint64(6, true) };
}

export interface MessageIndex {
  channel: number;
  logTimes: bigint[]; // in the order of the chunk
}

/** Reads what lies behind a chunk for each of its channels; messages that it has no bytes for are left out. */
export function readMessageIndex(content: Uint8Array): MessageIndex | null {
  const head = 6;
  if (content.length < head) return null;
  const view = new DataView(content.buffer, content.byteOffset, content.byteLength);
  const end = Math.min(content.length, head + view.getUint32(2, true));
  const messages: { logTime: bigint; offset: bigint }[] = [];
  for (let at = head; at + 16 <= end; at += 16)
    messages.push({ logTime: view.getBigUint64(at, true), offset: view.getBigUint64(at + 8, true) });
  messages.sort((a, b) => Number(a.offset - b.offset));
  return { channel: view.getUint16(0, true), logTimes: messages.map(({ logTime }) => logTime) };
}

export interface ChunkHeader {
  size: number; // of the records when decompressed
  crc: number; // 0: none
  compression: string;
  recordsOffset: number; // in the content of the chunk
  recordsLength: number; // as stored
}

/** Null if the bytes are no chunk. */
export function readChunkHeader(content: Uint8Array): ChunkHeader | null {
  if (content.length < 32) return null;
  const view = new DataView(content.buffer, content.byteOffset, content.byteLength);
  const nameLength = view.getUint32(28, true);
  if (nameLength > 32 || content.length < 40 + nameLength) return null;
  return {
    size: Number(view.getBigUint64(16, true)),
    crc: view.getUint32(24, true),
    compression: new TextDecoder().decode(content.subarray(32, 32 + nameLength)),
    recordsOffset: 40 + nameLength,
    recordsLength: Number(view.getBigUint64(32 + nameLength, true)),
  };
}

export function hasChecksum(records: Uint8Array, crc: number): boolean {
  return crc === 0 || crc32(records) === crc;
}

/** Calls a visitor with each whole record of a chunk; returns the offset where records end. */
export function forEachRecord(
  records: Uint8Array,
  visit: (opcode: number, content: Uint8Array, contentOffset: number) => void,
): number {
  let at = 0;
  while (records.length - at >= recordHeaderSize) {
    const header = readRecordHeader(records.subarray(at, at + recordHeaderSize));
    const begin = at + recordHeaderSize;
    if (header.size > records.length - begin) break;
    visit(header.opcode, records.subarray(begin, begin + header.size), begin);
    at = begin + header.size;
  }
  return at;
}
