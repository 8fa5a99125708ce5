// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { AwakeClock } from "./awake_clock";

export const liveProtocol = "pcl_ext.live.v1";
const firstWaitMs = 500;
const longestWaitMs = 5000;
/** The server tells its state once a second; one that does not for so long is lost, or the way to it is. */
const longestSilenceMs = 6000;
const msBetweenLooks = 500;

export interface LiveStreamDescription {
  id: number;
  name: string;
  metadata: Record<string, string>;
}

/** How fresh the streams are at the server. */
export interface LiveState {
  /** What is wrong with the source, a sentence; empty: nothing is known to be. */
  problem: string;
  /** By the id of the stream: milliseconds since its last frame; null: it has had none. */
  ages: readonly (number | null)[];
}

export interface LiveEvents {
  onStreams(streams: LiveStreamDescription[]): void;
  onState(state: LiveState): void;
  onFrame(message: ArrayBuffer): void;
  onEnd(): void;
  onConnected(): void;
  /** The connection is gone, or there has never been one; the next attempt follows after some seconds. */
  onLost(wasConnected: boolean, waitSeconds: number): void;
}

function describe(value: unknown): LiveStreamDescription | null {
  const stream = value as { id?: unknown; name?: unknown; metadata?: unknown };
  if (typeof stream?.id !== "number" || typeof stream.name !== "string") return null;
  const metadata = Object.entries((stream.metadata ?? {}) as Record<string, unknown>);
  return { id: stream.id, name: stream.name, metadata: Object.fromEntries(metadata.map(([k, v]) => [k, String(v)])) };
}

/** A connection to a live source, which is made again whenever it is lost. */
export class LiveConnection {
  private socket: WebSocket | null = null;
  private waitMs = firstWaitMs;
  private timer = 0;
  private silence = 0; // timer
  private heardAt = 0; // by the clock
  private tellsState = false;
  private hasEnded = false;
  private wasConnected = false;
  private isClosed = false;

  constructor(
    private readonly url: string,
    private readonly clock: AwakeClock,
    private readonly events: LiveEvents,
  ) {
    this.connect();
  }

  close(): void {
    this.isClosed = true;
    window.clearTimeout(this.timer);
    window.clearInterval(this.silence);
    this.socket?.close();
  }

  requestIFrame(stream: number): void {
    if (this.socket?.readyState === WebSocket.OPEN)
      this.socket.send(JSON.stringify({ type: "i-frame", stream }));
  }

  private connect(): void {
    let isOpen = false;
    this.tellsState = false;
    this.heardAt = this.clock.now();
    const socket = new WebSocket(this.url, liveProtocol);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      isOpen = true;
      this.wasConnected = true;
      this.waitMs = firstWaitMs;
      this.events.onConnected();
    };
    const onClose = (): void => {
      window.clearInterval(this.silence);
      socket.onmessage = socket.onclose = null;
      if (this.isClosed || (this.hasEnded && isOpen)) return;
      this.events.onLost(this.wasConnected, this.waitMs / 1000);
      this.timer = window.setTimeout(() => this.connect(), this.waitMs);
      this.waitMs = Math.min(longestWaitMs, this.waitMs * 1.7);
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      if (typeof event.data === "string") this.receiveText(event.data);
      else this.events.onFrame(event.data);
      this.heardAt = this.clock.now();
    };
    socket.onclose = onClose;
    window.clearInterval(this.silence);
    this.silence = window.setInterval(() => {
      if (this.clock.now() - this.heardAt <= longestSilenceMs || !this.tellsState) return;
      onClose(); // which the browser tells only much later
      socket.close();
    }, msBetweenLooks);
  }

  private receiveText(text: string): void {
    let message: { type?: unknown; streams?: unknown; problem?: unknown; ages_ms?: unknown };
    try {
      message = JSON.parse(text) as typeof message;
    } catch {
      return; // not of this protocol
    }
    if (message.type === "streams" && Array.isArray(message.streams)) {
      this.hasEnded = false;
      this.events.onStreams(message.streams.map(describe).filter((stream) => stream !== null));
    } else if (message.type === "state") {
      this.tellsState = true;
      const ages = Array.isArray(message.ages_ms) ? message.ages_ms : [];
      this.events.onState({
        problem: String(message.problem ?? ""),
        ages: ages.map((age) => (typeof age === "number" ? age : null)),
      });
    } else if (message.type === "end") {
      this.hasEnded = true;
      this.events.onEnd();
    }
  }
}
