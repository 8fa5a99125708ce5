// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Of the time between two calls. */
const mostMs = 500;

/** Time in which the page reads what comes, in milliseconds: less passes while it is busy, as with drawing by software.
 * To be asked some times a second. */
export class AwakeClock {
  private awake = 0;
  private last = performance.now();

  now(): number {
    const now = performance.now();
    const passed = now - this.last;
    this.last = now;
    // Timers of hidden pages are slow, though these do read.
    return (this.awake += document.hidden ? passed : Math.min(passed, mostMs));
  }
}
