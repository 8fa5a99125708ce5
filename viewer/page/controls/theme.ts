// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { SceneColours } from "../scene/surroundings";
import type { ViewerStore } from "../state/viewer_state";

const prefersDark = matchMedia("(prefers-color-scheme: dark)");

export function isDark(store: ViewerStore): boolean {
  const { theme } = store.get();
  return theme === "dark" || (theme === "auto" && prefersDark.matches);
}

/** The scene's colours, which the style sheet has. */
export function sceneColours(): SceneColours {
  const styles = getComputedStyle(document.documentElement);
  const colour = (name: string): string => styles.getPropertyValue(name).trim();
  return {
    background: colour("--scene"),
    grid: colour("--scene-grid"),
    gridStrong: colour("--scene-grid-strong"),
    label: colour("--scene-label"),
    noise: colour("--noise"),
    selection: colour("--scene-selection"),
    crop: colour("--scene-crop"),
  };
}

/** Keeps the page's theme up to date, and tells when it has changed. */
export function followTheme(store: ViewerStore, onChange: () => void): void {
  const apply = (): void => {
    const theme = isDark(store) ? "dark" : "light";
    if (document.documentElement.dataset.theme === theme) return;
    document.documentElement.dataset.theme = theme;
    onChange();
  };
  prefersDark.addEventListener("change", apply);
  store.subscribe((changed) => {
    if (changed.has("theme")) apply();
  });
}
