// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Notices } from "../controls/notices";
import type { ViewerScene } from "../scene/viewer_scene";
import type { ViewerStore } from "../state/viewer_state";
import { shortName } from "../stream_names";
import type { StreamsOnScreen } from "../streams_on_screen";
import { plyOf } from "./ply_file";
import { saveFile } from "./save_file";

/** The parts of the page whose content is saved. */
export interface ExportedParts {
  readonly store: ViewerStore;
  readonly screen: StreamsOnScreen;
  readonly scene: ViewerScene;
  readonly notices: Notices;
}

function fileName(viewer: ExportedParts, ending: string): string {
  const { name, moment, source } = viewer.store.get();
  const base = name.replace(/\.(mcap|pcxi)$/, "").replaceAll(/[^\w.-]+/g, "_") || "voxels";
  return source === "recording" ? `${base}_${String(moment).padStart(6, "0")}${ending}` : `${base}${ending}`;
}

/** Saves the voxels that are drawn and no noise. */
export function exportPly(viewer: ExportedParts): void {
  const layers = viewer.scene.layers.flatMap((layer, stream) =>
    viewer.screen.isVisible(stream) && layer.voxels
      ? [{ layer, stream, name: shortName(viewer.screen.streams[stream].description.name) }]
      : []);
  const { name, threshold } = viewer.store.get();
  // What the voxels are, which the switch is not yet while frames are decoded again.
  const isJudged = layers.some(({ layer }) => layer.voxels?.isJudged);
  const comment = `${name}, threshold ${threshold}, outliers ${isJudged ? "removed" : "kept"}`;
  const file = plyOf(layers, { ...viewer.scene.rule(), hidesNoise: true }, comment);
  if (file) saveFile(file, fileName(viewer, ".ply"));
  else
    viewer.notices.show("ply", "info", "There are no voxels to save",
      ["No stream that is on has a voxel here that is drawn and no noise, by threshold, outlier filter and cuts."]);
}

export async function exportPicture(viewer: ExportedParts): Promise<void> {
  const picture = await viewer.scene.picture();
  if (picture) saveFile(picture, fileName(viewer, ".png"));
}
