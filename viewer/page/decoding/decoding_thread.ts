// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Codec } from "@pcl_ext/codec";

import { LivePlayer } from "./live_player";
import type { DecodingSettings, FromWorker, ToWorker } from "./messages";
import { BufferPool } from "./packed_voxels";
import { RecordingPlayer } from "./recording_player";

/** What happens on the side that decodes: in a worker, or where that is refused in the page's own thread. */
export class DecodingThread {
  private codec: Codec | null = null;
  private player: RecordingPlayer | LivePlayer | null = null;
  /** Messages that came before the codec was ready. */
  private readonly early: ToWorker[] = [];
  private readonly pool = new BufferPool();
  private settings: DecodingSettings = { removesOutliers: false, trailSeconds: 0, field: null };

  constructor(private readonly post: (message: FromWorker, transfer?: Transferable[]) => void) {}

  receive(message: ToWorker): void {
    if (message.type === "load") void this.load(message.wasm);
    else if (this.codec) this.handle(this.codec, message);
    else this.early.push(message);
  }

  private handle(codec: Codec, message: ToWorker): void {
    if (message.type === "recycle") this.pool.give(message.buffer);
    if (message.type === "settings") {
      this.settings = message.settings;
      this.player?.setSettings(message.settings);
    }
    if (message.type === "open") {
      this.player?.close();
      this.post({ type: "opened" });
      const player = new RecordingPlayer(codec, this.pool, this.settings, this.post);
      this.player = player;
      void player.open(message.files);
    } else if (message.type === "openLive") {
      this.player?.close();
      this.post({ type: "opened" });
      this.player = new LivePlayer(codec, this.pool, this.settings, this.post);
    } else if (message.type === "show" && this.player instanceof RecordingPlayer)
      this.player.show(message.request, message.frames);
    else if (message.type === "liveStreams" && this.player instanceof LivePlayer)
      this.player.setStreams(message.streams);
    else if (message.type === "liveFrame" && this.player instanceof LivePlayer)
      this.player.decode(message.message, message.at);
  }

  private async load(wasm: ArrayBuffer): Promise<void> {
    try {
      this.codec = await Codec.load(wasm);
      this.post({ type: "loaded" });
      for (const message of this.early.splice(0)) this.handle(this.codec, message);
    } catch (error) {
      this.post({ type: "failed", message: `The decoder cannot start: ${(error as Error).message}` });
    }
  }
}
