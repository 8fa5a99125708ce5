// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { button, element, icon } from "../controls/dom";
import { formatCount, formatDate, formatSeconds } from "../controls/number_format";
import type { ViewerState, ViewerStore } from "../state/viewer_state";
import { rateText } from "./byte_rate";
import type { FrameIndex } from "./frame_index";
import { drawPlot } from "./timeline_plot";
import type { TimeSpan } from "./timeline_plot";

/** Seconds of a live source that are drawn. */
export const liveSeconds = 60;
const shownValues = ["moment", "source", "isConnected", "hasEnded", "isFrozen", "allStreams", "liveStreams", "hasProblem", "clock"] as const;
export const speeds = [0.1, 0.25, 0.5, 1, 2, 4, 8];

export interface TimelineActions {
  togglePlay(): void;
  step(by: number): void;
  seek(moment: number): void;
}

/** In a few words, whether what is shown of a live source is live. */
function stateText(state: ViewerState): string {
  const { isConnected, hasEnded, isFrozen, hasProblem, allStreams, liveStreams } = state;
  if (isFrozen) return "Paused";
  if (hasEnded) return "Ended";
  if (!isConnected) return "Waiting";
  if (liveStreams === 0) return "No frames";
  if (hasProblem) return "Problem";
  return liveStreams < allStreams ? `${liveStreams} of ${allStreams} live` : "Live";
}

/** Transport buttons and the time line with its plot. */
export class TimelineView {
  readonly root = element("div", { class: "timeline", role: "region", "aria-label": "Time" });
  private readonly play: HTMLButtonElement;
  private readonly canvas = element("canvas", { "aria-hidden": "true" });
  private readonly head = element("div", { class: "playhead" });
  private readonly track = element("div", { class: "track", role: "slider", tabindex: 0, "aria-label": "Time" });
  private readonly time = element("span", { class: "time" });
  private readonly date = element("button", { type: "button", class: "date" });
  private readonly voxels = element("span", { class: "key voxels" });
  private readonly scale = element("span", { class: "plot-scale" });
  private readonly speed = element("select", { "aria-label": "Speed", title: "Speed" });
  private readonly live = element("span", { class: "live-badge", role: "status" });
  private isWaiting = false;
  private liveTime = 0; // of the picture, in seconds since the next
  private liveStart = 0n; // nanoseconds
  private silence = 0; // see setSilence()

  constructor(
    private readonly store: ViewerStore,
    private readonly index: FrameIndex,
    private readonly actions: TimelineActions,
  ) {
    this.play = button("Play", "play", () => actions.togglePlay(), "Space");
    this.play.classList.add("primary");
    for (const speed of speeds) this.speed.append(element("option", { value: speed }, `${speed}×`));
    this.speed.addEventListener("change", () => store.set({ speed: Number(this.speed.value) }));
    const transport = element(
      "div",
      { class: "transport" },
      button("First frame", "first", () => actions.seek(0), "Home"),
      button("Step back", "previous", () => actions.step(-1), "ArrowLeft"),
      this.play,
      button("Step forward", "next", () => actions.step(1), "ArrowRight"),
      button("Last frame", "last", () => actions.seek(Infinity), "End"),
      this.speed,
    );
    this.date.addEventListener("click", () => store.set({ clock: store.get().clock === "utc" ? "local" : "utc" }));
    this.track.append(this.canvas, this.head);
    const legend = element(
      "div",
      { class: "plot-legend" },
      element("span", { class: "key bytes" }, "bytes/s"),
      this.voxels,
      element("span", { class: "key i-frame" }, "I-frame"),
      element("span", { class: "key lost" }, "lost"),
      this.scale,
    );
    this.root.append(transport, element("div", { class: "time-box" }, this.live, element("div", { class: "times" }, this.time, this.date)),
      element("div", { class: "track-box" }, this.track, legend));
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.track);
    store.subscribe((changed) => {
      if (changed.has("isPlaying") || changed.has("isFrozen") || changed.has("source")) this.showPlaying();
      if (changed.has("speed")) this.speed.value = String(store.get().speed);
      if (shownValues.some((key) => changed.has(key))) this.showTime();
      if (changed.has("source") || changed.has("theme")) this.requestDraw();
    });
  }

  private listen(): void {
    this.track.addEventListener("pointerdown", (event) => {
      this.track.setPointerCapture(event.pointerId);
      this.seekTo(event.clientX);
    });
    this.track.addEventListener("pointermove", (event) => {
      if (this.track.hasPointerCapture(event.pointerId)) this.seekTo(event.clientX);
    });
    this.track.addEventListener("keydown", (event) => {
      const steps: Record<string, () => void> = {
        ArrowRight: () => this.actions.step(1),
        ArrowUp: () => this.actions.step(1),
        ArrowLeft: () => this.actions.step(-1),
        ArrowDown: () => this.actions.step(-1),
        PageUp: () => this.actions.step(10),
        PageDown: () => this.actions.step(-10),
        Home: () => this.actions.seek(0),
        End: () => this.actions.seek(Infinity),
      };
      if (!(event.key in steps)) return;
      event.preventDefault();
      event.stopPropagation();
      steps[event.key]();
    });
  }

  private seekTo(clientX: number): void {
    if (this.store.get().source !== "recording") return;
    const box = this.track.getBoundingClientRect();
    const share = Math.min(1, Math.max(0, (clientX - box.left) / box.width));
    const time = this.span().from + share * (this.span().to - this.span().from);
    const moments = this.index.moments;
    const before = this.index.momentAt(time);
    const isNextNearer = before + 1 < moments.length && moments[before + 1] - time < time - moments[before];
    this.actions.seek(isNextNearer ? before + 1 : before);
  }

  private span(): TimeSpan {
    const end = this.index.duration;
    if (this.store.get().source === "live")
      return { from: end + this.silence - liveSeconds, to: end + this.silence };
    return { from: this.index.moments[0] ?? 0, to: end };
  }

  private showPlaying(): void {
    const { source, isFrozen } = this.store.get();
    const isPlaying = source === "live" ? !isFrozen : this.store.get().isPlaying;
    this.play.replaceChildren(icon(isPlaying ? "pause" : "play"));
    this.play.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    this.play.title = isPlaying ? "Pause (Space)" : "Play (Space)";
  }

  private showTime(): void {
    const { moment, source, isFrozen } = this.store.get();
    const isLive = source === "live";
    this.root.classList.toggle("is-live", isLive);
    this.root.classList.toggle("is-empty", source === "none" || source === "opening");
    const state = isLive ? stateText(this.store.get()) : "";
    if (this.live.textContent !== state) this.live.textContent = state;
    this.live.classList.toggle("is-connected", state === "Live");
    const moments = this.index.moments;
    const time = moments[moment] ?? 0;
    const start = moments[0] ?? 0;
    // A paused picture keeps its time and its date, also where a new time line begins meanwhile.
    if (!isFrozen) {
      this.liveTime = this.index.duration;
      this.liveStart = this.index.startTime;
    }
    const total = this.index.duration - start;
    const count = moments.length;
    const spoken = this.index.hasTimes
      ? `${formatSeconds(time - start)} of ${formatSeconds(total)}`
      : `frame ${moment + 1} of ${count}`;
    this.time.replaceChildren(
      element("b", {}, this.index.hasTimes ? formatSeconds(isLive ? this.liveTime : time - start) : `frame ${moment + 1}`),
      " ",
      element("span", {}, isLive ? "" : this.index.hasTimes ? `/ ${formatSeconds(total)}` : `/ ${count}`),
    );
    if (isLive) this.showDate(this.liveStart, this.liveTime);
    else this.showDate(this.index.startTime, time);
    this.track.setAttribute("aria-valuemin", "1");
    this.track.setAttribute("aria-valuemax", String(Math.max(1, count)));
    this.track.setAttribute("aria-valuenow", String(moment + 1));
    this.track.setAttribute("aria-valuetext", `${spoken}, frame ${moment + 1} of ${count}`);
    const { from, to } = this.span();
    this.head.style.left = `${to > from ? 100 * Math.max(0, ((isLive ? this.liveTime : time) - from) / (to - from)) : 0}%`;
  }

  private showDate(startTime: bigint, time: number): void {
    const { clock } = this.store.get();
    const parts = this.index.moments.length > 0 ? formatDate(startTime, time, clock) : null;
    this.date.hidden = parts === null;
    if (parts?.join(" ") === this.date.textContent) return;
    this.date.replaceChildren(...(parts ?? []).flatMap((part, i) => [i > 0 ? " " : "", element("span", {}, part)]));
    this.date.title = clock === "utc" ? "Coordinated universal time; click for the time zone of this computer"
      : "Time zone of this computer; click for coordinated universal time";
  }

  /** Seconds since the last frame of a live source, for which the time line goes on without frames. */
  setSilence(seconds: number): void {
    if (seconds === this.silence) return;
    this.silence = seconds;
    this.requestDraw();
  }

  /** Draws soon, once for many changes. */
  requestDraw(): void {
    if (this.isWaiting) return;
    this.isWaiting = true;
    setTimeout(() => {
      this.isWaiting = false;
      this.showTime();
      this.draw();
    }, 60);
  }

  private draw(): void {
    const width = this.track.clientWidth;
    const height = this.track.clientHeight;
    if (width === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const context = this.canvas.getContext("2d") as CanvasRenderingContext2D;
    context.scale(ratio, ratio);
    if (this.index.moments.length === 0) return;
    const styles = getComputedStyle(this.root);
    const colour = (name: string): string => styles.getPropertyValue(name);
    const scale = drawPlot(context, width, height, this.index, this.span(), {
      bytes: colour("--plot-bytes"),
      voxels: colour("--plot-voxels"),
      iFrame: colour("--plot-i-frame"),
      lost: colour("--danger"),
    });
    const { voxels, points } = this.index.counted;
    const counted = points ? (voxels ? "voxels or points" : "points") : "voxels";
    this.voxels.textContent = counted;
    const most = Math.round(scale.voxels);
    this.scale.textContent = `means up to ${rateText(this.index, scale.bytesPerSecond)} and ` +
      `${formatCount(most)} ${most === 1 ? counted.replace(/s$/, "") : counted}`;
    this.scale.title = this.scale.textContent;
  }
}
