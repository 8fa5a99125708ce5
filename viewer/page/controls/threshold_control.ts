// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { cssColour, colourMaps } from "../scene/colour_maps";
import type { IntensityAxis } from "../scene/intensity_axis";
import { element } from "./dom";
import { formatNumber } from "./number_format";

const bins = 64;

/** The histogram of intensities with the threshold as a slider on it, and as a number beside it. */
export class ThresholdControl {
  readonly root: HTMLElement;
  private readonly canvas = element("canvas", { "aria-hidden": "true" });
  private readonly slider = element("div", {
    class: "histogram",
    role: "slider",
    tabindex: 0,
    "aria-label": "Intensity threshold",
  });
  private readonly handle = element("div", { class: "histogram-handle" });
  private readonly ticks = element("div", { class: "ticks", "aria-hidden": "true" });
  private readonly number = element("input", {
    type: "number",
    class: "threshold-number",
    "aria-label": "Intensity threshold as a number",
    step: "any",
  });
  private readonly counts = new Float64Array(bins);
  private axis: IntensityAxis | null = null;
  private threshold = 0;
  private isIntensityColoured = true;

  constructor(private readonly onChange: (threshold: number) => void) {
    this.slider.append(this.canvas, this.handle);
    this.root = element(
      "div",
      { class: "threshold" },
      element("div", { class: "row" }, element("span", {}, "Intensity threshold"), this.number),
      this.slider,
      this.ticks,
    );
    this.slider.addEventListener("keydown", (event) => this.onKey(event));
    this.slider.addEventListener("pointerdown", (event) => {
      this.slider.setPointerCapture(event.pointerId);
      this.onPointer(event);
    });
    this.slider.addEventListener("pointermove", (event) => {
      if (this.slider.hasPointerCapture(event.pointerId)) this.onPointer(event);
    });
    this.number.addEventListener("change", () => {
      const value = this.number.valueAsNumber;
      if (this.axis && Number.isFinite(value)) this.onChange(Math.min(this.axis.max, Math.max(this.axis.min, value)));
      this.showNumber();
    });
    new ResizeObserver(() => this.draw()).observe(this.slider);
  }

  private onPointer(event: PointerEvent): void {
    if (!this.axis) return;
    const box = this.slider.getBoundingClientRect();
    const share = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    this.onChange(this.axis.rounded(this.axis.intensityAt(share)));
  }

  private onKey(event: KeyboardEvent): void {
    if (!this.axis) return;
    const { min, max, step } = this.axis;
    const small = this.axis.isLogarithmic ? step : Math.max(step, (max - min) / 255);
    const steps: Record<string, number> = {
      ArrowRight: small,
      ArrowUp: small,
      ArrowLeft: -small,
      ArrowDown: -small,
      PageUp: 10 * small,
      PageDown: -10 * small,
      Home: min - max,
      End: max - min,
    };
    if (!(event.key in steps)) return;
    event.preventDefault();
    event.stopPropagation();
    this.onChange(this.axis.rounded(this.threshold + steps[event.key]));
  }

  setAxis(axis: IntensityAxis): void {
    this.axis = axis;
    this.ticks.replaceChildren(
      ...axis.ticks().map((value) => {
        const tick = element("span", {}, formatNumber(value));
        const share = axis.shareOf(value);
        tick.style.left = `${100 * share}%`;
        tick.style.transform = `translateX(${-100 * share}%)`;
        return tick;
      }),
    );
    this.slider.setAttribute("aria-valuemin", String(axis.min));
    this.slider.setAttribute("aria-valuemax", String(axis.max));
    this.setThreshold(this.threshold);
  }

  setThreshold(threshold: number): void {
    this.threshold = threshold;
    if (document.activeElement !== this.number) this.showNumber();
    this.slider.setAttribute("aria-valuenow", String(threshold));
    this.slider.setAttribute("aria-valuetext", `${formatNumber(threshold)}`);
    this.handle.style.left = `${100 * (this.axis?.shareOf(threshold) ?? 0)}%`;
    this.draw();
  }

  /** What was typed may be no intensity of the scale. */
  private showNumber(): void {
    this.number.value = formatNumber(this.threshold).replaceAll(",", "");
  }

  setColoured(isIntensityColoured: boolean): void {
    this.isIntensityColoured = isIntensityColoured;
    this.draw();
  }

  /** Begins a new histogram. */
  clear(): void {
    this.counts.fill(0);
  }

  add(intensities: Float32Array, count: number): void {
    const axis = this.axis;
    if (!axis) return;
    for (let i = 0; i < count; ++i)
      ++this.counts[Math.min(bins - 1, Math.floor(axis.shareOf(intensities[i]) * bins))];
  }

  draw(): void {
    const width = this.slider.clientWidth;
    const height = this.slider.clientHeight;
    const ratio = Math.min(2, devicePixelRatio);
    if (!this.axis || width === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const context = this.canvas.getContext("2d") as CanvasRenderingContext2D;
    context.scale(ratio, ratio);
    const styles = getComputedStyle(this.slider);
    const muted = styles.getPropertyValue("--histogram-muted");
    const plain = styles.getPropertyValue("--accent");
    const highest = Math.max(1, ...this.counts);
    const limit = this.axis.shareOf(this.threshold);
    for (let i = 0; i < bins; ++i) {
      if (this.counts[i] === 0) continue;
      const bar = Math.max(1.5, Math.sqrt(this.counts[i] / highest) * (height - 4));
      const share = (i + 0.5) / bins;
      const isBelow = (i + 1) / bins <= limit; // all of the bin
      context.fillStyle = isBelow ? muted : this.isIntensityColoured ? cssColour(colourMaps.intensity(this.axis.brightnessOf(this.axis.intensityAt(share)))) : plain;
      context.fillRect((i / bins) * width + 0.5, height - bar, Math.max(1, width / bins - 1), bar);
    }
  }
}
