// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

const margin = 1.06;

/** Share of the view's width that a label is given room for. */
const widestLabel = 0.3;

/** The near plane, as a share of the distance between camera and target. */
const nearShare = 1 / 500;

/** The far plane, as a share of that distance, for voxels far from all others: the near plane is then at 1/25 of it. */
const mostFarShare = 2000;

/** The depths of 24 bits are too coarse for the shading of depths when the planes lie farther from each other. */
const mostFarToNear = 50_000;

export interface Bounds {
  min: [number, number, number];
  max: [number, number, number];
}

/** A label: a place, and a size in pixels, which does not depend on the distance. */
export interface Label {
  place: THREE.Vector3;
  width: number;
  height: number;
}

/** Of the picture, in pixels. */
export interface ViewSize {
  width: number;
  height: number;
  /** At the lower edge, where figures are written over it. */
  covered: number;
}

export function cornersOf({ min, max }: Bounds): THREE.Vector3[] {
  return Array.from({ length: 8 }, (_, i) => new THREE.Vector3(
    i & 1 ? max[0] : min[0], i & 2 ? max[1] : min[1], i & 4 ? max[2] : min[2]));
}

/** The part of the view that points and labels fill, -1 to 1 in both directions. */
function seenBox(camera: THREE.Camera, points: THREE.Vector3[], labels: Label[], view: ViewSize): THREE.Box3 {
  const seen = new THREE.Box3().setFromPoints(points.map((point) => point.clone().project(camera)));
  for (const { place, width, height } of labels) {
    const at = place.clone().project(camera);
    const half = new THREE.Vector3(Math.min(width / view.width, widestLabel), height / view.height, 0);
    seen.expandByPoint(at.clone().sub(half)).expandByPoint(at.add(half));
  }
  seen.min.y -= (2 * view.covered) / view.height;
  return seen;
}

/** Moves a camera, which looks along a direction, so that points and labels fill the view. Returns its new target. */
export function fitCamera(
  camera: THREE.PerspectiveCamera,
  points: THREE.Vector3[],
  labels: Label[],
  view: ViewSize,
  towards: THREE.Vector3,
): THREE.Vector3 {
  const box = new THREE.Box3().setFromPoints(points);
  const target = box.getCenter(new THREE.Vector3());
  const direction = towards.clone().normalize();
  let distance = Math.max(box.getSize(new THREE.Vector3()).length(), 1e-6);
  const tangent = Math.tan((camera.fov * Math.PI) / 360);
  // What is near appears larger, so that the middle of the box is not that of its picture.
  for (let i = 0; i < 12; ++i) {
    camera.position.copy(target).addScaledVector(direction, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const seen = seenBox(camera, points, labels, view);
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    target.addScaledVector(right, 0.5 * (seen.min.x + seen.max.x) * tangent * camera.aspect * distance);
    target.addScaledVector(up, 0.5 * (seen.min.y + seen.max.y) * tangent * distance);
    const share = Math.max(seen.max.x - seen.min.x, seen.max.y - seen.min.y) / 2;
    distance *= Math.min(2, Math.max(0.5, share * margin));
  }
  return target;
}

/** Near and far plane for what the camera looks at, and for all of the scene behind it.
 * @param main where most voxels lie
 * @param all where all lie; voxels that are very much farther away than the target may be cut off
 */
export function placeClippingPlanes(
  camera: THREE.PerspectiveCamera,
  target: THREE.Vector3,
  main: Bounds | null,
  all: Bounds | null,
): void {
  const distance = camera.position.distanceTo(target);
  const farthest = (bounds: Bounds | null): number =>
    Math.max(0, ...(bounds ? cornersOf(bounds) : []).map((corner) => corner.distanceTo(camera.position)));
  const far = Math.max(20 * distance, 2 * farthest(main), Math.min(1.1 * farthest(all), mostFarShare * distance), 1e-3);
  const near = Math.max(nearShare * distance, far / mostFarToNear);
  if (near === camera.near && far === camera.far) return;
  camera.near = near;
  camera.far = far;
  camera.updateProjectionMatrix();
}
