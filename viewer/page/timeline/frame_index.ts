// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { FrameBatch } from "../decoding/messages";

/** Frames of one stream in its order; one entry of each array for a frame. */
export interface StreamFrames {
  times: number[]; // seconds
  bytes: number[];
  voxels: number[]; // or points
  isIFrame: boolean[];
  /** The frame cannot be decoded: it is damaged, or frames that it needs are missing. */
  isLost: boolean[];
}

/** Index of the last value that is not above another; -1 if all are. */
export function lastNotAbove(sorted: ArrayLike<number>, value: number): number {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** What the page knows of all frames: their times, sizes and losses. */
export class FrameIndex {
  streams: StreamFrames[] = [];
  /** Times at which something new is shown; frames of several streams at about the same time are one. */
  moments: number[] = [];
  startTime: bigint = 0n; // nanoseconds
  hasTimes = true;
  /** What the numbers of voxels are of, which frames tell without being decoded. */
  counted = { voxels: false, points: false };
  private isStale = false;
  private usualInterval = 0.1;

  clear(): void {
    this.streams = [];
    this.moments = [];
    this.hasTimes = true;
    this.counted = { voxels: false, points: false };
    this.isStale = false;
    this.usualInterval = 0.1;
  }

  add(batch: FrameBatch): void {
    for (let i = 0; i < batch.streams.length; ++i) {
      const stream = batch.streams[i];
      while (this.streams.length <= stream)
        this.streams.push({ times: [], bytes: [], voxels: [], isIFrame: [], isLost: [] });
      const frames = this.streams[stream];
      if (batch.voxels[i] > 0) this.counted[batch.hasPoints[i] ? "points" : "voxels"] = true;
      const isIFrame = batch.isIFrame[i] === 1;
      const last = frames.isLost.length - 1;
      frames.times.push(batch.times[i]);
      frames.bytes.push(batch.bytes[i]);
      frames.voxels.push(batch.voxels[i]);
      frames.isIFrame.push(isIFrame);
      frames.isLost.push(!isIFrame && (batch.isGap[i] === 1 || (last >= 0 && frames.isLost[last])));
    }
    this.isStale = true;
  }

  /** Marks a frame that could not be decoded, and those that depend on it. */
  markLost(stream: number, number: number): void {
    const frames = this.streams[stream];
    if (!frames) return;
    for (let i = number; i < frames.isLost.length && (i === number || !frames.isIFrame[i]); ++i)
      frames.isLost[i] = true;
  }

  /** Time of the last frame of any stream. */
  latestTime(): number {
    return this.streams.reduce((latest, { times }) => Math.max(latest, times[times.length - 1] ?? 0), 0);
  }

  get duration(): number {
    return this.moments.length ? this.moments[this.moments.length - 1] : 0;
  }

  /** Brings the moments up to date after frames were added. */
  update(): void {
    if (!this.isStale) return;
    this.isStale = false;
    this.usualInterval = this.findInterval();
    const tolerance = this.interval() / 2;
    this.moments = [];
    let first = -Infinity;
    let before = -Infinity; // the last time of the moment that is not its end
    let streams = new Set<number>(); // with a frame in the moment
    for (const [stream, time] of this.inOrder()) {
      const last = this.moments.length - 1;
      // Two frames of a stream are two moments, however near they are.
      if (time - first < tolerance && !streams.has(stream)) {
        if (time > this.moments[last]) before = this.moments[last];
        this.moments[last] = time;
        streams.add(stream);
        continue;
      }
      // What came at the same time belongs to the new moment.
      if (time === this.moments[last] && before > -Infinity) this.moments[last] = before;
      this.moments.push(time);
      first = time;
      before = -Infinity;
      streams = new Set([stream]);
    }
  }

  /** Streams and times of all frames in the order of the times, each stream's being sorted. */
  private *inOrder(): Generator<[number, number]> {
    const next = this.streams.map(() => 0);
    for (;;) {
      let earliest = -1;
      for (let i = 0; i < next.length; ++i) {
        const { times } = this.streams[i];
        if (next[i] < times.length && (earliest < 0 || times[next[i]] < this.streams[earliest].times[next[earliest]]))
          earliest = i;
      }
      if (earliest < 0) return;
      yield [earliest, this.streams[earliest].times[next[earliest]++]];
    }
  }

  /** Usual seconds between two frames of the stream that has the most. */
  interval(): number {
    return this.usualInterval;
  }

  private findInterval(): number {
    let longest: number[] = [];
    for (const { times } of this.streams) if (times.length > longest.length) longest = times;
    const steps = longest.slice(1).map((time, i) => time - longest[i]).filter((step) => step > 0);
    steps.sort((a, b) => a - b);
    return steps.length ? steps[steps.length >> 1] : 0.1;
  }

  momentAt(time: number): number {
    return Math.max(0, lastNotAbove(this.moments, time));
  }

  /** Number of the frame of a stream at a moment; -1 before its first. */
  frameAt(stream: number, moment: number): number {
    return lastNotAbove(this.streams[stream].times, this.moments[moment] ?? 0);
  }

  /** Forgets frames before a time, for live sources that never end. */
  dropBefore(time: number): void {
    for (const frames of this.streams) {
      const count = lastNotAbove(frames.times, time) + 1;
      if (count === 0) continue;
      for (const list of [frames.times, frames.bytes, frames.voxels]) list.splice(0, count);
      for (const list of [frames.isIFrame, frames.isLost]) list.splice(0, count);
      this.isStale = true;
    }
  }
}
