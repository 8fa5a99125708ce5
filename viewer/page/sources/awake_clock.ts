// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Of the time between two calls. */
const mostMs = 500;

/** Time in which the page reads what comes, in milliseconds: less passes while it is busy, as with drawing by software.
 * To be asked some times a second. */
export class AwakeClock {
  private awake = 0;
  private last = performance.now();
  private wasHidden = document.hidden;
  private longestGap = 0;

  now(): number {
    const now = performance.now();
    const passed = now - this.last;
    this.last = now;
    const isHidden = document.hidden;
    if (!isHidden && !this.wasHidden) this.longestGap = Math.max(this.longestGap, passed);
    this.wasHidden = isHidden;
    // Timers of hidden pages are slow, though these do read.
    return (this.awake += isHidden ? passed : Math.min(passed, mostMs));
  }

  /** The longest time since the last call in which a page that is seen read nothing, ms. */
  takeLongestGap(): number {
    this.now();
    const gap = this.longestGap;
    this.longestGap = 0;
    return gap;
  }
}
