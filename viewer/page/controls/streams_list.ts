import { cssColour, streamColour } from "../scene/colour_maps";
import type { ViewerStore } from "../state/viewer_state";
import { element } from "./dom";
import { formatCount } from "./number_format";

interface StreamRow {
  row: HTMLElement;
  input: HTMLInputElement;
  count: HTMLElement;
  note: HTMLElement;
}

/** The streams with their colours, each to be switched on and off. */
export class StreamsList {
  readonly root = element("ul", { class: "streams" });
  private rows: StreamRow[] = [];
  private names: string[] = [];

  constructor(private readonly store: ViewerStore) {
    store.subscribe((changed) => {
      if (changed.has("hiddenStreams")) this.showHidden();
    });
  }

  setStreams(names: readonly string[]): void {
    this.names = [...names];
    this.rows = names.map((name, stream) => {
      const input = element("input", { type: "checkbox" });
      input.addEventListener("change", () => this.setVisible(name, input.checked));
      const swatch = element("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.background = cssColour(streamColour(stream));
      const count = element("span", { class: "count" });
      const note = element("span", { class: "stream-note" });
      const label = element("span", { class: "stream-name", title: name }, name);
      const row = element("li", {}, element("label", {}, input, swatch, label, count), note);
      return { row, input, count, note };
    });
    this.root.replaceChildren(...this.rows.map(({ row }) => row));
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

  setCount(stream: number, voxels: number | null, problem: string | null): void {
    const row = this.rows[stream];
    if (!row) return;
    row.count.textContent = voxels === null ? "–" : formatCount(voxels);
    row.note.textContent = problem ?? "";
    row.row.classList.toggle("has-problem", problem !== null);
  }
}
