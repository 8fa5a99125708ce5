// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { button, element } from "./dom";

/** What is told of the voxel that was clicked. */
export class VoxelDetails {
  readonly root = element("div", { class: "voxel-details", role: "status", "aria-label": "Selected voxel" });

  constructor(private readonly onClose: () => void) {
    this.root.hidden = true;
  }

  show(rows: readonly (readonly [string, string])[] | null): void {
    this.root.hidden = rows === null;
    if (!rows) return;
    this.root.replaceChildren(
      element("dl", {}, ...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)])),
      button("Deselect voxel", "close", this.onClose, "Escape"),
    );
  }
}
