// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { element } from "./dom";

/** What is wrong with a live source, over the scene. It cannot be closed, as an old picture looks like a new one. */
export class LiveBanner {
  // Seconds that count are not read out again and again; the badge beside the time is.
  readonly root = element("div", { class: "live-banner", role: "region", "aria-label": "State of the source", hidden: true });

  show(lines: readonly string[]): void {
    this.root.hidden = lines.length === 0;
    this.root.replaceChildren(...lines.map((line) => element("p", {}, line)));
  }
}
