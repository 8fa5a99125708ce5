// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** A rigid transform: x, y, z, metres, and the quaternion qx, qy, qz, qw. */
export type Pose = readonly [number, number, number, number, number, number, number];

/** A transform of a message: of a frame into its parent. */
export interface StampedTransform {
  parent: string;
  child: string;
  stamp: number; // nanoseconds
  pose: Pose;
}

/** Where a frame of coordinates lies at a time. */
export interface Placement {
  /** The frame without a parent that it is placed in; itself, if no transform has it as a child. */
  root: string;
  pose: Pose; // in the root
  isMoving: boolean; // at other times it may lie elsewhere
  /** What is wrong with it, in words; null if nothing is. */
  problem: string | null;
}

/** More frames, or longer names, are no robot's. */
const mostFrames = 4096;
const longestName = 256;

/** Transforms that are kept, in all; of more some are left out, as evenly as they come. */
const mostSamples = 1 << 18;

/** Nanoseconds from a transform to the time that it is used for, without a word about it. */
const longestGap = 1e9;

export const identity: Pose = [0, 0, 0, 0, 0, 0, 1];

function turned([, , , x, y, z, w]: Pose, [a, b, c]: readonly number[]): [number, number, number] {
  const u = 2 * (y * c - z * b);
  const v = 2 * (z * a - x * c);
  const s = 2 * (x * b - y * a);
  return [a + w * u + y * s - z * v, b + w * v + z * u - x * s, c + w * s + x * v - y * u];
}

/** The transform by `first`, then by `then`. */
export function combined(then: Pose, first: Pose): Pose {
  const [x, y, z] = turned(then, first);
  const [, , , a, b, c, d] = then;
  const [, , , e, f, g, h] = first;
  return [
    x + then[0], y + then[1], z + then[2],
    d * e + a * h + b * g - c * f,
    d * f - a * g + b * h + c * e,
    d * g + a * f - b * e + c * h,
    d * h - a * e - b * f - c * g,
  ];
}

/** Between two transforms: lines for places, the shorter arc for rotations. */
function between(from: Pose, to: Pose, share: number): Pose {
  const mixed = (i: number, a: number, b: number): number => a * from[i] + b * to[i];
  let cosine = from[3] * to[3] + from[4] * to[4] + from[5] * to[5] + from[6] * to[6];
  const sign = cosine < 0 ? -1 : 1;
  cosine = Math.min(1, sign * cosine);
  const angle = Math.acos(cosine);
  const isSmall = angle < 1e-6;
  const a = isSmall ? 1 - share : Math.sin((1 - share) * angle) / Math.sin(angle);
  const b = sign * (isSmall ? share : Math.sin(share * angle) / Math.sin(angle));
  const places = [0, 1, 2].map((i) => mixed(i, 1 - share, share));
  return [places[0], places[1], places[2], mixed(3, a, b), mixed(4, a, b), mixed(5, a, b), mixed(6, a, b)];
}

/** With a quaternion of length 1; null if a number is not finite or it has no direction. */
function normalized(pose: Pose): Pose | null {
  const length = Math.hypot(pose[3], pose[4], pose[5], pose[6]);
  if (!pose.every(Number.isFinite) || !(length > 1e-3 && length < 1e3)) return null;
  return pose.map((value, i) => (i < 3 ? value : value / length)) as unknown as Pose;
}

/** How a frame lies in its parent, over time. */
class Link {
  private times: number[] = []; // nanoseconds
  private poses: Pose[] = [];
  private isSorted = true;
  private passed = 0; // transforms, kept or not

  constructor(
    readonly parent: string,
    public isStatic: boolean,
  ) {}

  get size(): number {
    return this.times.length;
  }

  add(time: number, pose: Pose): void {
    if (this.isStatic) {
      this.times = [];
      this.poses = [];
    }
    this.isSorted &&= this.times.length === 0 || time >= this.times[this.times.length - 1];
    this.times.push(time);
    this.poses.push(pose);
  }

  /** True for one of so many. */
  isNextOf(many: number): boolean {
    return this.passed++ % many === 0;
  }

  /** Leaves out every second one. */
  thin(): void {
    this.sort();
    this.times = this.times.filter((_, i) => i % 2 === 0);
    this.poses = this.poses.filter((_, i) => i % 2 === 0);
  }

  private sort(): void {
    if (this.isSorted) return;
    const order = this.times.map((_, i) => i).sort((a, b) => this.times[a] - this.times[b]);
    this.times = order.map((i) => this.times[i]);
    this.poses = order.map((i) => this.poses[i]);
    this.isSorted = true;
  }

  /** The transform at a time, and nanoseconds from it to the nearest one where none is before and after it. */
  at(time: number): { pose: Pose; gap: number } {
    this.sort();
    let low = 0;
    let high = this.times.length; // the first one after the time is there, or before
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] > time) high = middle;
      else low = middle + 1;
    }
    const last = this.times.length - 1;
    if (low === 0) return { pose: this.poses[0], gap: this.isStatic ? 0 : this.times[0] - time };
    if (low > last) return { pose: this.poses[last], gap: this.isStatic ? 0 : time - this.times[last] };
    const span = this.times[low] - this.times[low - 1];
    const share = (time - this.times[low - 1]) / span;
    return { pose: between(this.poses[low - 1], this.poses[low], share), gap: 0 };
  }
}

/** The transforms of a recording, as `/tf` and `/tf_static` have them: how its frames of coordinates lie to each other. */
export class Transforms {
  private readonly links = new Map<string, Link>(); // by child
  private readonly refused = new Set<string>();
  private samples = 0;
  private keeps = 1; // of so many one

  get isEmpty(): boolean {
    return this.links.size === 0;
  }

  /** Number of frames that have a parent: with each more of them others may have another place. */
  get size(): number {
    return this.links.size;
  }

  add({ parent, child, stamp, pose }: StampedTransform, isStatic: boolean): void {
    const valid = normalized(pose);
    const isNamed = [parent, child].every((name) => name.length > 0 && name.length <= longestName);
    if (!valid || !isNamed || parent === child) {
      this.refuse("some transforms are no rotation and translation of a frame into another one");
      return;
    }
    let link = this.links.get(child);
    if (!link && this.links.size >= mostFrames) {
      this.refuse(`there are more than ${mostFrames} frames`);
      return;
    }
    if (!link) this.links.set(child, (link = new Link(parent, isStatic)));
    if (link.parent !== parent) {
      this.refuse(`“${child}” has several parents, of which the first one, “${link.parent}”, is used`);
      return;
    }
    if (!isStatic && !link.isNextOf(this.keeps)) return;
    link.isStatic = isStatic;
    const before = link.size;
    link.add(stamp, valid);
    this.samples += link.size - before;
    if (this.samples > mostSamples) this.thin();
  }

  private thin(): void {
    this.keeps *= 2;
    this.samples = 0;
    for (const link of this.links.values()) {
      link.thin();
      this.samples += link.size;
    }
  }

  private refuse(what: string): void {
    if (this.refused.size < 20) this.refused.add(what);
  }

  /** What of the transforms is not used, in words. */
  remarks(): string[] {
    return [...this.refused];
  }

  /** Where a frame lies at a time, nanoseconds. */
  placeOf(frame: string, time: number): Placement {
    let pose = identity;
    let root = frame;
    let problem: string | null = null;
    let isMoving = false;
    const passed = new Set([frame]);
    for (let link = this.links.get(root); link; link = this.links.get(root)) {
      const { pose: inParent, gap } = link.at(time);
      if (gap > longestGap)
        problem ??= `the nearest transform of “${root}” is ${(gap / 1e9).toPrecision(3)} s away`;
      pose = combined(inParent, pose);
      isMoving ||= !link.isStatic;
      root = link.parent;
      if (passed.has(root))
        return { root: frame, pose: identity, isMoving: false, problem: `the parents of “${frame}” form a circle at “${root}”` };
      passed.add(root);
    }
    return { root, pose, isMoving, problem };
  }
}
