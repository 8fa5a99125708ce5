// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { LiveBanner } from "./controls/live_banner";
import type { Notices } from "./controls/notices";
import { formatCounted, formatSilence } from "./controls/number_format";
import type { DecodingService } from "./decoding/decoding_service";
import type { FromWorker } from "./decoding/messages";
import { HeldFrames } from "./held_frames";
import { LiveConnection } from "./sources/live_connection";
import type { LiveState } from "./sources/live_connection";
import type { ViewerStore } from "./state/viewer_state";
import { compareNames, shortName } from "./stream_names";
import type { StreamsOnScreen } from "./streams_on_screen";
import type { FrameIndex } from "./timeline/frame_index";
import { liveSeconds } from "./timeline/timeline_view";
import type { TimelineView } from "./timeline/timeline_view";

const msBetweenLooks = 250;
const mostNames = 3;
/** A frame is shown later than this after it came: the page is too slow. */
const lateMs = 1000;
const rememberedMs = 5000;

/** The parts of the page that a live source changes. */
export interface LiveParts {
  store: ViewerStore;
  screen: StreamsOnScreen;
  index: FrameIndex;
  timeline: TimelineView;
  decoding: DecodingService;
  notices: Notices;
  banner: LiveBanner;
}

/** Shows a live source, and how fresh that is. */
export class LiveView {
  private readonly connection: LiveConnection;
  private readonly held: HeldFrames;
  private readonly timer: number;
  private isUpdateDue = false;
  private isShowDue = false;
  private state: LiveState & { at: number } = { problem: "", ages: [], at: 0 };
  /** From the arrival of a frame until it was shown, from picture to picture, or without reading; and when. */
  private lag = { ms: 0, at: -Infinity };
  private shownAt = performance.now();

  constructor(socket: string, private readonly parts: LiveParts) {
    const { store, decoding } = parts;
    this.held = new HeldFrames((buffer) => decoding.post({ type: "recycle", buffer }, [buffer]));
    this.connection = new LiveConnection(socket, parts.screen.clock, {
      onStreams: (streams) => {
        store.set({ source: "live", hasEnded: false });
        decoding.post({ type: "liveStreams", streams });
      },
      onState: (state) => {
        this.state = { ...state, at: performance.now() };
        this.look();
      },
      onFrame: (message) => decoding.post({ type: "liveFrame", message, at: performance.now() }, [message]),
      onConnected: () => {
        store.set({ source: "live", isConnected: true });
        parts.notices.withdraw("live");
      },
      onEnd: () => {
        store.set({ hasEnded: true });
        parts.notices.show("live", "info", "The live source has ended", ["The last frame stays."]);
      },
      onLost: (wasConnected, wait) => {
        store.set({ source: "live", isConnected: false });
        parts.notices.show("live", "warning", wasConnected ? "The connection is lost" : "The live source cannot be reached",
          [`${wasConnected ? "" : "Is the server running? "}The last frame stays, and the page tries again in ${wait.toFixed(1)} s.`]);
      },
    });
    parts.screen.clock.takeLongestGap(); // of the time before, in which nobody asked
    this.timer = window.setInterval(() => this.look(), msBetweenLooks);
  }

  close(): void {
    window.clearInterval(this.timer);
    this.connection.close();
    this.held.clear();
    this.parts.banner.show([]);
    this.parts.store.set({ allStreams: 0, liveStreams: 0, hasProblem: false });
    this.parts.timeline.setSilence(0);
  }

  /** Keeps the picture, or goes on with the newest frames. */
  toggleFrozen(): void {
    const isFrozen = !this.parts.store.get().isFrozen;
    this.parts.store.set({ isFrozen });
    if (isFrozen) return;
    this.parts.screen.removeGone();
    this.showHeld();
  }

  /** Shows the newest frames that came since the last picture, of all streams at once. */
  private showHeld(): void {
    const frames = this.held.takeAll();
    if (frames.length === 0) return;
    this.parts.screen.show(frames, true);
    this.shownAt = performance.now();
  }

  forgetHeld(streams: readonly number[]): void {
    this.held.forget(streams);
  }

  /** A frame is decoded. */
  show({ frame, serverId, wantsIFrame, at, isOld }: FromWorker & { type: "liveShown" }): void {
    const arrivals = this.parts.screen.streams[frame.stream]?.arrivals;
    if (isOld) arrivals?.addOld(this.state.at - (this.state.ages[serverId] ?? 0));
    else {
      arrivals?.add(at, frame.bytes);
      this.noteLag(performance.now() - at);
    }
    this.held.hold(frame);
    if (!this.isShowDue) {
      this.isShowDue = true;
      const heldAt = performance.now();
      requestAnimationFrame(() => {
        this.isShowDue = false;
        if (this.parts.store.get().isFrozen) return;
        // Frames that come while a picture waits are as old as the last picture.
        const now = performance.now();
        if (!document.hidden && now - heldAt > lateMs) this.noteLag(now - this.shownAt);
        this.showHeld();
      });
    }
    if (wantsIFrame) this.connection.requestIFrame(serverId);
  }

  /** The longest of late is told for a while. */
  private noteLag(ms: number): void {
    const now = performance.now();
    if (ms >= this.lag.ms || now - this.lag.at > rememberedMs) this.lag = { ms, at: now };
  }

  /** Brings the index up to date after frames, some times a second, however many frames come. */
  updateIndex(): void {
    if (this.isUpdateDue) return;
    this.isUpdateDue = true;
    setTimeout(() => {
      this.isUpdateDue = false;
      const { index } = this.parts;
      index.dropBefore(index.latestTime() - 2 * liveSeconds);
      index.update();
      this.parts.timeline.requestDraw();
    }, 200);
  }

  /** Tells which streams have stopped, and what else is wrong. */
  private look(): void {
    const { store, screen, banner, timeline } = this.parts;
    const now = performance.now();
    const streams = screen.streams.filter(({ description }) => !description.isGone);
    const silent = streams.filter(({ arrivals }) => arrivals.silence(now) !== null);
    const { hasEnded } = store.get();
    store.set({
      allStreams: streams.length,
      liveStreams: streams.filter((stream) => stream.shown && !silent.includes(stream)).length,
      hasProblem: this.state.problem !== "",
    });
    const gap = screen.clock.takeLongestGap();
    this.noteLag(silent.length < streams.length ? gap : 0);
    const lines = this.state.problem ? [this.state.problem] : [];
    if (silent.length > 0) lines.push(silenceText(silent, silent.length === streams.length, now));
    if (this.lag.ms > lateMs)
      lines.push(`This page is too slow for these streams: it shows them ${(this.lag.ms / 1000).toFixed(1)} s late`);
    banner.show(hasEnded ? [] : lines);
    const ages = streams.flatMap(({ arrivals }) => arrivals.age(now) ?? []);
    timeline.setSilence(hasEnded || ages.length === 0 ? 0 : Math.min(...ages));
    screen.updateFreshness();
  }
}

function silenceText(silent: StreamsOnScreen["streams"], isAll: boolean, now: number): string {
  silent.sort((a, b) => compareNames(shortName(a.description.name), shortName(b.description.name)));
  const seconds = silent.map(({ arrivals }) => arrivals.silence(now) ?? 0);
  if (isAll) return `No frames for ${formatSilence(Math.min(...seconds))}`;
  const names = silent.slice(0, mostNames).map(({ description }, i) =>
    `${shortName(description.name)} for ${formatSilence(seconds[i])}`);
  const more = silent.length > mostNames ? ` and of ${formatCounted(silent.length - mostNames, "stream")} more` : "";
  return `No frames of ${names.join(", ")}${more}`;
}
