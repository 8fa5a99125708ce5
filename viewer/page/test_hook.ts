// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { isNoise } from "./scene/drawn_voxels";
import type { ViewerScene } from "./scene/viewer_scene";
import type { ViewerState, ViewerStore } from "./state/viewer_state";
import type { StreamsOnScreen } from "./streams_on_screen";
import type { FrameIndex } from "./timeline/frame_index";

/** What the hook asks of the page. */
interface HookedPage {
  readonly store: ViewerStore;
  readonly screen: StreamsOnScreen;
  readonly scene: ViewerScene;
  readonly index: FrameIndex;
  seekAndWait(moment: number): Promise<void>;
  fit(direction: "oblique" | "top" | "front" | "side" | "keep"): void;
  damageFound(): string[];
}

/** What tests and scripts may ask of the page, as `window.pclExtViewer`. See viewer/README.md. */
export interface ViewerHook {
  state(): Readonly<ViewerState>;
  set(changes: Partial<ViewerState>): void;
  /** Voxels drawn, voxels that are no noise, and all voxels of the streams that are on. */
  counts(): { kept: number; drawn: number; all: number };
  streams(): { name: string; colour: number[]; number: number | null; problem: string | null; voxels: number; past: number }[];
  /** Coordinates of the voxels of a stream that are no noise, x, y, z one after the other. */
  positions(stream: number): number[];
  /** The same of the frames before, which stay for the decay time; noise, too. */
  pastPositions(stream: number): number[];
  /** Values of the field that the same voxels have with them; null: none. */
  fieldValues(stream: number): number[] | null;
  /** Number of times that the scene was drawn. */
  pictures(): number;
  moments(): number;
  /** Resolves when the frames of a moment are drawn. */
  seek(moment: number): Promise<void>;
  fit(direction: "oblique" | "top" | "front" | "side" | "keep"): void;
  camera(): number[];
  setCamera(values: number[]): void;
  damage(): string[];
}

declare global {
  interface Window {
    pclExtViewer?: ViewerHook;
  }
}

export function publishHook(viewer: HookedPage): void {
  window.pclExtViewer = {
    state: () => viewer.store.get(),
    set: (changes) => viewer.store.set(changes),
    counts: () => viewer.screen.counts(),
    streams: () =>
      viewer.screen.streams.map(({ description, shown }, i) => ({
        name: description.name,
        colour: viewer.scene.layers[i].material.uniforms.streamColour.value.toArray(),
        number: shown?.number ?? null,
        problem: shown?.problem ?? null,
        voxels: viewer.scene.layers[i].voxels?.count ?? 0,
        past: viewer.scene.layers[i].voxels?.pastCount ?? 0,
      })),
    positions: (stream) => {
      const layer = viewer.scene.layers[stream];
      const { threshold } = viewer.store.get();
      const result: number[] = [];
      for (let i = 0; i < (layer.voxels?.count ?? 0); ++i)
        if (!isNoise(layer, i, threshold)) result.push(...layer.placeOf(i));
      return result;
    },
    pastPositions: (stream) =>
      viewer.scene.past.layers.flatMap((past) => (past.stream === stream ? past.layer.drawnPlaces() : [])),
    fieldValues: (stream) => {
      const layer = viewer.scene.layers[stream];
      const { threshold } = viewer.store.get();
      const values = layer.arrays?.field;
      return values ? [...values].filter((_, i) => i < (layer.voxels?.count ?? 0) && !isNoise(layer, i, threshold)) : null;
    },
    pictures: () => viewer.scene.pictures,
    moments: () => viewer.index.moments.length,
    seek: (moment) => viewer.seekAndWait(moment),
    fit: (direction) => viewer.fit(direction),
    camera: () => viewer.scene.camera.values(),
    setCamera: (values) => viewer.scene.camera.setValues(values),
    damage: () => viewer.damageFound(),
  };
}
