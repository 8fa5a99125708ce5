// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Of the axis, with the space beside it. */
const widthOfLabel = 0.155;

/** Where intensities lie on histogram, slider, legend and colour map: evenly, or with room for small ones. */
export class IntensityAxis {
  constructor(
    readonly min: number,
    readonly max: number,
    /** Smallest difference of two intensities. */
    readonly step: number,
    readonly isLogarithmic: boolean,
    /** The intensity from which colours are the brightest: few voxels have more. */
    readonly bright: number = max,
  ) {}

  /** 0 to 1: where an intensity lies in the colour map. */
  brightnessOf(intensity: number): number {
    return Math.min(1, this.shareOf(intensity) / (this.shareOf(this.bright) || 1));
  }

  /** The part of the axis that has different colours. */
  brightAxis(): IntensityAxis {
    return new IntensityAxis(this.min, this.bright, this.step, this.isLogarithmic);
  }

  /** 0 to 1. */
  shareOf(intensity: number): number {
    const span = this.max - this.min;
    if (span <= 0) return 0;
    const value = Math.min(span, Math.max(0, intensity - this.min));
    if (!this.isLogarithmic) return value / span;
    return Math.log1p(value / this.step) / Math.log1p(span / this.step);
  }

  intensityAt(share: number): number {
    const span = this.max - this.min;
    if (!this.isLogarithmic) return this.min + share * span;
    return this.min + this.step * Math.expm1(share * Math.log1p(span / this.step));
  }

  /** The nearest intensity that voxels can have. */
  rounded(intensity: number): number {
    const steps = Math.round((intensity - this.min) / this.step);
    return Math.min(this.max, Math.max(this.min, this.min + steps * this.step));
  }

  /** Intensities for labels, which voxels can have. */
  ticks(): number[] {
    if (this.max <= this.min) return [this.min];
    if (!this.isLogarithmic) return [...new Set([0, 0.25, 0.5, 0.75, 1].map((share) => this.rounded(this.intensityAt(share))))];
    const ticks = [this.min];
    let last = 0.08 - widthOfLabel;
    for (let above = this.step; this.min + above <= this.max; above *= 4) {
      const value = this.min + above;
      const share = this.shareOf(value);
      if (share >= 0.84 || share <= last + widthOfLabel) continue;
      ticks.push(value);
      last = share;
    }
    ticks.push(this.max);
    return ticks;
  }
}
