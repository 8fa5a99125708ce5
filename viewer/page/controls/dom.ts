// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
type Child = Node | string | null;

/** An element with attributes and children; attributes that are false or null are left out. */
export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | number | boolean | null> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (value !== false && value !== null) made.setAttribute(name, value === true ? "" : String(value));
  made.append(...children.filter((child) => child !== null));
  return made;
}

/** Outlines of the icons, 24 x 24. */
const iconPaths = {
  open: "M3 7a2 2 0 0 1 2-2h4l2 2h8a2 2 0 0 1 2 2v9a2 2 0 0 1-2 2H5a2 2 0 0 1-2-2z",
  play: "M7 4.5v15l12.5-7.5z",
  pause: "M8 5v14M16 5v14",
  first: "M6 5v14M19 5l-10 7 10 7z",
  last: "M18 5v14M5 5l10 7-10 7z",
  previous: "M15 5l-9 7 9 7zM18 5v14",
  next: "M9 5l9 7-9 7zM6 5v14",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  theme: "M12 3a9 9 0 1 0 0 18zM12 3a9 9 0 0 1 0 18",
  help: "M9 9a3 3 0 1 1 4.2 2.7c-.8.4-1.2 1-1.2 1.9v.4M12 17.5v.1M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z",
  settings: "M4 7h9M17 7h3M4 17h3M11 17h9M15 4.5v5M9 14.5v5",
  download: "M12 4v11M7 11l5 5 5-5M5 20h14",
  picture: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15.5 9h.1",
  link: "M10 14a4 4 0 0 0 6 .4l3-3a4 4 0 0 0-5.7-5.7l-1 1M14 10a4 4 0 0 0-6-.4l-3 3a4 4 0 0 0 5.7 5.7l1-1",
  close: "M6 6l12 12M18 6L6 18",
} as const;

export type IconName = keyof typeof iconPaths;

export function icon(name: IconName): SVGSVGElement {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", iconPaths[name]);
  svg.append(path);
  return svg;
}

export function button(label: string, iconName: IconName | null, onClick: () => void, keys = ""): HTMLButtonElement {
  const made = element(
    "button",
    {
      type: "button",
      class: iconName ? "icon-button" : "button",
      "aria-label": iconName ? label : null,
      title: keys ? `${label} (${keys})` : label,
      "aria-keyshortcuts": keys || null,
    },
    iconName ? icon(iconName) : label,
  );
  made.addEventListener("click", onClick);
  return made;
}

/** A check box with its label, drawn as a switch. */
export function toggle(label: string, onChange: (isOn: boolean) => void): { row: HTMLElement; set(isOn: boolean): void } {
  const input = element("input", { type: "checkbox", role: "switch" });
  input.addEventListener("change", () => onChange(input.checked));
  const row = element("label", { class: "toggle" }, element("span", {}, label), input);
  return { row, set: (isOn) => void (input.checked = isOn) };
}

/** A few choices of which one is taken, beside each other. */
export function choice<T extends string>(
  name: string,
  options: Record<T, string>,
  onChange: (value: T) => void,
): { row: HTMLElement; set(value: T): void } {
  const inputs = new Map<T, HTMLInputElement>();
  const row = element("div", { class: "segments", role: "radiogroup", "aria-label": name });
  for (const [value, label] of Object.entries(options) as [T, string][]) {
    const input = element("input", { type: "radio", name, value });
    input.addEventListener("change", () => onChange(value));
    inputs.set(value, input);
    row.append(element("label", {}, input, element("span", {}, label)));
  }
  return {
    row,
    set: (value) => {
      const input = inputs.get(value);
      if (input) input.checked = true;
    },
  };
}

export function section(title: string, ...children: Child[]): HTMLElement {
  const heading = element("h2", {}, title);
  return element("section", { class: "section", "aria-label": title }, heading, ...children);
}
