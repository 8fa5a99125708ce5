// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Codec } from "@pcl_ext/codec";

import { headBytes } from "../recordings/frame_places";
import { FrameBatches } from "./frame_batches";
import type { DecodingSettings, FromWorker } from "./messages";
import type { BufferPool } from "./packed_voxels";
import { StreamDecoder, densityUnitOf } from "./stream_decoder";

export const liveHeaderBytes = 16;

/** Nanoseconds that the stamps of a stream may step back; a longer step begins the clock anew. */
const longestStepBack = 1_000_000_000n;
/** Nanoseconds from a frame to the next one that has no later stamp. */
const leastInterval = 1000n;

interface LiveStream {
  index: number;
  decoder: StreamDecoder;
  frames: number;
}

/** Decodes live frames as they come. */
export class LivePlayer {
  private readonly streams = new Map<number, LiveStream>(); // by the server's number
  private readonly names: string[] = [];
  private readonly lastTimes = new Map<number, bigint>(); // by the stream's place in the page
  private batches: FrameBatches;

  constructor(
    private readonly codec: Codec,
    private readonly pool: BufferPool,
    private settings: DecodingSettings,
    private readonly post: (message: FromWorker, transfer?: Transferable[]) => void,
  ) {
    this.batches = new FrameBatches(post);
  }

  close(): void {
    for (const stream of this.streams.values()) stream.decoder.free();
    this.streams.clear();
  }

  setSettings(settings: DecodingSettings): void {
    this.settings = settings;
  }

  /** Streams keep their places in the page by their names, also when the server was started anew. */
  setStreams(streams: { id: number; name: string; metadata: Record<string, string> }[]): void {
    this.close();
    for (const { id, name, metadata } of streams) {
      let index = this.names.indexOf(name);
      if (index < 0) index = this.names.push(name) - 1;
      const unit = densityUnitOf(metadata);
      this.streams.set(id, { index, decoder: new StreamDecoder(this.codec, unit), frames: 0 });
    }
    this.post({
      type: "streams",
      streams: this.names.map((name) => {
        const stream = streams.find((candidate) => candidate.name === name);
        return { name, metadata: stream?.metadata ?? {}, isGone: stream === undefined };
      }),
    });
  }

  /** The time of a frame, after that of the frame before it; a source that begins again begins a new clock. */
  private sortedTime(stream: number, stamp: bigint): bigint {
    const last = this.lastTimes.get(stream);
    let time = stamp;
    if (last !== undefined && stamp < last - longestStepBack) this.beginClock();
    else if (last !== undefined && stamp <= last) time = last + leastInterval;
    this.lastTimes.set(stream, time);
    return time;
  }

  private beginClock(): void {
    this.lastTimes.clear();
    this.batches = new FrameBatches(this.post);
    for (const { decoder } of this.streams.values()) decoder.forgetTimes();
    this.post({ type: "clockBegan" });
  }

  /** Decodes a message, which came at some time: stream, flags, time, and the frame. */
  decode(message: ArrayBuffer, at: number): void {
    if (message.byteLength < liveHeaderBytes) return;
    const header = new DataView(message);
    const serverId = header.getUint32(0, true);
    const stream = this.streams.get(serverId);
    if (!stream) return;
    const flags = header.getUint32(4, true);
    const hasSkipped = (flags & 1) !== 0;
    const isOld = (flags & 2) !== 0;
    const time = this.sortedTime(stream.index, header.getBigInt64(8, true));
    const bytes = new Uint8Array(message, liveHeaderBytes);
    const number = stream.frames++;
    const { status, description } = this.codec.describeFrame(bytes.subarray(0, headBytes));
    const isIFrame = status.ok && description !== null && description.kind === "I";
    this.batches.add(stream.index, {
      stream: stream.index,
      place: { file: 0, chunk: null, offset: 0, length: bytes.length, fileOffset: 0 },
      time,
      bytes: bytes.length,
      isIFrame,
      // A gap where the server skipped frames, as this page was too slow for them.
      number: hasSkipped || !description ? null : description.frameNumber,
      voxels: description?.voxels ?? 0,
      hasPoints: description?.hasPointsInOrder ?? false,
    }, time, true);
    this.batches.flush(true);
    const shown = stream.decoder.decode(
      { stream: stream.index, number, time: this.batches.secondsOf(time), bytes, frameId: null, stamp: null },
      this.settings,
      this.pool,
    );
    const wantsIFrame = stream.decoder.wantsIFrame;
    this.post({ type: "liveShown", frame: shown, serverId, wantsIFrame, at, isOld }, shown.voxels ? [shown.voxels.buffer] : []);
  }
}
