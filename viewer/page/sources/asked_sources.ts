// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { Source } from "./source_choice";

/** A source to show, and whether the user chose it in the page. */
export interface AskedSource {
  source: Source;
  isChosen: boolean;
}

/** Sources that were asked for and are neither shown nor refused yet, by their numbers. */
export class AskedSources {
  private readonly asked = new Map<number, AskedSource>();
  private last = -1;

  add(source: AskedSource): number {
    this.asked.set(++this.last, source);
    return this.last;
  }

  /** Takes one; those before it are out of date. */
  take(number: number): AskedSource {
    const taken = this.asked.get(number) as AskedSource;
    for (const one of this.asked.keys()) if (one <= number) this.asked.delete(one);
    return taken;
  }

  get isEmpty(): boolean {
    return this.asked.size === 0;
  }
}
