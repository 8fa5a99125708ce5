// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { DecodingThread } from "./decoding_thread";
import type { ToWorker } from "./messages";

interface WorkerScope {
  postMessage(message: unknown, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
}

const scope = self as unknown as WorkerScope;
const thread = new DecodingThread((message, transfer = []) => scope.postMessage(message, transfer));
scope.onmessage = (event) => thread.receive(event.data);
