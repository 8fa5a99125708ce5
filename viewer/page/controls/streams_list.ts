// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { cssColour } from "../scene/colour_maps";
import type { Rgb } from "../scene/colour_maps";
import type { ViewerStore } from "../state/viewer_state";
import { compareNames } from "../stream_names";
import { element } from "./dom";
import { formatCount, formatSilence, formatTenths } from "./number_format";

interface StreamRow {
  row: HTMLElement;
  input: HTMLInputElement;
  age: HTMLElement;
  count: HTMLElement;
  note: HTMLElement;
}

/** The streams by name with their colours, each to be switched on and off. */
export class StreamsList {
  readonly root = element("ul", { class: "streams" });
  private rows: StreamRow[] = []; // of the streams in their own order
  private names: string[] = [];

  constructor(private readonly store: ViewerStore) {
    store.subscribe((changed) => {
      if (changed.has("hiddenStreams")) this.showHidden();
    });
  }

  setStreams(names: readonly string[], colours: readonly Rgb[]): void {
    this.names = [...names];
    this.rows = names.map((name, stream) => {
      const input = element("input", { type: "checkbox" });
      input.addEventListener("change", () => this.setVisible(name, input.checked));
      const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.background = cssColour(colours[stream]);
      const age = element("span", { class: "age", title: "Since its last frame" });
      const count = element("span", { class: "count" });
      const note = element("span", { class: "stream-note" });
      const label = element("span", { class: "stream-name", title: name }, name);
      const row = element("li", {}, element("label", {}, input, swatch, label, age, count), note);
      return { row, input, age, count, note };
    });
    const order = names.map((_, i) => i).sort((a, b) => compareNames(names[a], names[b]));
    this.root.replaceChildren(...order.map((stream) => this.rows[stream].row));
    this.showHidden();
  }

  private setVisible(name: string, isVisible: boolean): void {
    const others = this.store.get().hiddenStreams.filter((hidden) => hidden !== name);
    this.store.set({ hiddenStreams: isVisible ? others : [...others, name] });
  }

  private showHidden(): void {
    const hidden = this.store.get().hiddenStreams;
    this.rows?.forEach(({ input }, i) => void (input.checked = !hidden.includes(this.names[i])));
  }

  /** Seconds since the last frame; null: it has none, or the source is not live. */
  setAge(stream: number, seconds: number | null): void {
    const row = this.rows[stream];
    if (row) row.age.textContent = seconds === null ? "" : seconds < 10 ? formatTenths(seconds) : formatSilence(seconds);
  }

  setCount(stream: number, voxels: number | null): void {
    const row = this.rows[stream];
    if (row) row.count.textContent = voxels === null ? "–" : formatCount(voxels);
  }

  setNote(stream: number, problem: string | null): void {
    const row = this.rows[stream];
    if (!row) return;
    row.note.textContent = problem ?? "";
    row.row.classList.toggle("has-problem", problem !== null);
  }
}
