// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { GuessedUp } from "../guessed_up";
import { gradientOf } from "../scene/colour_maps";
import type { IntensityAxis } from "../scene/intensity_axis";
import type { ViewDirection } from "../scene/scene_camera";
import type { ColourBy, ViewerState, ViewerStore } from "../state/viewer_state";
import { fieldOf, longestDecay, noCut, trailSeconds, voxelScales } from "../state/viewer_state";
import { CutControl } from "./cut_control";
import { button, choice, element, section, toggle } from "./dom";
import { createMoreBelow } from "./more_below";
import { formatInRange, formatNumber } from "./number_format";
import { StreamsList } from "./streams_list";
import { ThresholdControl } from "./threshold_control";

export interface PanelActions {
  fit(direction: ViewDirection): void;
  exportPly(): void;
  exportPicture(): void;
  copyLink(): void;
}

const colourNames: Record<Exclude<ColourBy, `field:${string}`>, string> = {
  intensity: "Intensity",
  height: "Height",
  stream: "Stream",
  age: "Last seen",
  recorded: "Recorded colour",
};

const upNames: Record<ViewerState["up"], string> = { auto: "Auto", z: "z", "-z": "−z", y: "y", "-y": "−y" };

/** All settings of what is drawn. */
export class ControlPanel {
  readonly root = element("aside", { class: "panel", id: "panel", "aria-label": "Settings" });
  readonly threshold: ThresholdControl;
  readonly streams: StreamsList;
  private readonly colourBy = element("select", { "aria-label": "Colour by" });
  private fields: readonly string[] = []; // that streams have
  private readonly cut: CutControl;
  private readonly up = element("select", { "aria-label": "Up" });
  private readonly legendBar = element("div", { class: "legend-bar" });
  private readonly legendTicks = element("div", { class: "ticks" });
  private readonly removed = element("p", { class: "hint", "aria-live": "off" });
  private readonly filterRemark = element("p", { class: "hint warning-text" });
  private readonly updaters: ((state: ViewerState) => void)[] = [];
  private axis: IntensityAxis | null = null;
  private fieldAxis: IntensityAxis | null = null;
  private heights: [number, number] = [0, 1];

  constructor(
    private readonly store: ViewerStore,
    private readonly actions: PanelActions,
  ) {
    this.cut = new CutControl(store);
    this.threshold = new ThresholdControl((threshold) => store.set({ threshold }));
    this.streams = new StreamsList(store);
    this.root.append(this.colourSection(), this.noiseSection(), section("Streams", this.streams.root),
      this.viewSection(), this.exportSection());
    this.root.append(createMoreBelow(this.root));
    store.subscribe((changed) => {
      const state = store.get();
      for (const update of this.updaters) update(state);
      if (changed.has("threshold")) this.threshold.setThreshold(state.threshold);
      if (changed.has("colourBy")) this.showLegend();
    });
  }

  private colourSection(): HTMLElement {
    for (const [value, name] of Object.entries(colourNames)) this.colourBy.append(element("option", { value }, name));
    this.colourBy.addEventListener("change", () => this.store.set({ colourBy: this.colourBy.value as ColourBy }));
    this.updaters.push(({ colourBy }) => {
      this.offerFields();
      this.threshold.setColoured(colourBy === "intensity");
    });
    return section("Colour by", this.colourBy, element("div", { class: "legend" }, this.legendBar, this.legendTicks));
  }

  private noiseSection(): HTMLElement {
    const filter = toggle("Outlier filter", (removesOutliers) => this.store.set({ removesOutliers }));
    const noise = choice("noise", { hide: "Hide noise", colour: "Colour it" }, (value) => this.store.set({ noise: value }));
    this.updaters.push((state) => {
      filter.set(state.removesOutliers);
      noise.set(state.noise);
    });
    filter.row.title = "The library's VoxelOutlierRemoval: judges each voxel by those around it and by the frames before (O)";
    return section("Noise", this.threshold.root, filter.row, noise.row, this.removed, this.filterRemark);
  }

  private viewSection(): HTMLElement {
    const shape = choice("shape", { cubes: "Cubes", points: "Points" }, (value) => this.store.set({ shape: value }));
    const size = element("input", { type: "range", ...voxelScales, step: 0.05, "aria-label": "Voxel size" });
    const sizeText = element("output", {});
    size.addEventListener("input", () => this.store.set({ voxelScale: Number(size.value) }));
    const decay = element("input", { type: "range", min: 0, max: longestDecay, step: 0.5, "aria-label": "Decay time" });
    const decayText = element("output", {});
    decay.addEventListener("input", () => this.store.set({ decaySeconds: Number(decay.value) }));
    const toggles = (
      [["showsGrid", "Floor grid"], ["showsAxes", "Axes"], ["showsSensors", "Sensors"], ["showsCropBox", "Crop box"],
        ["followsSensor", "Follow"]] as const
    ).map(([key, label]) => {
      const made = toggle(label, (isOn) => this.store.set({ [key]: isOn }));
      this.updaters.push((state) => made.set(state[key]));
      made.row.dataset.toggle = key;
      if (key === "followsSensor") made.row.title = "The camera goes with the first stream of the list whose sensor moves";
      return made.row;
    });
    this.updaters.push((state) => {
      shape.set(state.shape);
      size.value = String(state.voxelScale);
      sizeText.textContent = `${Math.round(100 * state.voxelScale)} %`;
      decay.value = String(state.decaySeconds);
      decayText.textContent = state.decaySeconds > 0 ? `${state.decaySeconds} s` : "off";
      decay.setAttribute("aria-valuetext", decayText.textContent);
    });
    for (const [value, name] of Object.entries(upNames)) this.up.append(element("option", { value }, name));
    this.up.addEventListener("change", () => this.store.set({ up: this.up.value as ViewerState["up"], ...noCut }));
    this.updaters.push((state) => void (this.up.value = state.up));
    this.updaters.push((state) => this.cut.show(state));
    const views = element("div", { class: "buttons" });
    for (const [direction, label] of [["oblique", "Fit"], ["top", "Top"], ["front", "Front"], ["side", "Side"]] as const)
      views.append(button(label, null, () => this.actions.fit(direction)));
    return section("View", shape.row,
      element("label", { class: "row" }, element("span", {}, "Voxel size"), size, sizeText),
      element("label", { class: "row" }, element("span", {}, "Up"), this.up),
      ...this.cut.rows,
      element("label", { class: "row", title: "Frames stay so long that others have followed, as in RViz and Foxglove" },
        element("span", {}, "Decay time"), decay, decayText),
      element("div", { class: "toggles" }, ...toggles), views);
  }

  private exportSection(): HTMLElement {
    return section("Keep", element("div", { class: "buttons" },
      button("PLY", null, () => this.actions.exportPly(), "E"),
      button("Picture", null, () => this.actions.exportPicture(), "P"),
      button("Copy link", null, () => this.actions.copyLink())));
  }

  /** Offers the fields of the streams, and one that is chosen, as by a link, in any case. */
  private offerFields(): void {
    const { colourBy } = this.store.get();
    const chosen = fieldOf(colourBy);
    const names = chosen === null || this.fields.includes(chosen) ? this.fields : [...this.fields, chosen];
    const offered = [...this.colourBy.options].filter(({ value }) => fieldOf(value) !== null);
    // Replaced options would close a list that is open.
    if (names.join("\n") !== offered.map(({ value }) => fieldOf(value)).join("\n")) {
      for (const option of offered) option.remove();
      this.colourBy.append(...names.map((name) => element("option", { value: `field:${name}` }, `Field ${name}`)));
    }
    this.colourBy.value = colourBy;
  }

  /** What streams have, so that settings for other things are not offered. */
  setContents(contents: {
    hasColours: boolean; hasIntensities: boolean; hasSensors: boolean; hasCropBox: boolean; fields: readonly string[];
  }): void {
    this.fields = contents.fields;
    this.offerFields();
    for (const option of this.colourBy.options)
      option.hidden = option.disabled =
        (option.value === "recorded" && !contents.hasColours) ||
        (option.value === "intensity" && !contents.hasIntensities);
    this.threshold.root.hidden = !contents.hasIntensities;
    for (const [key, isThere] of [["showsSensors", contents.hasSensors], ["showsCropBox", contents.hasCropBox]] as const) {
      const row = this.root.querySelector<HTMLElement>(`[data-toggle=${key}]`);
      if (row) row.hidden = !isThere;
    }
  }

  /** Says whether a sensor moves, which can be followed. */
  setMoving(isMoving: boolean): void {
    const row = this.root.querySelector<HTMLElement>("[data-toggle=followsSensor]");
    if (row) row.hidden = !isMoving;
  }

  setRemoved(kept: number, all: number, filterRemark: string | null): void {
    const share = all > 0 ? (100 * (all - kept)) / all : 0;
    this.removed.textContent = all === kept ? "No voxel counts as noise." : `${share.toFixed(1)} % of the voxels count as noise.`;
    this.filterRemark.textContent = filterRemark ?? "";
  }

  setAxis(axis: IntensityAxis): void {
    this.axis = axis;
    this.threshold.setAxis(axis);
    this.showLegend();
  }

  /** Null: there are no values. */
  setFieldAxis(axis: IntensityAxis | null): void {
    this.fieldAxis = axis;
    if (fieldOf(this.store.get().colourBy) !== null) this.showLegend();
  }

  setGuessedUp({ up, reason }: GuessedUp): void {
    this.up.options[0].text = `${upNames[up]}, ${reason}`;
    this.up.title = this.up.options[0].text;
  }

  setHeights(heights: [number, number]): void {
    this.heights = heights;
    this.cut.setHeights(heights);
    this.showLegend();
  }

  private intensityTicks(): [number, string][] {
    if (!this.axis) return [];
    const axis = this.axis.brightAxis();
    return axis.ticks().map((value) => {
      const isMore = value === axis.max && axis.max < (this.axis?.max ?? 0);
      return [axis.shareOf(value), formatNumber(value) + (isMore ? " +" : "")];
    });
  }

  private fieldTicks(): [number, string][] {
    if (!this.fieldAxis) return [[0, "no values"]];
    const { min, bright, max, step } = this.fieldAxis;
    const text = (value: number): string => formatInRange(value, bright - min);
    const middle = step === 1 ? Math.round((min + bright) / 2) : (min + bright) / 2;
    const ticks: [number, string][] = [[0, text(min)]];
    if (middle > min && middle < bright && text(middle).length < 12) ticks.push([(middle - min) / (bright - min), text(middle)]);
    if (bright > min) ticks.push([1, text(bright) + (bright < max ? " +" : "")]);
    return ticks;
  }

  private ticks(colourBy: ColourBy): [number, string][] {
    const [low, high] = this.heights;
    if (colourBy === "intensity") return this.intensityTicks();
    if (colourBy === "height") {
      const step = Math.max(1e-5, Math.min(1, high - low || 1)); // that the digits tell
      return [0, 0.5, 1].map((share) => [share, `${formatInRange(low + share * (high - low), step)} m`]);
    }
    return colourBy === "age" ? [[0, "now"], [1, `${trailSeconds} s ago`]] : this.fieldTicks();
  }

  private showLegend(): void {
    const { colourBy } = this.store.get();
    const legend = this.legendBar.parentElement as HTMLElement;
    legend.hidden = colourBy === "stream" || colourBy === "recorded";
    if (colourBy === "stream" || colourBy === "recorded") return;
    this.legendBar.style.background = gradientOf(colourBy === "height" || colourBy === "age" ? colourBy : "intensity");
    this.legendTicks.replaceChildren(
      ...this.ticks(colourBy).map(([share, text]) => {
        const tick = element("span", {}, text);
        tick.style.left = `${100 * share}%`;
        tick.style.transform = `translateX(${-100 * share}%)`;
        return tick;
      }),
    );
  }
}
