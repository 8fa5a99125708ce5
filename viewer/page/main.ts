// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { bytesOfBase64, embeddedId } from "./sources/source_choice";
import { element } from "./controls/dom";
import { Viewer } from "./viewer";

/** Replaced by the decoder's program when the page is built. */
declare const WORKER_CODE: string;

/** Says in words why there is no viewer, instead of a blank page. */
function explain(title: string, ...lines: string[]): void {
  document.body.replaceChildren(
    element("main", { class: "fatal", role: "alert" }, element("h1", {}, title), ...lines.map((line) => element("p", {}, line))),
  );
}

function hasWebGl2(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

function start(): void {
  if (typeof WebAssembly === "undefined") {
    explain("This browser does not run WebAssembly",
      "The page decodes recordings with it. Some browsers turn it off in a protected mode: " +
      "allow it for this page, or use a current Firefox, Chrome, Edge or Safari.");
    return;
  }
  if (!hasWebGl2()) {
    explain("This browser draws no 3D graphics",
      "The page needs WebGL 2. Turn on hardware acceleration in the browser's settings, update the graphics driver, " +
      "or use a current Firefox, Chrome, Edge or Safari.");
    return;
  }
  const codec = document.getElementById("pcl-ext-codec");
  const wasm = bytesOfBase64(codec?.textContent ?? "");
  codec?.remove();
  // The body gets other contents.
  const recording = document.getElementById(embeddedId);
  if (recording) document.head.append(recording);
  new Viewer(WORKER_CODE, wasm.buffer).start();
}

function startOrExplain(): void {
  try {
    start();
  } catch (error) {
    explain("The viewer cannot start", (error as Error).message, "Reload the page; if that does not help, download it again.");
  }
}

// A recording in the page may come after this program.
if (document.readyState === "loading") addEventListener("DOMContentLoaded", startOrExplain);
else startOrExplain();
