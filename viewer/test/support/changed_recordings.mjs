// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Recordings as other recorders write them, and damaged ones.
import { readFileSync } from "node:fs";
import { McapStreamReader } from "@mcap/core";
import lz4 from "lz4js";

import { beginMcap } from "./mcap_file.mjs";

/** A zstd frame of blocks as they are, for decompressors only. */
function zstdOfRawBlocks(bytes) {
  const header = Buffer.alloc(9);
  header.writeUInt32LE(0xfd2fb528, 0);
  header[4] = 0xa0; // one segment, four bytes of size
  header.writeUInt32LE(bytes.length, 5);
  const blocks = [header];
  for (let at = 0; at < bytes.length || at === 0; at += 1 << 17) {
    const part = bytes.subarray(at, at + (1 << 17));
    const word = Buffer.alloc(4);
    word.writeUInt32LE((part.length << 3) | (at + part.length >= bytes.length ? 1 : 0));
    blocks.push(word.subarray(0, 3), part);
  }
  return Buffer.concat(blocks);
}

const compressors = {
  zstd: (bytes) => zstdOfRawBlocks(Buffer.from(bytes)),
  lz4: (bytes) => Buffer.from(lz4.compress(Buffer.from(bytes))),
};

/** The same messages, as another recorder would write them. */
export async function rewritten(recording, { compression = "", useChunks = true, chunkSize = 200_000, changeFormat = null } = {}) {
  const { writer, bytes: written } = await beginMcap({
    useChunks,
    chunkSize,
    compressChunk: compression
      ? (bytes) => ({ compression, compressedData: compressors[compression](bytes) })
      : undefined,
  });
  const reader = new McapStreamReader();
  reader.append(readFileSync(recording));
  const schemas = new Map();
  const channels = new Map();
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema" && !schemas.has(record.id)) schemas.set(record.id, await writer.registerSchema(record));
    if (record.type === "Channel" && !channels.has(record.id))
      channels.set(record.id, await writer.registerChannel({ ...record, schemaId: schemas.get(record.schemaId) }));
    if (record.type === "Message")
      await writer.addMessage({
        ...record,
        channelId: channels.get(record.channelId),
        data: changeFormat ? withFormat(record.data, changeFormat) : record.data,
      });
  }
  await writer.end();
  return written();
}

/** A message whose format has another name of the same length, as that of another codec. */
function withFormat(message, format) {
  const bytes = Buffer.from(message);
  bytes.write(format, bytes.lastIndexOf("pcl_ext"));
  return bytes;
}

export function withFlippedByte(bytes, at) {
  const changed = Buffer.from(bytes);
  changed[at] ^= 0x55;
  return changed;
}

/** Where the records of an MCAP file begin, with their kinds. */
export function recordsOf(bytes) {
  const records = [];
  for (let at = 8; at + 9 <= bytes.length - 8; at += 9 + Number(bytes.readBigUInt64LE(at + 1)))
    records.push({ at, opcode: bytes[at] });
  return records;
}
