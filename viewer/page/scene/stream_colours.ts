// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { compareNames } from "../stream_names";
import { oklch } from "./colour_maps";
import type { Rgb } from "./colour_maps";

/** Colours that people with any colour vision tell apart (M. Okabe, K. Ito, 2008). */
const okabeIto = ["e69f00", "56b4e9", "009e73", "f0e442", "0072b2", "d55e00", "cc79a7"];

/** A colour of a palette without end: after the first ones any hues. */
function paletteColour(place: number): Rgb {
  if (place >= okabeIto.length) return oklch(0.72 - 0.2 * ((place >> 1) % 2), 0.13, (place * 137.5) % 360);
  const value = parseInt(okabeIto[place], 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** FNV-1a, 32 bits. */
function hashOf(text: string): number {
  let hash = 0x811c9dc5;
  for (let i = 0; i < text.length; ++i) hash = Math.imul(hash ^ text.charCodeAt(i), 0x01000193) >>> 0;
  return hash;
}

/** The colour that a name would have if it were alone. Names that differ by their last number have different ones. */
function ownPlace(name: string): number {
  const [, before, number, after] = /^(.*?)(\d{1,9})(\D*)$/.exec(name) ?? [null, name, "0", ""];
  return (hashOf(`${before} ${after}`) % okabeIto.length + Number(number)) % okabeIto.length;
}

/** Colours of streams by their names, in whatever order these come. Where several have the same one, the first by name
 * keeps it, and the others have those that are left. */
export function streamColours(names: readonly string[]): Rgb[] {
  const order = names.map((_, i) => i).sort((a, b) => compareNames(names[a], names[b]));
  const places = new Map<number, number>(); // of the palette, by stream
  const taken = new Set<number>();
  const take = (stream: number, place: number): void => {
    places.set(stream, place);
    taken.add(place);
  };
  for (const stream of order) {
    const place = ownPlace(names[stream]);
    if (!taken.has(place)) take(stream, place);
  }
  for (const stream of order) {
    if (places.has(stream)) continue;
    let place = 0;
    while (taken.has(place)) ++place;
    take(stream, place);
  }
  return names.map((_, stream) => paletteColour(places.get(stream) as number));
}
