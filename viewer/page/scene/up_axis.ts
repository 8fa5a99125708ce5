// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import type { Bounds } from "./camera_fit";

/** The axis of the coordinates that points up. */
export type UpAxis = "z" | "-z" | "y" | "-y";

/** An up axis for computations. */
export class Up {
  readonly axis: 1 | 2;
  readonly sign: 1 | -1;
  readonly vector = new THREE.Vector3();
  /** From coordinates with z up. */
  readonly fromZ = new THREE.Quaternion();
  /** To coordinates with y up, as spherical ones have it. */
  readonly toY = new THREE.Quaternion();

  constructor(readonly name: UpAxis) {
    this.axis = name.endsWith("z") ? 2 : 1;
    this.sign = name.startsWith("-") ? -1 : 1;
    this.vector.setComponent(this.axis, this.sign);
    this.fromZ.setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.vector);
    this.toY.setFromUnitVectors(this.vector, new THREE.Vector3(0, 1, 0));
  }

  /** The lowest and the highest of a box. */
  heights({ min, max }: Bounds): [number, number] {
    return this.sign > 0 ? [min[this.axis], max[this.axis]] : [-max[this.axis], -min[this.axis]];
  }

  /** The two axes of the floor. */
  get floorAxes(): [number, number] {
    return this.axis === 2 ? [0, 1] : [0, 2];
  }
}

/** Share of the places that may lie outside of a camera's view, by noise. */
const outside = 0.02;

/** Whether places lie as a camera sees them in its own coordinates: z along the view, x to the right, y down. */
export function isCameraView(places: readonly (readonly [number, number, number])[]): boolean {
  const seen = places.filter(([x, y, z]) => z > 0 && Math.abs(x) < 1.75 * z && Math.abs(y) < 1.75 * z);
  if (seen.length === 0 || seen.length < (1 - outside) * places.length) return false;
  // The view's middle is within, as it would not be for a thing that stands somewhere above the floor.
  return [0, 1].every((axis) => {
    const left = seen.filter((place) => place[axis] < 0).length;
    return left > outside * seen.length && left < (1 - outside) * seen.length;
  });
}
