// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import type { Bounds, Label } from "./camera_fit";
import { disposeAll, textSprite } from "./text_sprite";
import type { Up } from "./up_axis";

export interface SceneColours {
  background: string;
  grid: string;
  gridStrong: string;
  label: string;
  noise: string;
  selection: string;
  crop: string;
}

/** A sensor's place: position and quaternion x, y, z, w. Its z axis looks along the view. */
export interface SensorPose {
  name: string;
  colour: string;
  values: number[];
}

/** Numbers of a metadata text such as "x,y,z,qx,qy,qz,qw"; null if they are not as many. */
export function numbersOf(text: string | undefined, count: number): number[] | null {
  const numbers = (text ?? "").split(/[,\s]+/).filter(Boolean).map(Number);
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

/** Characters of a sensor's name that are drawn. */
const longestName = 24;

/** Lines between points, each two of them. */
export function lines(points: number[], colour: string, opacity = 1): THREE.LineSegments {
  const geometry = new THREE.BufferGeometry();
  const origin = points.slice(0, 3); // as far coordinates are too coarse on the GPU
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.map((value, i) => value - origin[i % 3]), 3));
  // Drawn after the voxels, and without a depth of their own, which would be shaded.
  const material = new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity, depthWrite: false });
  const result = new THREE.LineSegments(geometry, material);
  result.position.fromArray(points.length ? origin : [0, 0, 0]);
  return result;
}

/** The twelve edges of a box. */
export function boxEdges({ min, max }: Bounds): number[] {
  const points: number[] = [];
  for (let axis = 0; axis < 3; ++axis)
    for (let corner = 0; corner < 4; ++corner) {
      const from = [0, 0, 0];
      from[(axis + 1) % 3] = corner & 1 ? max[(axis + 1) % 3] : min[(axis + 1) % 3];
      from[(axis + 2) % 3] = corner & 2 ? max[(axis + 2) % 3] : min[(axis + 2) % 3];
      from[axis] = min[axis];
      const to = [...from];
      to[axis] = max[axis];
      points.push(...from, ...to);
    }
  return points;
}

/** Metres between two lines: 1, unless that would be too many or too few. */
function gridStep(extent: number): number {
  if (extent === 0) return 0.1;
  const most = extent < 4 ? 8 : 30; // lines, whatever the extent
  const power = 10 ** Math.floor(Math.log10(extent / most));
  const step = power * ([1, 2, 5].find((factor) => extent / (factor * power) < most) ?? 10);
  return extent < 4 ? step : Math.max(1, step);
}

/** From this distance between lines on, they are labelled in kilometres. */
const metresInKm = 500;

/** Longer labels are too wide to be at each line. */
const longestDense = 6;

/** The end of a name, by which sensors differ. */
function shortened(name: string): string {
  return name.length > longestName ? `…${name.slice(1 - longestName)}` : name;
}

function distanceText(value: number, unit: string): string {
  return `${Number(value.toPrecision(9))} ${unit}`;
}

/** Floor grid with labels, axes of the origin, sensors and crop box. */
export class Surroundings {
  readonly grid = new THREE.Group();
  readonly axes = new THREE.Group();
  readonly sensors = new THREE.Group();
  readonly cropBox = new THREE.Group();
  private sensorPlaces: number[][] = [];
  private labelled = new THREE.Box3(); // where labels are worth a wider view

  addTo(scene: THREE.Scene): void {
    scene.add(this.grid, this.axes, this.sensors, this.cropBox);
  }

  /** Of voxels with an edge and their centres in bounds. On narrow screens only few lines have labels. */
  setGrid(bounds: Bounds, edge: number, up: Up, colours: SceneColours, isNarrow: boolean): void {
    disposeAll(this.grid);
    this.labelled.min.fromArray(bounds.min);
    this.labelled.max.fromArray(bounds.max);
    this.labelled.expandByVector(this.labelled.getSize(new THREE.Vector3()).multiplyScalar(0.6).addScalar(1));
    const axes = up.floorAxes;
    const step = gridStep(Math.max(...axes.map((axis) => bounds.max[axis] - bounds.min[axis])));
    const low = axes.map((axis) => Math.floor(bounds.min[axis] / step) * step);
    const high = axes.map((axis) => Math.ceil(bounds.max[axis] / step) * step);
    const [lowest] = up.heights(bounds);
    // The world's floor is at 0; clouds in a sensor's own coordinates have none.
    const floor = up.sign * (up.name === "z" && Math.abs(lowest) < 1 ? 0 : lowest - edge / 2);
    const place = (first: number, second: number): number[] => {
      const result = [floor, floor, floor];
      result[axes[0]] = first;
      result[axes[1]] = second;
      return result;
    };
    const textOf = (at: number): string => (step < metresInKm ? distanceText(at, "m") : distanceText(at / 1000, "km"));
    const longest = Math.max(...[...low, ...high].map((at) => textOf(at).length));
    const isLong = longest > longestDense;
    const every = isLong && isNarrow ? 10 : step < 1 || isNarrow || isLong ? 5 : 1;
    const thin: number[] = [];
    const strong: number[] = [];
    for (const axis of [0, 1]) {
      const other = 1 - axis;
      const count = Math.round((high[axis] - low[axis]) / step);
      for (let i = 0; i <= count; ++i) {
        const at = low[axis] + i * step;
        const ends = [low[other], high[other]].map((end) => (axis === 0 ? place(at, end) : place(end, at)));
        (Math.round(at / step) % 5 === 0 ? strong : thin).push(...ends.flat());
        const number = Math.round(at / step);
        // In the corner long labels of both axes would lie on each other.
        const isCorner = axis === 1 && i === 0 && Math.round(low[0] / step) % every === 0;
        if (number !== 0 && number % every === 0 && !(isLong && isCorner))
          this.addLabel(textOf(at), axis === 0 ? place(at, low[1] - 0.35 * step) : place(low[0] - 0.35 * step, at), colours);
      }
    }
    this.grid.add(lines(thin, colours.grid), lines(strong, colours.gridStrong));
  }

  private addLabel(text: string, place: number[], colours: SceneColours): void {
    const sprite = textSprite(text, colours.label, colours.background, 11);
    sprite.position.fromArray(place);
    this.grid.add(sprite);
  }

  setAxes(length: number, colours: SceneColours): void {
    disposeAll(this.axes);
    const names = [["x", "#e5484d"], ["y", "#30a46c"], ["z", "#3e8ef7"]];
    names.forEach(([name, colour], axis) => {
      const end = [0, 0, 0];
      end[axis] = length;
      this.axes.add(lines([0, 0, 0, ...end], colour));
      const sprite = textSprite(name, colour, colours.background);
      sprite.position.set(end[0] * 1.12, end[1] * 1.12, end[2] * 1.12);
      this.axes.add(sprite);
    });
  }

  /** A box that has the sensors in it, too, where they are not far away. */
  withSensors(bounds: Bounds): Bounds {
    const min: [number, number, number] = [...bounds.min];
    const max: [number, number, number] = [...bounds.max];
    for (const place of this.sensorPlaces)
      for (let axis = 0; axis < 3; ++axis) {
        const reach = 0.5 * (bounds.max[axis] - bounds.min[axis]);
        min[axis] = Math.max(bounds.min[axis] - reach, Math.min(min[axis], place[axis]));
        max[axis] = Math.min(bounds.max[axis] + reach, Math.max(max[axis], place[axis]));
      }
    return { min, max };
  }

  /** The labels that are drawn, for a view that has all of them in it. */
  labels(): Label[] {
    const box = this.labelled;
    const shown = [this.grid, this.sensors].filter(({ visible }) => visible).flatMap(({ children }) => children);
    return shown.flatMap(({ position, userData }) => {
      const pixels = userData.pixels as [number, number] | undefined;
      return pixels && box.containsPoint(position) ? [{ place: position.clone(), width: pixels[0], height: pixels[1] }] : [];
    });
  }

  setSensors(poses: SensorPose[], up: Up, colours: SceneColours, isNarrow: boolean): void {
    disposeAll(this.sensors);
    this.sensorPlaces = poses.map(({ values }) => values.slice(0, 3));
    for (const { name, colour, values } of poses) {
      const [x, y, z, qx, qy, qz, qw] = values;
      const sensor = new THREE.Group();
      const depth = 0.32;
      const w = 0.22;
      const h = 0.17;
      const corners = [[-w, -h], [w, -h], [w, h], [-w, h]].map(([u, v]) => [u, v, depth]);
      const points: number[] = [];
      corners.forEach((corner, i) => points.push(0, 0, 0, ...corner, ...corner, ...corners[(i + 1) % 4]));
      sensor.add(lines(points, colour));
      const face = new THREE.BufferGeometry();
      face.setAttribute("position", new THREE.Float32BufferAttribute(corners.flat(), 3));
      face.setIndex([0, 1, 2, 0, 2, 3]);
      const glass = new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.25, side: THREE.DoubleSide, depthWrite: false });
      sensor.add(new THREE.Mesh(face, glass));
      sensor.position.set(x, y, z);
      sensor.quaternion.set(qx, qy, qz, qw).normalize();
      const label = textSprite(shortened(name), colours.label, colours.background, isNarrow ? 10 : 12);
      label.position.set(x, y, z).addScaledVector(up.vector, 0.3);
      this.sensors.add(sensor, label);
    }
  }

  setCropBox(box: Bounds | null, colours: SceneColours): void {
    disposeAll(this.cropBox);
    if (box) this.cropBox.add(lines(boxEdges(box), colours.crop, 0.8));
  }
}
