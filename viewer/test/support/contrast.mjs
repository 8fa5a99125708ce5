// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Runs in the page: texts whose contrast is below that of WCAG 2.2 AA.
export function contrastProblems() {
  const parse = (colour) => {
    const [r, g, b, a = 1] = colour.match(/[\d.]+/g).map(Number);
    return { r, g, b, a };
  };
  const over = (top, below) => ({
    r: top.r * top.a + below.r * (1 - top.a),
    g: top.g * top.a + below.g * (1 - top.a),
    b: top.b * top.a + below.b * (1 - top.a),
    a: 1,
  });
  const backgroundOf = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) layers.push(parse(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((below, layer) => over(layer, below), { r: 255, g: 255, b: 255, a: 1 });
  };
  const luminance = ({ r, g, b }) => {
    const [x, y, z] = [r, g, b].map((value) => {
      const share = value / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  const problems = [];
  const check = (element, colour, least, what) => {
    const background = backgroundOf(what === "border" ? element.parentElement : element);
    const [low, high] = [luminance(over(parse(colour), background)), luminance(background)].sort((a, b) => a - b);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < least)
      problems.push(`${what} of ${element.tagName}.${element.className} “${element.innerText?.slice(0, 30)}”: ${contrast.toFixed(2)}`);
  };
  for (const element of document.body.querySelectorAll("*")) {
    if (!element.checkVisibility?.({ visibilityProperty: true, opacityProperty: true })) continue;
    const style = getComputedStyle(element);
    const hasText = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (hasText) check(element, style.color, parseFloat(style.fontSize) >= 24 ? 3 : 4.5, "text");
    if (element.matches("select, input[type=number], .toggle input:not(:checked)")) check(element, style.borderTopColor, 3, "border");
    if (element.matches(".icon-button")) check(element, style.color, 3, "icon");
  }
  return problems;
}
