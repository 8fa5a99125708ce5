// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Codec } from "@pcl_ext/codec";

import { SourceError } from "./byte_source";
import type { ByteSource } from "./byte_source";
import { readCompressedCloud } from "./cdr";
import { decompressChunk } from "./chunk_decompression";
import { FrameFileScan } from "./frame_file_scan";
import type { ChunkPlace, Damage, FoundFrame, FramePlace, RecordedStream, RecordingListener } from "./frame_places";
import * as records from "./mcap_records";
import { McapScan } from "./mcap_scan";
import { McapStreams } from "./mcap_streams";
import { Transforms } from "./transforms";

/** Bags that pcl_ext reads and this page does not, by what they begin with. */
const otherBags = [
  ["SQLite format 3", "a bag with the storage sqlite3"],
  ["#ROSBAG", "a bag of ROS 1"],
  ["\x28\xb5\x2f\xfd", "compressed by file, with zstd"],
] as const;

/** Why a file of frames is none. */
function problemOf({ name, size }: ByteSource, head: Uint8Array, error: Error): string {
  if (size === 0) return `“${name}” is empty.`;
  const beginning = String.fromCharCode(...head);
  const bag = otherBags.find(([magic]) => beginning.startsWith(magic));
  return bag
    ? `“${name}” is ${bag[1]}, which browsers do not read: “pcl_ext encode” makes a recording of its clouds; ` +
      `where they are compressed already, “pcl_ext cut ${name} -o x.mcap” copies them.`
    : `“${name}” is not a recording: ${error.message}.`;
}

/** A frame without a time follows the one before after this many nanoseconds. */
const assumedInterval = 100_000_000n;
const chunksInMemory = 8;

/** Nanoseconds that stamps of a stream may step back; after a longer step its time goes on. */
const longestStepBack = 1_000_000_000n;
/** Nanoseconds from a frame to the next one that has no later stamp: each is a moment of its own. */
const leastInterval = 1000n;

export interface IndexedFrame {
  place: FramePlace | null; // null: it is lost
  time: bigint; // above that of the frame before it in its stream
  isIFrame: boolean;
}

/** The bytes of a frame with what its message tells of it. */
export interface ReadFrame {
  bytes: Uint8Array;
  frameId: string | null;
  /** Of the cloud, nanoseconds; null: unknown. */
  stamp: bigint | null;
}

/** What the page learns while a recording is indexed. */
export interface RecordingEvents {
  onStream(stream: RecordedStream): void;
  onFrame(stream: number, frame: FoundFrame, time: bigint): void;
  onDamage(damage: Damage): void;
  onRemark(message: string): void;
  onProgress(share: number): void;
}

/** A recording in one or several files; can be read while it is still being indexed. */
export class Recording implements RecordingListener {
  readonly frames: IndexedFrame[][] = []; // of each stream
  /** Of the first frame, where it is known before all frames are. */
  startTime: bigint | null = null;
  readonly transforms = new Transforms();
  private isMcap = false;
  private readonly timed: boolean[] = []; // of each stream: its frames have times
  private readonly shifts: bigint[] = []; // of each stream: from its stamps to its times
  private readonly numbers: (number | null)[] = []; // of each stream: the encoder's for the last frame
  private hasStepBack = false;
  private readonly chunks = new Map<ChunkPlace, Uint8Array>();

  constructor(
    private readonly files: ByteSource[],
    private readonly codec: Codec,
    private readonly events: RecordingEvents,
  ) {}

  /** Indexes all files. Throws SourceError if there is nothing to show. Returns false if a file ends early. */
  async index(): Promise<boolean> {
    if (this.files.every(({ size }) => size === 0)) throw new SourceError(`“${this.files[0].name}” is empty.`);
    const heads = await Promise.all(this.files.map((file) => file.read(0, 16)));
    this.isMcap = heads.some(records.isMcap);
    if (!this.isMcap) return this.indexFrameFiles(heads);
    const streams = new McapStreams(this.codec, this, this.transforms);
    let before = 0;
    let isWhole = true;
    for (let i = 0; i < this.files.length; ++i) {
      const scan = new McapScan(this.files[i], i, streams, this);
      const done = before;
      isWhole = (await scan.run((at) => this.progress((done + at) / this.bytes))) && isWhole;
      before += this.files[i].size;
    }
    const others = streams.otherClouds();
    if (others) this.addRemark(others + ".");
    for (const remark of this.transforms.remarks()) this.addRemark(`Transforms: ${remark}.`);
    if (!streams.hasStreams)
      throw new SourceError(
        `“${this.files[0].name}” has no clouds compressed by pcl_ext. ` + (others ? others + "." : ""),
      );
    return isWhole;
  }

  /** Each file of frames is a stream; others are named, as long as there is one. */
  private async indexFrameFiles(heads: readonly Uint8Array[]): Promise<boolean> {
    const scans = this.files.map((file, i) => new FrameFileScan(file, i, this.codec, this));
    for (const time of await Promise.all(scans.map((scan) => scan.firstTime())))
      if (time !== null && (this.startTime === null || time < this.startTime)) this.startTime = time;
    const problems: string[] = [];
    let before = 0;
    let isWhole = true;
    for (const [i, scan] of scans.entries()) {
      try {
        isWhole = (await scan.run((at) => this.progress((before + at) / this.bytes))) && isWhole;
      } catch (error) {
        if (error instanceof SourceError) throw error;
        problems.push(problemOf(this.files[i], heads[i], error as Error));
      }
      before += this.files[i].size;
    }
    if (problems.length === this.files.length)
      throw new SourceError(`${problems.join(" ")} The page shows .mcap and .pcxi files, as “pcl_ext encode” makes them.`);
    for (const problem of problems) this.addRemark(problem);
    return isWhole;
  }

  /** Of all files. */
  get bytes(): number {
    return this.files.reduce((sum, { size }) => sum + size, 0);
  }

  /** False if no stream has times. */
  get hasTimes(): boolean {
    return this.timed.length === 0 || this.timed.includes(true);
  }

  addStream(stream: RecordedStream): number {
    this.frames.push([]);
    this.timed.push(true);
    this.shifts.push(0n);
    this.events.onStream(stream);
    return this.frames.length - 1;
  }

  addFrame(frame: FoundFrame): void {
    const frames = this.frames[frame.stream];
    if (frames.length === 0) this.timed[frame.stream] = frame.time !== null;
    const time = frames.length ? this.timeAfter(frames, frame) : (frame.time ?? this.startTime ?? 0n);
    this.numbers[frame.stream] = frame.number;
    frames.push({ place: frame.place, time, isIFrame: frame.isIFrame });
    this.events.onFrame(frame.stream, frame, time);
  }

  /** The time of a frame after others of its stream. */
  private timeAfter(frames: readonly IndexedFrame[], { stream, time: stamp, number, isIFrame }: FoundFrame): bigint {
    const before = frames[frames.length - 1].time;
    const next = before + (this.timed[stream] ? leastInterval : assumedInterval);
    if (stamp === null) return next;
    const time = stamp + this.shifts[stream];
    if (time > before) return time;
    const last = this.numbers[stream] ?? null;
    const isAnother = isIFrame && number !== null && last !== null && number <= last; // encoder's run
    if (!isAnother && before - time <= longestStepBack) return next;
    const interval = frames.length > 1 ? before - frames[frames.length - 2].time : assumedInterval;
    this.shifts[stream] += before + interval - time;
    if (!this.hasStepBack)
      this.addRemark("Stamps begin again: the frames behind that place follow those before it, at the times from there on.");
    this.hasStepBack = true;
    return before + interval;
  }

  addDamage(damage: Damage): void {
    this.events.onDamage(damage);
  }

  addRemark(message: string): void {
    this.events.onRemark(message);
  }

  progress(share: number): void {
    this.events.onProgress(share);
  }

  /** Number of the I-frame at or before a frame; 0 if there is none. */
  iFrameBefore(stream: number, number: number): number {
    const frames = this.frames[stream];
    while (number > 0 && !frames[number].isIFrame) --number;
    return number;
  }

  async read(stream: number, number: number): Promise<ReadFrame> {
    const { place } = this.frames[stream][number];
    if (!place) throw new SourceError("the part of the file that had this frame is damaged");
    const bytes = place.chunk
      ? (await this.chunkOf(place)).subarray(place.offset, place.offset + place.length)
      : await this.files[place.file].read(place.offset, place.length);
    if (!this.isMcap) return { bytes, frameId: null, stamp: null };
    const cloud = readCompressedCloud(bytes);
    if (!cloud)
      throw new SourceError(`a message at byte ${place.fileOffset} of “${this.files[place.file].name}” is damaged`);
    return { bytes: cloud.frame, frameId: cloud.frameId, stamp: cloud.stamp };
  }

  private async chunkOf(place: FramePlace): Promise<Uint8Array> {
    const chunk = place.chunk as ChunkPlace;
    let bytes = this.chunks.get(chunk);
    this.chunks.delete(chunk);
    if (!bytes) {
      const stored = await this.files[place.file].read(chunk.offset, chunk.length);
      bytes = decompressChunk(chunk.compression, stored, chunk.size).bytes;
    }
    this.chunks.set(chunk, bytes); // the last one is that of the latest use
    for (const oldest of this.chunks.keys()) {
      if (this.chunks.size <= chunksInMemory) break;
      this.chunks.delete(oldest);
    }
    return bytes;
  }
}
