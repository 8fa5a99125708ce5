// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { FoundFrame } from "../recordings/frame_places";
import type { FrameBatch, FromWorker } from "./messages";

/** Frames that are sent to the page together while a recording is indexed. */
const framesOfBatch = 2000;
const msBetweenReports = 200;

/** Collects indexed frames, and finds gaps in the encoder's numbers. */
export class FrameBatches {
  private startTime: bigint | null = null;
  private lastReport = 0;
  private readonly lastNumbers: (number | null)[] = [];
  private waiting: { stream: number; time: bigint; frame: FoundFrame; isGap: boolean }[] = [];
  private hasTimes = true;

  constructor(private readonly send: (message: FromWorker) => void) {}

  /** Seconds count from this time instead of that of the first frame that is found. */
  startAt(time: bigint): void {
    this.startTime = time;
  }

  /** Seconds since the start. */
  secondsOf(time: bigint): number {
    return Number(time - (this.startTime ?? time)) / 1e9;
  }

  add(stream: number, frame: FoundFrame, time: bigint, hasTimes: boolean): void {
    this.startTime ??= time;
    this.hasTimes = hasTimes;
    const last = this.lastNumbers[stream] ?? null;
    const isGap =
      frame.number === null ||
      (last === null ? !frame.isIFrame : frame.number > last + 1 || (frame.number <= last && !frame.isIFrame));
    if (frame.number !== null) this.lastNumbers[stream] = frame.number;
    this.waiting.push({ stream, time, frame, isGap });
    if (this.waiting.length >= framesOfBatch) this.flush(hasTimes);
  }

  report(share: number): void {
    const now = performance.now();
    if (now - this.lastReport < msBetweenReports) return;
    this.lastReport = now;
    this.flush(this.hasTimes);
    this.send({ type: "progress", share });
  }

  flush(hasTimes: boolean): void {
    const frames = this.waiting;
    if (frames.length === 0 || this.startTime === null) return;
    this.waiting = [];
    const batch: FrameBatch = {
      streams: Uint16Array.from(frames, (f) => f.stream),
      times: Float64Array.from(frames, (f) => this.secondsOf(f.time)),
      bytes: Uint32Array.from(frames, (f) => f.frame.bytes),
      voxels: Uint32Array.from(frames, (f) => f.frame.voxels),
      hasPoints: Uint8Array.from(frames, (f) => (f.frame.hasPoints ? 1 : 0)),
      isIFrame: Uint8Array.from(frames, (f) => (f.frame.isIFrame ? 1 : 0)),
      isGap: Uint8Array.from(frames, (f) => (f.isGap ? 1 : 0)),
    };
    this.send({ type: "frames", startTime: this.startTime, batch, hasTimes });
  }
}
