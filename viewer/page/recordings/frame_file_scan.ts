// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Codec, FrameDescription } from "@pcl_ext/codec";

import { BlockReader } from "./byte_source";
import type { ByteSource } from "./byte_source";
import { headBytes, limitsOfIndexing } from "./frame_places";
import type { RecordingListener } from "./frame_places";

const magics = ["PCXI", "<HEAD>"].map((word) => new TextEncoder().encode(word));
const longestMagic = 6;

function startsWithMagic(bytes: Uint8Array, at: number): boolean {
  return magics.some((magic) => magic.every((byte, i) => at + i < bytes.length && bytes[at + i] === byte));
}

/** Indexes a file of frames: one after the other, without an index, perhaps with damage between them. */
export class FrameFileScan {
  private readonly blocks: BlockReader;
  private stamp: bigint | null = null; // microseconds
  private knowsStamps = false;
  private lastNumber = 0;
  private frames = 0;
  private stream = 0;
  private skippedFrom: number | null = null;
  private skipReason = "";
  private isCutOff = false;

  constructor(
    private readonly source: ByteSource,
    /** Its number among the recording's files. */
    private readonly file: number,
    private readonly codec: Codec,
    private readonly listener: RecordingListener,
  ) {
    this.blocks = new BlockReader(source);
  }

  /** Nanoseconds of the first frame; null: it has no time, or the file does not begin with a frame. */
  async firstTime(): Promise<bigint | null> {
    const head = await this.blocks.bytesAt(0, Math.min(headBytes, this.source.size));
    const { status, description } = this.codec.describeFrame(head, limitsOfIndexing);
    return status.ok && description?.stamp ? description.stamp * 1000n : null;
  }

  /** False if the file ends within a frame. Throws if there is no frame. */
  async run(progress: (at: number) => void): Promise<boolean> {
    const size = this.source.size;
    for (let at = 0; at < size; ) {
      const frame = await this.sizeAt(at);
      if (frame.bytes !== null && (await this.isFrame(at, frame.bytes))) {
        this.endSkipped(at);
        await this.addFrame(at, frame.bytes);
        at += frame.bytes;
      } else {
        this.skippedFrom ??= at;
        this.skipReason ||= frame.problem ?? "bytes of a frame are missing";
        at = await this.findMagic(at + 1);
        this.isCutOff = at >= size && frame.problem === null;
      }
      if (this.frames === 0 && at >= limitsOfIndexing.maxFrameBytes) break;
      progress(at);
    }
    if (this.frames === 0) throw new Error(this.skipReason);
    this.endSkipped(size);
    return !this.isCutOff;
  }

  private endSkipped(end: number): void {
    if (this.skippedFrom === null) return;
    const message = this.isCutOff
      ? "the file ends within a frame, which is lost"
      : `${end - this.skippedFrom} bytes that are no frame: ${this.skipReason}`;
    this.listener.addDamage({ file: this.source.name, offset: this.skippedFrom, message });
    this.skippedFrom = null;
    this.skipReason = "";
  }

  /** Bytes of the frame at a place; null with a problem if there is none, else if the file ends early. */
  private async sizeAt(at: number): Promise<{ bytes: number | null; problem: string | null }> {
    const rest = this.source.size - at;
    for (let atHand = Math.min(headBytes, rest); ; atHand = Math.min(rest, atHand * 4)) {
      try {
        const bytes = this.codec.frameSize(await this.blocks.bytesAt(at, atHand), limitsOfIndexing);
        if (bytes !== null) return { bytes, problem: null };
      } catch (error) {
        return { bytes: null, problem: (error as Error).message };
      }
      if (atHand >= rest || atHand >= limitsOfIndexing.maxFrameBytes) return { bytes: null, problem: null };
    }
  }

  /** False where bytes of the frame are missing: another frame begins within its length. */
  private async isFrame(at: number, bytes: number): Promise<boolean> {
    const end = at + bytes;
    if (end >= this.source.size) return end === this.source.size;
    if (startsWithMagic(await this.blocks.bytesAt(end, longestMagic), 0)) return true;
    return (await this.findMagic(at + 1)) >= end;
  }

  private async findMagic(from: number): Promise<number> {
    for (let at = from; at < this.source.size; ) {
      const bytes = await this.blocks.bytesAt(at, Math.min(1 << 16, this.source.size - at));
      for (let i = 0; i < bytes.length; ++i)
        if ((bytes[i] === 0x50 || bytes[i] === 0x3c) && startsWithMagic(bytes, i)) return at + i;
      if (at + bytes.length >= this.source.size) break;
      at += bytes.length - (longestMagic - 1);
    }
    return this.source.size;
  }

  private async addFrame(at: number, bytes: number): Promise<void> {
    const head = await this.blocks.bytesAt(at, Math.min(bytes, headBytes));
    const { status, description } = this.codec.describeFrame(head, limitsOfIndexing);
    if (this.frames++ === 0)
      this.stream = this.listener.addStream({ name: this.source.name.replace(/\.[^.]*$/, ""), metadata: {} });
    this.listener.addFrame({
      stream: this.stream,
      place: { file: this.file, chunk: null, offset: at, length: bytes, fileOffset: at },
      time: status.ok && description ? this.timeOf(description) : null,
      bytes,
      isIFrame: description?.kind === "I",
      number: description?.frameNumber ?? null,
      voxels: description?.voxels ?? 0,
      hasPoints: description?.hasPointsInOrder ?? false,
    });
  }

  /** Stamps are differences, and unknown between a lost frame and the next I-frame; 0 is none. */
  private timeOf(frame: FrameDescription): bigint | null {
    this.knowsStamps = frame.kind === "I" || (this.knowsStamps && frame.frameNumber === this.lastNumber + 1);
    this.lastNumber = frame.frameNumber;
    if (frame.kind === "I") this.stamp = frame.stamp ?? null;
    else if (!this.knowsStamps) this.stamp = null;
    else if (frame.stampDifference !== null)
      this.stamp = BigInt.asUintN(64, (this.stamp ?? 0n) + frame.stampDifference);
    return this.stamp ? this.stamp * 1000n : null;
  }
}
