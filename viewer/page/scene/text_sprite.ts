// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

/** A short text that faces the camera, keeps its size on the screen and has an outline of another colour. */
export function textSprite(text: string, colour: string, outline: string, pixels = 13): THREE.Sprite {
  const scale = 3;
  const canvas = document.createElement("canvas");
  const font = `600 ${pixels * scale}px system-ui, "Segoe UI", Roboto, sans-serif`;
  let context = canvas.getContext("2d") as CanvasRenderingContext2D;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 4 * scale;
  canvas.height = Math.ceil(pixels * scale * 1.4);
  context = canvas.getContext("2d") as CanvasRenderingContext2D;
  context.font = font;
  context.fillStyle = colour;
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 3 * scale;
  context.strokeStyle = outline;
  context.strokeText(text, 2 * scale, canvas.height / 2);
  context.fillText(text, 2 * scale, canvas.height / 2);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.NoColorSpace;
  texture.premultiplyAlpha = true; // or the black of transparent pixels shows at the edges
  const material = new THREE.SpriteMaterial({ map: texture, depthTest: false, depthWrite: false, sizeAttenuation: false });
  material.premultipliedAlpha = true;
  material.toneMapped = false;
  const sprite = new THREE.Sprite(material);
  sprite.renderOrder = 1;
  sprite.userData.pixels = [canvas.width / scale, canvas.height / scale];
  return sprite;
}

/** Gives the sprites of a scene their size in pixels, for the height of the view. */
export function scaleSprites(root: THREE.Object3D, viewHeight: number, fovDegrees: number): void {
  const perPixel = (2 * Math.tan((fovDegrees * Math.PI) / 360)) / viewHeight;
  root.traverse((object) => {
    const pixels = object.userData.pixels as [number, number] | undefined;
    if (pixels) object.scale.set(pixels[0] * perPixel, pixels[1] * perPixel, 1);
  });
}

/** Frees what a part of the scene holds on the GPU, and takes it out. */
export function disposeAll(group: THREE.Object3D): void {
  group.traverse((object) => {
    const drawn = object as THREE.Mesh;
    drawn.geometry?.dispose();
    const material = drawn.material as (THREE.Material & { map?: THREE.Texture | null }) | undefined;
    material?.map?.dispose();
    material?.dispose();
  });
  group.clear();
}
