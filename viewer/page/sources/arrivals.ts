// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { AwakeClock } from "./awake_clock";

const rateMs = 2000; // of which the rate is a mean
const fewestIntervals = 10;
const leastSilenceMs = 2000;
const intervalsOfSilence = 3;

/** When the frames of one live stream came. Times are those of performance.now(). */
export class Arrivals {
  private recent: { at: number; bytes: number }[] = [];
  private last: number | null = null;
  private first: number | null = null; // of those that came

  private readonly begin = performance.now(); // since when frames are waited for
  private waitsSince: number; // by the clock

  constructor(private readonly clock: AwakeClock) {
    this.waitsSince = clock.now();
  }

  /** A frame came. */
  add(at: number, bytes: number): void {
    this.first ??= at;
    this.last = at;
    this.waitsSince = this.clock.now();
    this.recent.push({ at, bytes });
    while (this.recent.length > fewestIntervals + 1 && this.recent[0].at < at - rateMs) this.recent.shift();
  }

  /** A frame was there before the page; its time is an estimate of the server's. */
  addOld(published: number): void {
    this.last = Math.max(this.last ?? -Infinity, published);
    this.waitsSince = this.clock.now() - (performance.now() - this.last);
  }

  /** Seconds since the last frame; null if there was none. */
  age(now: number): number | null {
    return this.last === null ? null : Math.max(0, now - this.last) / 1000;
  }

  /** Seconds without a frame, if the next one should have come and been read; else null. */
  silence(now: number): number | null {
    const waited = this.clock.now() - this.waitsSince;
    if (waited <= Math.max(leastSilenceMs, intervalsOfSilence * this.usualInterval())) return null;
    return (now - (this.last ?? this.begin)) / 1000;
  }

  /** The median of the last intervals, ms; 0: it is not known. */
  private usualInterval(): number {
    const last = this.recent.slice(-fewestIntervals - 1);
    const intervals = last.slice(1).map(({ at }, i) => at - last[i].at).sort((a, b) => a - b);
    return intervals[intervals.length >> 1] ?? 0;
  }

  bytesPerSecond(now: number): number {
    if (this.first === null) return 0;
    const bytes = this.recent.reduce((sum, frame) => sum + (frame.at > now - rateMs ? frame.bytes : 0), 0);
    return (1000 * bytes) / Math.min(rateMs, Math.max(rateMs / 4, now - this.first));
  }
}
