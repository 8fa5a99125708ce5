export const liveProtocol = "pcl_ext.live.v1";
const firstWaitMs = 500;
const longestWaitMs = 5000;

export interface LiveStreamDescription {
  id: number;
  name: string;
  metadata: Record<string, string>;
}

export interface LiveEvents {
  onStreams(streams: LiveStreamDescription[]): void;
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
  private hasEnded = false;
  private wasConnected = false;
  private isClosed = false;

  constructor(
    private readonly url: string,
    private readonly events: LiveEvents,
  ) {
    this.connect();
  }

  close(): void {
    this.isClosed = true;
    window.clearTimeout(this.timer);
    this.socket?.close();
  }

  requestIFrame(stream: number): void {
    if (this.socket?.readyState === WebSocket.OPEN)
      this.socket.send(JSON.stringify({ type: "i-frame", stream }));
  }

  private connect(): void {
    let isOpen = false;
    const socket = new WebSocket(this.url, liveProtocol);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      isOpen = true;
      this.wasConnected = true;
      this.waitMs = firstWaitMs;
      this.events.onConnected();
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      if (typeof event.data === "string") this.receiveText(event.data);
      else this.events.onFrame(event.data);
    };
    socket.onclose = () => {
      if (this.isClosed || (this.hasEnded && isOpen)) return;
      this.events.onLost(this.wasConnected, this.waitMs / 1000);
      this.timer = window.setTimeout(() => this.connect(), this.waitMs);
      this.waitMs = Math.min(longestWaitMs, this.waitMs * 1.7);
    };
  }

  private receiveText(text: string): void {
    let message: { type?: unknown; streams?: unknown };
    try {
      message = JSON.parse(text) as typeof message;
    } catch {
      return; // not of this protocol
    }
    if (message.type === "streams" && Array.isArray(message.streams)) {
      this.hasEnded = false;
      this.events.onStreams(message.streams.map(describe).filter((stream) => stream !== null));
    } else if (message.type === "end") {
      this.hasEnded = true;
      this.events.onEnd();
    }
  }
}
