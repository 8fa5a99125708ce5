// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { Codec } from "@pcl_ext/codec";

import type { Damage } from "../recordings/frame_places";
import { LivePlayer } from "./live_player";
import type { DecodingSettings, FromWorker, OpenFile, ToWorker } from "./messages";
import { BufferPool } from "./packed_voxels";
import { RecordingPlayer } from "./recording_player";

/** What happens on the side that decodes: in a worker, or where that is refused in the page's own thread. */
export class DecodingThread {
  private codec: Codec | null = null;
  private player: RecordingPlayer | LivePlayer | null = null;
  private source = -1; // the page's number for what is played
  /** The recording that is to be played next, as soon as it has frames. */
  private candidate: RecordingPlayer | null = null;
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
      this.candidate?.setSettings(message.settings);
    }
    if (message.type === "open") this.open(codec, message.source, message.files);
    else if (message.type === "openLive")
      this.play(new LivePlayer(codec, this.pool, this.settings, this.post), message.source);
    else if (message.type === "show" && message.source === this.source && this.player instanceof RecordingPlayer)
      this.player.show(message.request, message.frames);
    else if (message.type === "liveStreams" && this.player instanceof LivePlayer)
      this.player.setStreams(message.streams);
    else if (message.type === "liveFrame" && this.player instanceof LivePlayer)
      this.player.decode(message.message, message.at);
  }

  /** Plays a recording in place of what is played, if it has frames. */
  private open(codec: Codec, source: number, files: OpenFile[]): void {
    this.candidate?.close();
    const held: FromWorker[] = []; // until there are frames
    const damage: Damage[] = [];
    const player = new RecordingPlayer(codec, this.pool, this.settings, (message, transfer) => {
      if (this.player === player) {
        this.post(message, transfer);
        return;
      }
      if (message.type === "damage") damage.push(message.damage);
      if (message.type === "failed" || message.type === "indexed") {
        const problem = message.type === "failed" ? message.message : "None of its frames can be read.";
        this.candidate = null;
        player.close();
        this.post({ type: "refused", source, message: problem, damage });
      } else held.push(message);
      if (message.type !== "frames" || message.batch.bytes.every((bytes) => bytes === 0)) return; // all are lost
      this.play(player, source);
      for (const one of held) this.post(one);
    });
    this.candidate = player;
    void player.open(files);
  }

  private play(player: RecordingPlayer | LivePlayer, source: number): void {
    this.player?.close();
    if (this.candidate !== player) this.candidate?.close();
    this.candidate = null;
    this.player = player;
    this.source = source;
    this.post({ type: "opened", source });
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
