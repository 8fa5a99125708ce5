// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Exchanges MCAP files with the reader and the writer of the format's authors, and clouds in
// CDR with an independent implementation of it. Usage: node exchange_files.mjs PROGRAM FOLDER
// PROGRAM is mcap_content, which is built from mcap_content.cpp.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";

import { crc32 } from "@foxglove/crc";
import rosmsg from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";

const [program, folder] = process.argv.slice(2);
fs.rmSync(folder, { recursive: true, force: true });
fs.mkdirSync(folder, { recursive: true });
await zstd.isLoaded;

const decompressHandlers = {
  zstd: (bytes, size) => zstd.decompress(bytes, Number(size)),
};

const readable = (bytes) => ({
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
});

/** What the program prints, a JSON value a line. */
const run = (...args) =>
  execFileSync(program, args, { encoding: "utf8" })
    .split("\n")
    .filter((line) => line !== "")
    .map((line) => JSON.parse(line));

const hexOf = (bytes) => Buffer.from(bytes).toString("hex");

/** Reads a file that the program wrote. */
async function readOurs() {
  const file = path.join(folder, "ours.mcap");
  const written = run("write", file);
  const bytes = fs.readFileSync(file);

  const indexed = await McapIndexedReader.Initialize({
    readable: readable(bytes),
    decompressHandlers,
  });
  assert.equal(indexed.header.profile, "ros2");
  const messages = [];
  for await (const message of indexed.readMessages()) messages.push(message);
  const expected = written.filter((line) => line.kind === "message");
  assert.equal(messages.length, expected.length);
  expected.sort((a, b) => Number(BigInt(a.log_time) - BigInt(b.log_time)));
  messages.forEach((message, i) => {
    const channel = indexed.channelsById.get(message.channelId);
    const schema = indexed.schemasById.get(channel.schemaId);
    assert.equal(channel.topic, expected[i].topic);
    assert.equal(schema?.name ?? "", expected[i].schema);
    assert.equal(message.logTime, BigInt(expected[i].log_time));
    assert.equal(message.publishTime, BigInt(expected[i].publish_time));
    assert.equal(message.sequence, expected[i].sequence);
    assert.equal(hexOf(message.data), expected[i].bytes);
    if (!expected[i].cloud) return;
    const definitions = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    const reader = new MessageReader(definitions);
    const cloud = reader.readMessage(message.data);
    assert.equal(reader.lastReadHadTrailingBytes(), false);
    const { sec, nanosec } = cloud.header.stamp;
    assert.equal(BigInt(sec) * 1_000_000_000n + BigInt(nanosec), message.logTime);
    assert.equal(cloud.header.frame_id, "world");
    assert.equal(cloud.format, "pcl_ext");
    assert.equal(cloud.width, expected[i].cloud.width);
    assert.equal(cloud.row_step, cloud.point_step * cloud.width);
    assert.deepEqual(cloud.fields.map((field) => field.name), ["x", "y", "z", "intensity"]);
    assert.deepEqual(cloud.fields.map((field) => field.offset), [0, 4, 8, 12]);
    assert.equal(hexOf(cloud.compressed_data), expected[i].cloud.frame);
  });

  // The statistics and all indexes.
  assert.equal(indexed.statistics.messageCount, BigInt(expected.length));
  assert.equal(indexed.statistics.chunkCount, indexed.chunkIndexes.length);
  assert.ok(indexed.chunkIndexes.length >= 3);
  for (const chunk of indexed.chunkIndexes) {
    const topics = [...chunk.messageIndexOffsets.keys()].map(
      (id) => indexed.channelsById.get(id).topic,
    );
    assert.ok(topics.length === 1 || !topics.some((topic) => topic.startsWith("/sensor")));
  }
  const metadata = [];
  for await (const record of indexed.readMetadata()) metadata.push(record);
  assert.equal(metadata.length, 1);
  assert.equal(metadata[0].name, "calibration");
  assert.deepEqual([...metadata[0].metadata], [["board", "7x5"], ["note", ""]]);
  const attachments = [];
  for await (const record of indexed.readAttachments()) attachments.push(record);
  assert.equal(attachments.length, 1);
  assert.equal(attachments[0].name, "pose.txt");
  assert.equal(attachments[0].mediaType, "text/plain");
  assert.equal(new TextDecoder().decode(attachments[0].data), "1 2 3");

  // The checksums, by reading from the beginning to the end.
  const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  stream.append(bytes);
  let count = 0;
  let dataEnd = null;
  for (let record; (record = stream.nextRecord()); ) {
    count += record.type === "Message" ? 1 : 0;
    if (record.type === "DataEnd") dataEnd = record;
  }
  assert.ok(stream.done());
  assert.equal(count, expected.length);
  const summaryStart = Number(indexed.footer.summaryStart);
  assert.notEqual(indexed.footer.summaryCrc, 0);
  assert.equal(dataEnd.dataSectionCrc, crc32(bytes.subarray(0, summaryStart - 9 - 4)));
}

const cloudDefinition = `std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: sensor_msgs/PointField
string name
uint32 offset
uint8 datatype
uint32 count
`;

/** Writes a file as other programs do, and returns what is in it. */
async function writeTheirs(file, options) {
  const parts = [];
  let size = 0n;
  const writer = new McapWriter({
    writable: {
      position: () => size,
      write: async (bytes) => {
        parts.push(Uint8Array.from(bytes));
        size += BigInt(bytes.length);
      },
    },
    ...options,
  });
  await writer.start({ profile: "ros2", library: "" });
  const cloudSchema = await writer.registerSchema({
    name: "sensor_msgs/msg/PointCloud2",
    encoding: "ros2msg",
    data: new TextEncoder().encode(cloudDefinition),
  });
  const clouds = await writer.registerChannel({
    topic: "/points",
    messageEncoding: "cdr",
    schemaId: cloudSchema,
    metadata: new Map([["offered_qos_profiles", "- history: 1"]]),
  });
  const texts = await writer.registerChannel({
    topic: "/text",
    messageEncoding: "json",
    schemaId: 0,
    metadata: new Map(),
  });
  const cdr = new MessageWriter(rosmsg.parse(cloudDefinition, { ros2: true }));
  const written = [];
  const add = async (channelId, topic, sequence, logTime, publishTime, data, cloud) => {
    await writer.addMessage({ channelId, sequence, logTime, publishTime, data });
    const line = {
      topic,
      sequence,
      log_time: String(logTime),
      publish_time: String(publishTime),
      bytes: hexOf(data),
    };
    written.push(cloud ? { ...line, cloud } : line);
  };
  for (let i = 0; i < 50; ++i) {
    const width = i % 7;
    const points = Uint8Array.from({ length: 12 * width }, (_, k) => (k * 31 + i) & 255);
    const data = cdr.writeMessage({
      header: { stamp: { sec: 1000 + i, nanosec: 999_999_999 - i }, frame_id: "f".repeat(i % 5) },
      height: 1,
      width,
      fields: ["x", "y", "zz"].map((name, k) => ({ name, offset: 4 * k, datatype: 7, count: 1 })),
      is_bigendian: false,
      point_step: 12,
      row_step: 12 * width,
      data: points,
      is_dense: i % 2 === 1,
    });
    const time = 1_000_000_000n * BigInt(1000 + i);
    await add(clouds, "/points", i, time, time - 5n, data, {
      stamp: String(time + BigInt(999_999_999 - i)),
      frame_id: "f".repeat(i % 5),
      width,
      fields: "x:0:7:1 y:4:7:1 zz:8:7:1",
      is_dense: i % 2 === 1,
      points: hexOf(points),
    });
    const text = new TextEncoder().encode(JSON.stringify({ i, text: "a".repeat(i) }));
    await add(texts, "/text", 0, time + 1n, time, text);
  }
  await writer.addMetadata({ name: "m", metadata: new Map([["k", "v"]]) });
  await writer.addAttachment({
    logTime: 5n,
    createTime: 6n,
    name: "a.bin",
    mediaType: "",
    data: Uint8Array.of(1, 2, 255),
  });
  await writer.end();
  fs.writeFileSync(file, Buffer.concat(parts));
  return written;
}

/** Lets the program read what others wrote, in all ways to write it. */
async function readTheirs() {
  const compressChunk = (bytes) => ({
    compression: "zstd",
    compressedData: zstd.compress(bytes, 3),
  });
  const ways = {
    chunks: { chunkSize: 1000 },
    zstd: { chunkSize: 2000, compressChunk },
    one_chunk: {},
    no_chunks: { useChunks: false },
    no_message_index: { chunkSize: 1000, useMessageIndex: false },
    no_chunk_index: { chunkSize: 1000, useChunkIndex: false },
    no_statistics: { chunkSize: 1000, useStatistics: false },
    no_summary: {
      chunkSize: 1000,
      useStatistics: false,
      useChunkIndex: false,
      useSummaryOffsets: false,
      repeatChannels: false,
      repeatSchemas: false,
      useAttachmentIndex: false,
      useMetadataIndex: false,
    },
  };
  for (const [name, options] of Object.entries(ways)) {
    const file = path.join(folder, `${name}.mcap`);
    const written = await writeTheirs(file, options);
    const lines = run("read", file);
    const messages = lines.filter((line) => line.kind === "message");
    assert.deepEqual(messages.map(({ kind, schema, ...message }) => message), written, name);
    assert.deepEqual(lines.filter((line) => line.kind === "metadata"), [
      { kind: "metadata", name: "m", values: { k: "v" } },
    ]);
    assert.deepEqual(lines.filter((line) => line.kind === "attachment"), [
      { kind: "attachment", name: "a.bin", log_time: "5", create_time: "6", bytes: "0102ff" },
    ]);
    assert.deepEqual(lines.filter((line) => line.kind === "damage"), [], name);
  }
  return Object.keys(ways).length;
}

await readOurs();
const ways = await readTheirs();
console.log(`@mcap/core read our file, and we read its files of ${ways} kinds`);
