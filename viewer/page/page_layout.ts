// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { button, element, icon } from "./controls/dom";
import type { ViewerStore } from "./state/viewer_state";

export interface HeaderActions {
  open(): void;
  toggleTheme(): void;
}

/** The parts of the page into which everything else is put. */
export interface PageLayout {
  canvas: HTMLCanvasElement;
  stage: HTMLElement;
  fileInput: HTMLInputElement;
  status: HTMLElement;
  welcome: HTMLElement;
}

function logo(): SVGSVGElement {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "logo");
  svg.setAttribute("aria-hidden", "true");
  for (const [d, fill] of [
    ["M12 2l9 5-9 5-9-5z", "var(--logo-top)"],
    ["M3 7l9 5v10l-9-5z", "var(--logo-left)"],
    ["M21 7l-9 5v10l9-5z", "var(--logo-right)"],
  ]) {
    const path = document.createElementNS(space, "path");
    path.setAttribute("d", d);
    path.setAttribute("fill", fill);
    svg.append(path);
  }
  return svg;
}

function header(store: ViewerStore, actions: HeaderActions): HTMLElement {
  const name = element("h1", {}, "pcl_ext viewer");
  const open = element("button", { type: "button", class: "button open-button", title: "Open a recording (Ctrl+O)" },
    icon("open"), element("span", {}, "Open"));
  open.addEventListener("click", actions.open);
  const settings = button("Settings", "settings", () => store.set({ showsPanel: !store.get().showsPanel }));
  settings.classList.add("panel-button");
  settings.setAttribute("aria-controls", "panel");
  store.subscribe(() => {
    const { name: file, showsPanel } = store.get();
    name.textContent = file || "pcl_ext viewer";
    name.title = file;
    document.title = file ? `${file} – pcl_ext viewer` : "pcl_ext viewer";
    settings.setAttribute("aria-expanded", String(showsPanel));
    document.body.classList.toggle("shows-panel", showsPanel);
  });
  return element("header", { class: "header" }, logo(), name, open,
    button("Light or dark", "theme", actions.toggleTheme, "T"),
    button("Keys and help", "help", () => store.set({ showsHelp: true }), "?"), settings);
}

function welcome(open: () => void): HTMLElement {
  const choose = button("Open a recording", null, open);
  choose.classList.add("primary");
  return element("div", { class: "welcome" }, logo(),
    element("h2", {}, "See what the sensors saw"),
    element("p", {}, "Drop a recording here: an ", element("b", {}, ".mcap"), " or ", element("b", {}, ".pcxi"),
      " file, or a rosbag2 folder."),
    choose,
    element("p", { class: "hint" }, "The file stays on this computer. It is decoded in this page."));
}

/** Builds the page's parts around the panel and the time line. */
export function layOutPage(
  store: ViewerStore,
  actions: HeaderActions,
  parts: { panel: HTMLElement; timeline: HTMLElement; help: HTMLElement; overlays: HTMLElement[] },
): PageLayout {
  const canvas = element("canvas", { class: "scene", tabindex: 0, role: "img", "aria-label": "Voxels in 3D. Turn with W A S D, zoom with plus and minus." });
  const status = element("div", { class: "status", role: "group", "aria-label": "What is drawn" });
  const fileInput = element("input", { type: "file", multiple: true, hidden: true, accept: ".mcap,.pcxi", "aria-label": "Recording" });
  const start = welcome(actions.open);
  const stage = element("main", { class: "stage" }, canvas, start, status, ...parts.overlays,
    element("div", { class: "drop-hint", "aria-hidden": "true" }, element("span", {}, "Drop to open")));
  document.body.replaceChildren(header(store, actions), stage, parts.panel, parts.timeline, parts.help, fileInput);
  store.subscribe(() => {
    const { source, isOpening, hasEnded, allStreams, liveStreams } = store.get();
    stage.classList.toggle("is-opening", isOpening);
    stage.classList.toggle("is-stale", source === "live" && !hasEnded && allStreams > 0 && liveStreams === 0);
    start.hidden = source !== "none";
    document.body.dataset.source = source;
  });
  return { canvas, stage, fileInput, status, welcome: start };
}
