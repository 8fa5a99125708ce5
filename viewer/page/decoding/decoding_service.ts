import { DecodingThread } from "./decoding_thread";
import type { FromWorker, ToWorker } from "./messages";

/** The page's connection to the side that decodes. */
export class DecodingService {
  private readonly send: (message: ToWorker, transfer: Transferable[]) => void;
  readonly isInWorker: boolean;

  constructor(workerCode: string, wasm: ArrayBuffer, receive: (message: FromWorker) => void) {
    const worker = DecodingService.startWorker(workerCode);
    this.isInWorker = worker !== null;
    if (worker) {
      worker.onmessage = (event: MessageEvent<FromWorker>) => receive(event.data);
      worker.onerror = (event) => receive({ type: "failed", message: `The decoder stopped: ${event.message}` });
      this.send = (message, transfer) => worker.postMessage(message, transfer);
    } else {
      // Answers come later, as those of a worker do.
      const thread = new DecodingThread((message) => setTimeout(() => receive(message), 0));
      this.send = (message) => void thread.receive(message);
    }
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

  post(message: ToWorker, transfer: Transferable[] = []): void {
    this.send(message, transfer);
  }
}
