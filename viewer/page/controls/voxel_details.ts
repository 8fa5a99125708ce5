// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { button, element } from "./dom";

/** What is told of the voxel that was clicked. */
export class VoxelDetails {
  readonly root = element("div", { class: "voxel-details", role: "status", "aria-label": "Selected voxel" });
  private readonly list = element("dl");
  private readonly measure: HTMLButtonElement;

  constructor(onClose: () => void, onMeasure: () => void) {
    this.measure = button("", null, onMeasure);
    this.measure.classList.add("measure");
    this.measure.title = "Or Shift + click on it";
    this.root.append(element("div", {}, this.list, this.measure), button("Deselect voxel", "close", onClose, "Escape"));
    this.root.hidden = true;
  }

  /** @param isMeasuring a second voxel is to be picked */
  show(rows: readonly (readonly [string, string])[] | null, isMeasuring = false): void {
    this.root.hidden = rows === null;
    this.list.replaceChildren(...(rows ?? []).flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
    this.measure.textContent = isMeasuring ? "Pick the other voxel …" : "Distance to …";
    this.measure.setAttribute("aria-pressed", String(isMeasuring));
  }
}
