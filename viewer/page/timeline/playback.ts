// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ViewerStore } from "../state/viewer_state";
import type { FrameIndex } from "./frame_index";

/** Moves through the moments of a recording: by the clock, step by step, or by a jump. */
export class Playback {
  private time = 0; // seconds, while playing
  private lastTick = 0;
  private isBusy = false;

  constructor(
    private readonly store: ViewerStore,
    private readonly index: FrameIndex,
    /** Asks for the frames of a moment. */
    private readonly show: (moment: number) => void,
  ) {
    store.subscribe((changed) => {
      if (changed.has("isPlaying") && store.get().isPlaying) this.start();
    });
  }

  togglePlay(): void {
    if (this.store.get().source === "recording") this.store.set({ isPlaying: !this.store.get().isPlaying });
  }

  step(by: number): void {
    this.store.set({ isPlaying: false });
    this.seek(this.store.get().moment + by);
  }

  /** Goes to a moment; beyond the last one to the last one. */
  seek(moment: number): void {
    if (this.store.get().source !== "recording" || this.index.moments.length === 0) return;
    const nearest = Math.max(0, Math.min(this.index.moments.length - 1, moment));
    this.time = this.index.moments[nearest];
    this.store.set({ moment: nearest });
    this.isBusy = true;
    this.show(nearest);
  }

  /** Shows the same time again, as more frames of it are known. */
  refresh(): void {
    const moment = this.index.momentAt(this.time);
    this.store.set({ moment });
    this.show(moment);
  }

  /** To be called when the frames that were asked for last are drawn. */
  shown(): void {
    this.isBusy = false;
  }

  private start(): void {
    this.lastTick = performance.now();
    this.time = this.index.moments[this.store.get().moment] ?? 0;
    const tick = (now: number): void => {
      const { isPlaying, source, speed } = this.store.get();
      if (!isPlaying || source !== "recording") return;
      // After a pause of the page, as in another tab, time goes on where it was.
      const seconds = Math.min(0.25, (now - this.lastTick) / 1000);
      this.lastTick = now;
      this.advance(seconds * speed);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  private advance(seconds: number): void {
    const moments = this.index.moments;
    if (moments.length < 2) return;
    this.time += seconds;
    const end = this.index.duration + this.index.interval();
    if (this.time >= end) this.time = moments[0];
    const moment = this.index.momentAt(this.time);
    if (this.isBusy || moment === this.store.get().moment) return;
    this.store.set({ moment });
    this.isBusy = true;
    this.show(moment);
  }
}
