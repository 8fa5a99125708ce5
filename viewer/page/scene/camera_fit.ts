import * as THREE from "three";

import type { Bounds } from "./surroundings";

const margin = 1.06;

/** Moves a camera, which looks along a direction, so that a box fills the view. Returns its new target. */
export function fitCamera(camera: THREE.PerspectiveCamera, bounds: Bounds, towards: THREE.Vector3): THREE.Vector3 {
  const corners = Array.from({ length: 8 }, (_, i) => new THREE.Vector3(
    i & 1 ? bounds.max[0] : bounds.min[0],
    i & 2 ? bounds.max[1] : bounds.min[1],
    i & 4 ? bounds.max[2] : bounds.min[2]));
  const target = new THREE.Box3().setFromPoints(corners).getCenter(new THREE.Vector3());
  const direction = towards.clone().normalize();
  let distance = new THREE.Box3().setFromPoints(corners).getSize(new THREE.Vector3()).length();
  // What is near appears larger, so that the middle of the box is not that of its picture.
  for (let i = 0; i < 12; ++i) {
    camera.position.copy(target).addScaledVector(direction, distance);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const seen = new THREE.Box3().setFromPoints(corners.map((corner) => corner.clone().project(camera)));
    const tangent = Math.tan((camera.fov * Math.PI) / 360);
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    target.addScaledVector(right, 0.5 * (seen.min.x + seen.max.x) * tangent * camera.aspect * distance);
    target.addScaledVector(up, 0.5 * (seen.min.y + seen.max.y) * tangent * distance);
    const share = Math.max(seen.max.x - seen.min.x, seen.max.y - seen.min.y) / 2;
    distance *= Math.min(2, Math.max(0.5, share * margin));
  }
  return target;
}
