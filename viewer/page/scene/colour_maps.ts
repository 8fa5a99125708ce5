// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Colours as red, green and blue, each 0 to 1 and ready for the screen (sRGB). */
export type Rgb = readonly [number, number, number];

function toSrgb(linear: number): number {
  const value = Math.min(1, Math.max(0, linear));
  return value <= 0.0031308 ? 12.92 * value : 1.055 * Math.pow(value, 1 / 2.4) - 0.055;
}

/** Oklab (B. Ottosson, 2020) in cylinder coordinates: equal steps of lightness look equal. */
export function oklch(lightness: number, chroma: number, hueDegrees: number): Rgb {
  const hue = (hueDegrees * Math.PI) / 180;
  const a = chroma * Math.cos(hue);
  const b = chroma * Math.sin(hue);
  const l = Math.pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const m = Math.pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const s = Math.pow(lightness - 0.0894841775 * a - 1.291485548 * b, 3);
  return [
    toSrgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    toSrgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    toSrgb(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

function mix(from: number, to: number, share: number): number {
  return from + (to - from) * share;
}

/** Each map takes a share from 0 to 1. Lightness rises evenly, so that order is seen without colour, too. */
export const colourMaps = {
  /** Violet over teal to yellow, for intensities. */
  intensity: (share: number): Rgb => {
    const chroma = 0.12 + 0.055 * Math.sin(Math.PI * share) + 0.03 * share;
    return oklch(mix(0.38, 0.93, share), chroma, mix(305, 100, Math.pow(share, 0.9)));
  },
  /** Blue over magenta to orange and pale yellow, for heights. */
  height: (share: number): Rgb => oklch(mix(0.42, 0.92, share), 0.16 - 0.03 * share, mix(262, 450, share)),
  /** Bright for what is seen now, dark blue for what was seen long ago. */
  age: (share: number): Rgb => oklch(mix(0.88, 0.36, share), mix(0.15, 0.1, share), mix(85, 275, share)),
} as const;

export type ColourMapName = keyof typeof colourMaps;

/** Texels of a map, red, green, blue and 255, for a texture of one row. */
export function texelsOf(map: ColourMapName, count = 256): Uint8Array {
  const texels = new Uint8Array(4 * count);
  for (let i = 0; i < count; ++i) {
    const colour = colourMaps[map](i / (count - 1));
    texels.set([...colour.map((value) => Math.round(255 * value)), 255], 4 * i);
  }
  return texels;
}

/** A CSS gradient of a map, from left to right. */
export function gradientOf(map: ColourMapName): string {
  const stops = Array.from({ length: 17 }, (_, i) => cssColour(colourMaps[map](i / 16)));
  return `linear-gradient(to right, ${stops.join(", ")})`;
}

export function cssColour(colour: Rgb): string {
  return `rgb(${colour.map((value) => Math.round(255 * value)).join(", ")})`;
}
