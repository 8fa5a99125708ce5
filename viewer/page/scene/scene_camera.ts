// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { cornersOf, fitCamera } from "./camera_fit";
import type { Bounds, Label, ViewSize } from "./camera_fit";
import { Up } from "./up_axis";

export const fieldOfView = 45; // degrees, vertical

export type ViewDirection = "oblique" | "top" | "front" | "side";

/** Where z is up. */
const directions: Record<ViewDirection | "steep", [number, number, number]> = {
  steep: [-0.5, -0.62, 0.95], // for high and narrow views
  oblique: [-0.62, -0.78, 0.62],
  top: [0, -0.001, 1],
  front: [0, -1, 0.08],
  side: [1, 0, 0.08],
};

/** The camera, which the user turns, moves and zooms, or which is placed so that something is in view. */
export class SceneCamera {
  readonly perspective = new THREE.PerspectiveCamera(fieldOfView, 1, 0.02, 2000);
  private controls: OrbitControls;
  private up = new Up("z");
  /** How the camera was fitted, as long as it has not been moved since. */
  fitted: ViewDirection | "keep" | null = null;
  isPlacedByUser = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly onMoved: () => void,
  ) {
    this.perspective.up.copy(this.up.vector);
    this.perspective.position.set(-5, -6, 5);
    this.controls = this.createControls();
  }

  private createControls(): OrbitControls {
    const controls = new OrbitControls(this.perspective, this.canvas);
    controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    controls.dampingFactor = 0.12;
    controls.zoomToCursor = true;
    controls.addEventListener("change", () => this.onMoved());
    controls.addEventListener("start", () => this.keep());
    return controls;
  }

  /** The place that it looks at, and around which it turns. */
  get target(): THREE.Vector3 {
    return this.controls.target;
  }

  setUp(up: Up): void {
    this.up = up;
    this.perspective.up.copy(up.vector);
    // Controls know only the axis that they were made with.
    const { target } = this.controls;
    this.controls.dispose();
    this.controls = this.createControls();
    this.controls.target.copy(target);
    this.controls.update();
  }

  setAspect(aspect: number): void {
    this.perspective.aspect = aspect;
    this.perspective.updateProjectionMatrix();
  }

  /** Goes on with a movement that the user has begun; to be called for each picture. */
  update(): void {
    this.controls.update();
  }

  /** Looks along a direction, or that of now, so that a box and labels are in view. */
  fit(direction: ViewDirection | "keep", box: Bounds, labels: Label[], view: ViewSize): void {
    this.fitted = direction;
    const camera = this.perspective.clone();
    const towards =
      direction === "keep"
        ? camera.position.clone().sub(this.target)
        : new THREE.Vector3(...directions[direction === "oblique" && camera.aspect < 0.8 ? "steep" : direction]).applyQuaternion(this.up.fromZ);
    const target = fitCamera(camera, cornersOf(box), labels, view, towards);
    this.place(camera.position, target);
  }

  /** From now on the camera stays where the user has put it. */
  private keep(): void {
    this.fitted = null;
    this.isPlacedByUser = true;
  }

  /** For another source the camera is placed anew, as soon as there are voxels. */
  forget(): void {
    this.isPlacedByUser = false;
    this.fitted = null;
  }

  private place(position: THREE.Vector3, target: THREE.Vector3): void {
    this.perspective.position.copy(position);
    this.target.copy(target);
    this.controls.update();
    this.onMoved();
  }

  /** Moves the camera with what it looks at. */
  carry(by: readonly [number, number, number]): void {
    this.fitted = null;
    const step = new THREE.Vector3(...by);
    this.place(this.perspective.position.clone().add(step), this.target.clone().add(step));
  }

  /** Position and target. */
  values(): number[] {
    return [...this.perspective.position.toArray(), ...this.target.toArray()];
  }

  setValues(values: number[]): void {
    this.keep();
    this.place(new THREE.Vector3(...values.slice(0, 3)), new THREE.Vector3(...values.slice(3, 6)));
  }

  /** Turns, tilts or zooms, for keys: angles in radians, shares of the distance. */
  move(turn: number, tilt: number, zoom: number): void {
    this.keep();
    const offset = this.perspective.position.clone().sub(this.target);
    const angles = new THREE.Spherical().setFromVector3(offset.applyQuaternion(this.up.toY));
    angles.theta += turn;
    angles.phi = Math.min(Math.PI - 0.01, Math.max(0.01, angles.phi + tilt));
    angles.radius *= zoom;
    const moved = new THREE.Vector3().setFromSpherical(angles).applyQuaternion(this.up.toY.clone().invert());
    this.place(moved.add(this.target), this.target.clone());
  }

  /** From the camera through a point of the screen. */
  rayThrough(clientX: number, clientY: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    const place = new THREE.Vector2(
      ((clientX - box.left) / box.width) * 2 - 1,
      1 - ((clientY - box.top) / box.height) * 2,
    );
    this.perspective.updateMatrixWorld(); // which the last picture may not have yet
    const caster = new THREE.Raycaster();
    caster.setFromCamera(place, this.perspective);
    return caster.ray;
  }
}
