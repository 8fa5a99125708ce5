// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ViewerStore } from "../state/viewer_state";
import { button, element } from "./dom";

const groups: [string, [string, string][]][] = [
  ["Time", [
    ["Space", "play, pause; live: keep the picture while time goes on"],
    ["← →", "step by a frame"],
    ["Shift + ← →", "step by ten"],
    ["Home End", "first, last frame"],
    [", .", "slower, faster"],
  ]],
  ["Voxels", [
    ["[ ]", "lower, raise the threshold"],
    ["O", "outlier filter on, off"],
    ["N", "hide noise, colour it"],
    ["1 – 5", "colour by intensity, height, stream, last seen, recorded colour"],
    ["C", "cubes, points"],
  ]],
  ["View", [
    ["Click", "mark a voxel; Shift + click another one: the distance"],
    ["F", "fit the voxels into the view, but for the farthest 2 %"],
    ["W A S D", "turn"],
    ["+ −", "zoom"],
    ["G", "floor grid on, off"],
    ["T", "light, dark"],
  ]],
  ["Files", [
    ["Ctrl + O", "open a recording"],
    ["E", "export the frame as PLY"],
    ["P", "export a picture"],
    ["?", "this help"],
  ]],
];

/** The keys, as a dialogue. */
export function createHelp(store: ViewerStore): HTMLDialogElement {
  const dialogue = element("dialog", { class: "help", "aria-labelledby": "help-title" });
  const close = (): void => store.set({ showsHelp: false });
  const columns = groups.map(([title, keys]) =>
    element("section", {}, element("h3", {}, title),
      element("dl", {}, ...keys.flatMap(([key, text]) => [
        element("dt", {}, ...key.split(" ").map((part) => (/^[+–]$/.test(part) && key.includes(" + ") || part === "–" ? ` ${part} ` : element("kbd", {}, part)))),
        element("dd", {}, text),
      ]))));
  dialogue.append(
    element("header", {}, element("h2", { id: "help-title" }, "Keys"), button("Close help", "close", close, "Escape")),
    element("div", { class: "help-columns" }, ...columns),
    element("p", { class: "hint" },
      "Drag turns, right button or two fingers move, wheel or pinch zoom. A click on a voxel tells what it is. " +
      "Files are read on this computer only; nothing is sent anywhere."),
  );
  dialogue.addEventListener("close", close);
  dialogue.addEventListener("click", (event) => {
    if (event.target === dialogue) close();
  });
  store.subscribe(() => {
    const { showsHelp } = store.get();
    if (showsHelp && !dialogue.open) dialogue.showModal();
    if (!showsHelp && dialogue.open) dialogue.close();
  });
  return dialogue;
}
