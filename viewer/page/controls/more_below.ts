// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { element } from "./dom";

/** Pixels that may lie below the edge without a sign. */
const tolerance = 8;

/** Names the sections of a panel that lie below its lower edge, as its last child; a click scrolls to them. */
export function createMoreBelow(panel: HTMLElement): HTMLElement {
  const names = element("span");
  const more = element("button", { type: "button", class: "more-below" }, names, element("span", { "aria-hidden": "true" }, "▾"));
  more.addEventListener("click", () => {
    const prefersNoMotion = matchMedia("(prefers-reduced-motion: reduce)").matches;
    panel.scrollBy({ top: 0.8 * panel.clientHeight, behavior: prefersNoMotion ? "instant" : "smooth" });
  });
  const sections = (): HTMLElement[] => [...panel.querySelectorAll<HTMLElement>(".section")];
  const update = (): void => {
    const isEnd = panel.scrollHeight - panel.scrollTop - panel.clientHeight <= tolerance;
    more.classList.toggle("is-needed", !isEnd && panel.clientHeight > 0);
    const edge = more.getBoundingClientRect().top;
    const below = sections().filter((section) => (section.firstElementChild as Element).getBoundingClientRect().bottom > edge);
    const named = below.length > 0 ? below : sections().slice(-1);
    names.textContent = named.map((section) => section.getAttribute("aria-label")).join(", ");
    more.setAttribute("aria-label", `More below: ${names.textContent}`);
  };
  panel.addEventListener("scroll", update, { passive: true });
  const observer = new ResizeObserver(update);
  for (const observed of [panel, ...sections()]) observer.observe(observed);
  return more;
}
