// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
const collator = new Intl.Collator("en", { numeric: true });

/** A topic without what all topics have. */
export function shortName(name: string): string {
  return name.replace(/\/pcl_ext$/, "").replace(/^\//, "");
}

/** The order of names as people count: 2 before 10. */
export function compareNames(a: string, b: string): number {
  return collator.compare(a, b) || (a < b ? -1 : a > b ? 1 : 0);
}
