// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import { boxEdges, lines } from "./surroundings";
import type { SceneColours } from "./surroundings";
import { disposeAll, textSprite } from "./text_sprite";

/** A voxel to mark: its centre and its cube in the scene. */
export interface MarkedVoxel {
  place: [number, number, number];
  edge: number;
  rotation: THREE.Quaternion;
}

const ringPixels = 26;

/** A ring that keeps its size on the screen, so that voxels of some pixels are found, too. */
function ring(colour: string, outline: string): THREE.Sprite {
  const scale = 3;
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = ringPixels * scale;
  const context = canvas.getContext("2d") as CanvasRenderingContext2D;
  for (const [width, stroke] of [[4.5, outline], [2, colour]] as const) {
    context.beginPath();
    context.arc(canvas.width / 2, canvas.width / 2, (ringPixels / 2 - 3) * scale, 0, 2 * Math.PI);
    context.lineWidth = width * scale;
    context.strokeStyle = stroke;
    context.stroke();
  }
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.NoColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, depthWrite: false, sizeAttenuation: false }));
  sprite.renderOrder = 2;
  sprite.userData.pixels = [ringPixels, ringPixels];
  return sprite;
}

/** Marks around voxels that were picked; of two of them a line with the distance. */
export class SelectionMarks {
  readonly group = new THREE.Group();
  private voxels: readonly MarkedVoxel[] = [];
  private text = "";
  private colours: SceneColours | null = null;

  setColours(colours: SceneColours): void {
    this.colours = colours;
    this.show(this.voxels, this.text);
  }

  /** @param text written at the middle between two voxels */
  show(voxels: readonly MarkedVoxel[], text: string): void {
    this.voxels = voxels;
    this.text = text;
    disposeAll(this.group);
    if (!this.colours) return;
    const { selection, background } = this.colours;
    for (const { place, edge, rotation } of voxels) {
      const half = 0.56 * edge;
      const cube = new THREE.Group();
      cube.add(lines(boxEdges({ min: [-half, -half, -half], max: [half, half, half] }), selection));
      cube.position.fromArray(place);
      cube.quaternion.copy(rotation);
      const around = ring(selection, background);
      around.position.fromArray(place);
      this.group.add(cube, around);
    }
    if (voxels.length < 2) return;
    const [from, to] = voxels.map(({ place }) => new THREE.Vector3().fromArray(place));
    const line = lines([...from.toArray(), ...to.toArray()], selection);
    (line.material as THREE.LineBasicMaterial).depthTest = false;
    const label = textSprite(text, selection, background, 14);
    label.position.copy(from.add(to).multiplyScalar(0.5));
    label.center.set(0.5, -0.7); // above the rings, where voxels are near each other
    label.renderOrder = 3;
    this.group.add(line, label);
  }
}
