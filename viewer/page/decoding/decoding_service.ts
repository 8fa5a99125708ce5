// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { DecodingThread } from "./decoding_thread";
import type { FromWorker, ToWorker } from "./messages";

/** The page's connection to the side that decodes. */
export class DecodingService {
  private worker: Worker | null;
  private thread: DecodingThread | null = null;
  /** What was sent before the worker answered, for the case that it never does. */
  private unanswered: ToWorker[] | null = [];

  constructor(workerCode: string, wasm: ArrayBuffer, private readonly onMessage: (message: FromWorker) => void) {
    this.worker = DecodingService.startWorker(workerCode);
    if (this.worker) this.listen(this.worker);
    else this.decodeHere();
    this.post({ type: "load", wasm });
  }

  /** Some settings of browsers refuse workers that are made from a page's own text. */
  private static startWorker(code: string): Worker | null {
    try {
      const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
      return new Worker(url, { name: "pcl_ext decoder" });
    } catch {
      return null;
    }
  }

  private listen(worker: Worker): void {
    worker.onmessage = (event: MessageEvent<FromWorker>) => {
      this.unanswered = null;
      this.onMessage(event.data);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      if (this.unanswered) this.decodeHere();
      else this.onMessage({ type: "failed", message: `The decoder stopped: ${event.message}. Reload the page.` });
    };
  }

  /** Decodes in the page's own thread: less smooth, but it shows the same. */
  private decodeHere(): void {
    this.worker = null;
    // Answers come later, as those of a worker do.
    this.thread = new DecodingThread((message) => setTimeout(() => this.onMessage(message), 0));
    for (const message of this.unanswered?.splice(0) ?? []) this.thread.receive(message);
    this.unanswered = null;
  }

  post(message: ToWorker, transfer: Transferable[] = []): void {
    if (this.thread) this.thread.receive(message);
    else {
      this.worker?.postMessage(message, this.unanswered ? [] : transfer);
      this.unanswered?.push(message);
    }
  }
}
