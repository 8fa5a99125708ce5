// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { speeds } from "./timeline/timeline_view";
import type { ColourBy, ViewerStore } from "./state/viewer_state";

export interface KeyActions {
  togglePlay(): void;
  step(by: number): void;
  seek(moment: number): void;
  fit(): void;
  moveCamera(turn: number, tilt: number, zoom: number): void;
  changeThreshold(by: number): void;
  toggleTheme(): void;
  open(): void;
  exportPly(): void;
  exportPicture(): void;
  deselect(): void;
}

const colours: ColourBy[] = ["intensity", "height", "stream", "age", "recorded"];

function isTyping(target: EventTarget | null): boolean {
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement ||
    (target instanceof HTMLInputElement && target.type !== "checkbox");
}

function changeSpeed(store: ViewerStore, by: number): void {
  const at = speeds.indexOf(store.get().speed) + by;
  if (at >= 0 && at < speeds.length) store.set({ speed: speeds[at] });
}

/** Keys that work wherever the focus is, but in fields for text and numbers. */
export function listenToKeys(store: ViewerStore, actions: KeyActions): void {
  const keys: Record<string, (event: KeyboardEvent) => void> = {
    " ": () => actions.togglePlay(),
    ArrowLeft: (event) => actions.step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => actions.step(event.shiftKey ? 10 : 1),
    Home: () => actions.seek(0),
    End: () => actions.seek(Infinity),
    ",": () => changeSpeed(store, -1),
    ".": () => changeSpeed(store, 1),
    "[": () => actions.changeThreshold(-1),
    "]": () => actions.changeThreshold(1),
    o: () => store.set({ removesOutliers: !store.get().removesOutliers }),
    n: () => store.set({ noise: store.get().noise === "hide" ? "colour" : "hide" }),
    c: () => store.set({ shape: store.get().shape === "cubes" ? "points" : "cubes" }),
    f: () => actions.fit(),
    w: () => actions.moveCamera(0, -0.1, 1),
    s: () => actions.moveCamera(0, 0.1, 1),
    a: () => actions.moveCamera(-0.1, 0, 1),
    d: () => actions.moveCamera(0.1, 0, 1),
    "+": () => actions.moveCamera(0, 0, 1 / 1.15),
    "=": () => actions.moveCamera(0, 0, 1 / 1.15),
    "-": () => actions.moveCamera(0, 0, 1.15),
    g: () => store.set({ showsGrid: !store.get().showsGrid }),
    t: () => actions.toggleTheme(),
    e: () => actions.exportPly(),
    p: () => actions.exportPicture(),
    "?": () => store.set({ showsHelp: !store.get().showsHelp }),
    Escape: () => (store.get().showsPanel ? store.set({ showsPanel: false }) : actions.deselect()),
  };
  colours.forEach((colourBy, i) => (keys[String(i + 1)] = () => store.set({ colourBy })));
  addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "o") {
      event.preventDefault();
      actions.open();
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
    if (store.get().showsHelp && event.key !== "?") return; // the dialogue's own keys
    // Space presses a button that has the focus.
    if (event.key === " " && (event.target instanceof HTMLButtonElement || event.target instanceof HTMLInputElement)) return;
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act(event);
  });
}
