// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Codec } from "@pcl_ext/codec";

import { BlobBytes, MemoryBytes, openUrl } from "../recordings/byte_source";
import type { ByteSource } from "../recordings/byte_source";
import { CachedBytes } from "../recordings/cached_bytes";
import type { FoundFrame, RecordedStream } from "../recordings/frame_places";
import { Recording } from "../recordings/recording";
import { FrameBatches } from "./frame_batches";
import type { DecodingSettings, FrameFailure, FromWorker, OpenFile, ShownFrame, WantedFrame } from "./messages";
import type { BufferPool } from "./packed_voxels";
import { ShownFrameCache } from "./shown_frame_cache";
import { StreamDecoder, densityUnitOf } from "./stream_decoder";

/** Frames before a wanted one that the outlier filter sees, as many as its running means have: then it judges few voxels
 * otherwise than in a run from the start, 4 of 18,000 of the robot cell's. */
const filterMemory = 16;

/** Of a decoder that no frame follows. */
const noFrame = Number.MAX_SAFE_INTEGER;

/** Decoding pauses after this time, so that a later request is heard and replaces the present one. */
const msBetweenPauses = 15;

interface PlayedStream {
  decoder: StreamDecoder;
  next: number; // number of the frame that follows the last decoded one
}

async function openFile(file: OpenFile): Promise<ByteSource> {
  if ("blob" in file) return new CachedBytes(new BlobBytes(file.name, file.blob));
  if ("bytes" in file) return new MemoryBytes(file.name, file.bytes);
  return new CachedBytes(await openUrl(file.url, file.name));
}

/** Indexes a recording and decodes the frames that the page asks for. */
export class RecordingPlayer {
  private recording: Recording | null = null;
  private readonly descriptions: RecordedStream[] = [];
  private readonly streams: PlayedStream[] = [];
  private readonly cache = new ShownFrameCache();
  private readonly batches: FrameBatches;
  private readonly damaged = new Set<string>(); // frames that were told of
  private toldStreams = 0; // that the page was told of
  private placedFrames = 0; // of coordinates, likewise
  private isClosed = false;
  private latestRequest = -1;
  private lastPause = 0;
  private work: Promise<void> = Promise.resolve();

  constructor(
    private readonly codec: Codec,
    private readonly pool: BufferPool,
    private settings: DecodingSettings,
    private readonly post: (message: FromWorker, transfer?: Transferable[]) => void,
  ) {
    this.batches = new FrameBatches((message) => {
      this.tellStreams();
      this.send(message);
    });
  }

  private send(message: FromWorker, transfer: Transferable[] = []): void {
    if (!this.isClosed) this.post(message, transfer);
  }

  close(): void {
    this.isClosed = true;
    for (const stream of this.streams) stream.decoder.free();
  }

  async open(files: OpenFile[]): Promise<void> {
    try {
      const sources = await Promise.all(files.map(openFile));
      this.recording = new Recording(sources, this.codec, {
        onStream: (stream) => this.addStream(stream),
        onFrame: (stream, frame, time) => this.addFrame(stream, frame, time),
        onDamage: (damage) => this.send({ type: "damage", damage }),
        onRemark: (message) => this.send({ type: "remark", message }),
        onProgress: (share) => {
          this.batches.report(share);
          this.reportPlaces();
        },
      });
      const isWhole = await this.recording.index();
      this.batches.flush(this.recording.hasTimes);
      if (!this.recording.transforms.isEmpty) this.send({ type: "placesChanged" });
      this.tellStreams();
      this.send({ type: "indexed", isWhole });
    } catch (error) {
      this.batches.flush(true);
      this.send({ type: "failed", message: (error as Error).message });
    }
  }

  private reportPlaces(): void {
    const { size } = (this.recording as Recording).transforms;
    if (size === this.placedFrames) return;
    this.placedFrames = size;
    this.send({ type: "placesChanged" });
  }

  private addStream(stream: RecordedStream): void {
    this.descriptions.push(stream);
    const unit = densityUnitOf(stream.metadata);
    this.streams.push({ decoder: new StreamDecoder(this.codec, unit), next: 0 });
  }

  /** Tells of all streams at once, before their frames: of one after the other a thousand take a minute. */
  private tellStreams(): void {
    if (this.toldStreams === this.descriptions.length) return;
    this.toldStreams = this.descriptions.length;
    this.send({ type: "streams", streams: this.descriptions });
  }

  private addFrame(stream: number, frame: FoundFrame, time: bigint): void {
    const { startTime, hasTimes } = this.recording as Recording;
    if (startTime !== null) this.batches.startAt(startTime);
    this.batches.add(stream, frame, time, hasTimes);
  }

  /** For frames that are asked for from now on. */
  setSettings(settings: DecodingSettings): void {
    this.work = this.work.then(() => {
      this.settings = settings;
      this.cache.clear();
      // The filter and the trail begin anew, from the same frames as after a jump to this one.
      for (const stream of this.streams) stream.next = noFrame;
    });
  }

  /** Decodes frames and sends them together, unless others are wanted by then. */
  show(request: number, frames: WantedFrame[]): void {
    this.latestRequest = request;
    this.work = this.work.then(() => this.decodeAll(request, frames)).catch((error: Error) => {
      this.send({ type: "remark", message: error.message });
      this.send({ type: "shown", request, frames: [] });
    });
  }

  private async decodeAll(request: number, frames: WantedFrame[]): Promise<void> {
    const shown: ShownFrame[] = [];
    for (const wanted of frames) {
      if (this.isClosed) return;
      if (request !== this.latestRequest) break;
      shown.push(this.placed(await this.decode(wanted, request)));
    }
    this.send({ type: "shown", request, frames: shown },
      shown.flatMap((frame) => (frame.voxels ? [frame.voxels.buffer] : [])));
  }

  /** Places a frame by the transforms that are known now. */
  private placed(frame: ShownFrame): ShownFrame {
    const { transforms, frames } = this.recording as Recording;
    if (transforms.isEmpty || !frame.frameId) return frame;
    const stamp = frame.stamp || frames[frame.stream][frame.number].time;
    return { ...frame, placement: transforms.placeOf(frame.frameId.replace(/^\//, ""), Number(stamp)) };
  }

  /** Decodes from the I-frame before on, or from where the last call ended. */
  private async decode(wanted: WantedFrame, request: number): Promise<ShownFrame> {
    const { stream, number } = wanted;
    const known = this.cache.find(stream, number, this.pool);
    if (known) return known;
    const recording = this.recording as Recording;
    const played = this.streams[stream];
    if (number !== played.next) {
      const first = recording.iFrameBefore(stream, Math.max(0, number - this.memory(stream, number)));
      if (played.next <= first || played.next > number) {
        played.decoder.restart();
        played.next = first;
      }
    }
    let shown = await this.decodeNext(stream, played);
    while (played.next <= number && request === this.latestRequest) {
      if (shown.voxels) this.pool.give(shown.voxels.buffer);
      shown = await this.decodeNext(stream, played);
    }
    return shown;
  }

  /** Frames before one that what is drawn of it depends on, besides those that it needs itself. */
  private memory(stream: number, number: number): number {
    if (this.settings.trailSeconds > 0) {
      const frames = (this.recording as Recording).frames[stream];
      const earliest = frames[number].time - BigInt(Math.round(this.settings.trailSeconds * 1e9));
      let first = number;
      while (first > 0 && frames[first - 1].time >= earliest) --first;
      return Math.max(number - first, this.settings.removesOutliers ? filterMemory : 0);
    }
    return this.settings.removesOutliers ? filterMemory : 0;
  }

  private async decodeNext(stream: number, played: PlayedStream): Promise<ShownFrame> {
    if (performance.now() - this.lastPause > msBetweenPauses) {
      await new Promise((resolve) => setTimeout(resolve, 0));
      this.lastPause = performance.now();
    }
    const recording = this.recording as Recording;
    const number = played.next++;
    const time = this.batches.secondsOf(recording.frames[stream][number].time);
    let bytes = new Uint8Array(0) as Uint8Array;
    let frameId: string | null = null;
    let stamp: bigint | null = null;
    try {
      ({ bytes, frameId, stamp } = await recording.read(stream, number));
    } catch (error) {
      return this.lostFrame(stream, number, time, (error as Error).message);
    }
    const shown = played.decoder.decode({ stream, number, time, bytes, frameId, stamp }, this.settings, this.pool);
    const { failure } = played.decoder;
    if (shown.problem && failure) this.reportFailure(stream, number, shown.problem, failure);
    this.cache.add(shown);
    return shown;
  }

  /** Tells once of a frame that cannot be decoded. */
  private reportFailure(stream: number, number: number, problem: string, failure: FrameFailure): void {
    const key = `${stream} ${number}`;
    if (this.damaged.has(key)) return;
    this.damaged.add(key);
    this.send({ type: "undecodable", stream, name: this.descriptions[stream].name, number, problem, failure });
  }

  private lostFrame(stream: number, number: number, time: number, problem: string): ShownFrame {
    return {
      stream, number, time, problem,
      voxels: null, warning: null, filterProblem: null, frameId: null, stamp: null, placement: null, resolution: 0, intensityRange: null,
      fields: [], isIFrame: false, bytes: 0, decodeMs: 0,
    };
  }
}
