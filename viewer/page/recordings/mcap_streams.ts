// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { McapTypes } from "@mcap/core";
import type { Codec } from "@pcl_ext/codec";

import { readCompressedCloud } from "./cdr";
import { headBytes, limitsOfIndexing } from "./frame_places";
import type { FramePlace, RecordingListener } from "./frame_places";
import * as records from "./mcap_records";
import { isStaticTopic, isTransformType, readTransforms } from "./transform_messages";
import type { Transforms } from "./transforms";

export const compressedCloudType = "point_cloud_interfaces/msg/CompressedPointCloud2";
const plainCloudTypes = ["sensor_msgs/msg/PointCloud2", "sensor_msgs/PointCloud2"]; // of ROS 2 and ROS 1

interface Channel {
  topic: string;
  type: string;
  encoding: string; // of its messages
  metadata: Record<string, string>;
  stream: number | null;
  format: string | null;
  lostTimes: bigint[]; // of messages before the next one that can be read
}

function isOurs(format: string): boolean {
  return format === "pcl_ext" || format.startsWith("pcl_ext/");
}

/** Turns the channels and messages of MCAP files into streams and frames. */
export class McapStreams {
  private readonly schemas = new Map<string, string>(); // by file and number
  private readonly channels = new Map<string, Channel>();
  private readonly streamsByName = new Map<string, number>();
  private readonly unreadable = new Set<Channel>();

  constructor(
    private readonly codec: Codec,
    private readonly listener: RecordingListener,
    private readonly transforms: Transforms,
  ) {}

  addDescription(file: number, opcode: number, content: Uint8Array): void {
    const record = new Uint8Array(records.recordHeaderSize + content.length);
    record[0] = opcode;
    new DataView(record.buffer).setBigUint64(1, BigInt(content.length), true);
    record.set(content, records.recordHeaderSize);
    let parsed;
    try {
      parsed = records.parseRecord(record);
    } catch {
      return; // the messages of this channel are then unknown
    }
    if (parsed?.type === "Schema") this.schemas.set(`${file}:${parsed.id}`, parsed.name);
    if (parsed?.type === "Channel")
      this.addChannel(file, parsed, this.schemas.get(`${file}:${parsed.schemaId}`) ?? "");
  }

  addChannel(file: number, channel: McapTypes.Channel, type: string): void {
    const key = `${file}:${channel.id}`;
    if (this.channels.has(key)) return;
    const metadata = Object.fromEntries(channel.metadata);
    this.channels.set(key, { topic: channel.topic, type, encoding: channel.messageEncoding, metadata, stream: null, format: null, lostTimes: [] });
  }

  /** Messages that the index of a lost chunk tells of. */
  addLostMessages(file: number, index: Uint8Array): void {
    const { channel = -1, logTimes = [] } = records.readMessageIndex(index) ?? {};
    const lost = this.channels.get(`${file}:${channel}`);
    if (lost?.type === compressedCloudType) lost.lostTimes = lost.lostTimes.concat(logTimes);
  }

  /** Adds what is lost of a file behind its last frames, and the streams of which no frame could be read. */
  addSilentStreams(file: number): void {
    for (const [key, channel] of this.channels) {
      const isOurChannel = channel.type === compressedCloudType && isOurs(channel.format ?? "pcl_ext");
      if (key.startsWith(`${file}:`) && isOurChannel) this.addLostFrames(file, channel);
    }
  }

  /** @returns the channel's stream */
  private addLostFrames(file: number, channel: Channel): number {
    const stream = (channel.stream ??= this.streamOf(file, channel));
    for (const time of channel.lostTimes.splice(0))
      this.listener.addFrame({ stream, place: null, time, bytes: 0, isIFrame: false, number: null, voxels: 0, hasPoints: false });
    return stream;
  }

  addMessage(file: number, message: Uint8Array, place: FramePlace): void {
    const header = records.readMessageHeader(message);
    const channel = this.channels.get(`${file}:${header.channel}`);
    if (!channel) return;
    const content = message.subarray(records.messageHeaderSize);
    if (isTransformType(channel.type)) this.addTransforms(channel, content);
    if (channel.type !== compressedCloudType) return;
    const cloud = readCompressedCloud(content);
    if (!cloud) {
      this.unreadable.add(channel);
      return;
    }
    channel.format ??= cloud.format;
    if (!isOurs(cloud.format)) return;
    const stream = this.addLostFrames(file, channel);
    const { status, description } = this.codec.describeFrame(cloud.frame.subarray(0, headBytes), limitsOfIndexing);
    this.listener.addFrame({
      stream,
      place,
      time: header.logTime,
      bytes: cloud.frame.length,
      isIFrame: status.ok && description !== null && description.kind === "I",
      number: status.ok && description ? description.frameNumber : null,
      voxels: description?.voxels ?? 0,
      hasPoints: description?.hasPointsInOrder ?? false,
    });
  }

  private addTransforms(channel: Channel, content: Uint8Array): void {
    const transforms = readTransforms(content, channel.encoding);
    if (!transforms) this.unreadable.add(channel);
    for (const transform of transforms ?? []) this.transforms.add(transform, isStaticTopic(channel.topic));
  }

  /** Of two channels with one topic in a file, the second one is a stream of its own. */
  private streamOf(file: number, channel: Channel): number {
    let uses = 0;
    for (const [key, other] of this.channels) {
      if (key.startsWith(`${file}:`) && other.topic === channel.topic && isOurs(other.format ?? "")) ++uses;
      if (other === channel) break;
    }
    const name = channel.topic + (uses > 1 ? `#${uses}` : "");
    const known = this.streamsByName.get(name);
    const stream = known ?? this.listener.addStream({ name, metadata: channel.metadata });
    this.streamsByName.set(name, stream);
    return stream;
  }

  get hasStreams(): boolean {
    return this.streamsByName.size > 0;
  }

  /** Topics with clouds that are not of this library, in words; null if there are none. */
  otherClouds(): string | null {
    const all = [...this.channels.values()];
    const foreign = all.filter((c) => c.format !== null && !isOurs(c.format));
    const plain = all.filter((c) => plainCloudTypes.includes(c.type));
    const parts: string[] = [];
    if (foreign.length)
      parts.push(
        `${foreign.map((c) => `${c.topic} (${c.format || "no format"})`).join(", ")}: compressed in ` +
          "another format, which this page does not decode",
      );
    if (plain.length)
      parts.push(
        `${plain.map((c) => c.topic).join(", ")}: not compressed; “pcl_ext encode” makes a recording of them`,
      );
    for (const channel of this.unreadable)
      parts.push(`${channel.topic}: some messages are not ${channel.type}`);
    return parts.length ? parts.join(". ") : null;
  }
}
