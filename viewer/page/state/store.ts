// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Called with the names of the values that have changed. */
export type Listener<T> = (changed: ReadonlySet<keyof T>) => void;

/** Values in one place, and who wants to know when they change. */
export class Store<T extends object> {
  private readonly listeners: Listener<T>[] = [];

  constructor(private values: T) {}

  get(): Readonly<T> {
    return this.values;
  }

  set(changes: Partial<T>): void {
    const changed = new Set<keyof T>();
    for (const key of Object.keys(changes) as (keyof T)[])
      if (this.values[key] !== changes[key]) changed.add(key);
    if (changed.size === 0) return;
    this.values = { ...this.values, ...changes };
    for (const listener of this.listeners) listener(changed);
  }

  /** Calls the listener with every change from now on, and once now as if all had changed. */
  subscribe(listener: Listener<T>): void {
    this.listeners.push(listener);
    listener(new Set(Object.keys(this.values) as (keyof T)[]));
  }
}
