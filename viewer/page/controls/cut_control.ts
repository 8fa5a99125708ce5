// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ViewerState, ViewerStore } from "../state/viewer_state";
import { element } from "./dom";
import { formatInRange } from "./number_format";

const steps = 200;

/** Two sliders for the heights between which voxels are drawn; at its end each one cuts nothing. */
export class CutControl {
  readonly rows: HTMLElement[];
  private readonly sliders: { input: HTMLInputElement; output: HTMLOutputElement; key: "cutAbove" | "cutBelow" }[];
  private heights: [number, number] = [0, 1];

  constructor(private readonly store: ViewerStore) {
    this.sliders = (["cutAbove", "cutBelow"] as const).map((key) => {
      const label = key === "cutAbove" ? "Cut above" : "Cut below";
      const input = element("input", { type: "range", min: 0, max: steps, "aria-label": label });
      input.addEventListener("input", () => this.store.set({ [key]: this.heightAt(key, Number(input.value)) }));
      return { input, output: element("output"), key };
    });
    this.rows = this.sliders.map(({ input, output }) => {
      output.classList.add("height");
      return element("label", { class: "row" }, element("span", {}, input.getAttribute("aria-label")), input, output);
    });
  }

  private heightAt(key: "cutAbove" | "cutBelow", step: number): number {
    if (key === "cutAbove" ? step === steps : step === 0) return key === "cutAbove" ? Infinity : -Infinity;
    const range = this.heights[1] - this.heights[0];
    const digits = Math.min(12, Math.max(0, Math.ceil(3 - Math.log10(range || 1))));
    return Number((this.heights[0] + (step / steps) * range).toFixed(digits));
  }

  setHeights(heights: [number, number]): void {
    this.heights = heights;
    this.show(this.store.get());
  }

  show(state: ViewerState): void {
    const [low, high] = this.heights;
    for (const { input, output, key } of this.sliders) {
      const share = (Math.min(high, Math.max(low, state[key])) - low) / (high - low || 1);
      input.value = String(Math.round(steps * share));
      output.textContent = Number.isFinite(state[key]) ? `${formatInRange(state[key], high - low)} m` : "off";
      input.setAttribute("aria-valuetext", output.textContent);
    }
  }
}
