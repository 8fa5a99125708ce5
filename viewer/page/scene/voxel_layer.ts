// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import { arraysOf, totalCount } from "../decoding/packed_voxels";
import type { VoxelArrays } from "../decoding/packed_voxels";
import type { PackedVoxels } from "../decoding/messages";
import { identity } from "../recordings/transforms";
import type { Pose } from "../recordings/transforms";
import type { Rgb } from "./colour_maps";
import type { IntensityAxis } from "./intensity_axis";
import { voxelFragmentShader, voxelVertexShader } from "./voxel_shaders";

/** On the GPU, for voxels that have no value of the field. */
const noValue = -3e38;

/** Within the numbers of the GPU. */
export function forGpu(value: number): number {
  return Math.min(1e38, Math.max(-1e38, value));
}

/** Uniforms that all layers share; each has its own colour and edge besides. */
export interface SharedUniforms {
  [name: string]: THREE.IUniform;
}

/** The three faces of a cube, and a square, as corners for the shader. */
function baseGeometry(shape: "cubes" | "points"): { corners: number[]; index: number[] } {
  const corners: number[] = [];
  const index: number[] = [];
  for (const face of shape === "cubes" ? [0, 1, 2] : [3]) {
    const first = corners.length / 3;
    corners.push(-1, -1, face, 1, -1, face, 1, 1, face, -1, 1, face);
    index.push(first, first + 1, first + 2, first, first + 2, first + 3);
  }
  return { corners, index };
}

/** Draws the voxels of one stream, each as an instance. Its buffers only grow. */
export class VoxelLayer {
  readonly mesh: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.ShaderMaterial>;
  /** What is drawn now; null after a loss and before the first frame. */
  voxels: PackedVoxels | null = null;
  arrays: VoxelArrays | null = null;
  /** Number of voxels that are drawn, those seen before among them. */
  count = 0;
  time = 0; // of the frame, seconds
  edge = 0; // metres
  /** From the coordinates of the frame to those of the scene. */
  readonly pose = new THREE.Matrix4();
  /** Around all voxels, in the scene. */
  readonly box = new THREE.Box3();
  /** Values of fields are drawn as differences from it, as the GPU's numbers are too coarse for times of today. */
  private fieldBase = 0;
  private field: string | null = null; // that they are of
  private capacity = 0;
  private shape: "cubes" | "points" | null = null;

  constructor(shared: SharedUniforms) {
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: voxelVertexShader,
      fragmentShader: voxelFragmentShader,
      side: THREE.DoubleSide,
      uniforms: {
        ...shared,
        halfEdge: { value: 0 },
        hasIntensities: { value: true },
        hasField: { value: false },
        fieldRange: { value: new THREE.Vector2(0, 1) },
        streamColour: { value: new THREE.Vector3() },
      },
    });
    this.mesh = new THREE.Mesh(new THREE.InstancedBufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
    this.grow(4096);
    this.setShape("cubes");
  }

  setColour(colour: Rgb): void {
    this.mesh.material.uniforms.streamColour.value.fromArray(colour);
  }

  takeColour(other: VoxelLayer): void {
    this.mesh.material.uniforms.streamColour.value.copy(other.mesh.material.uniforms.streamColour.value);
  }

  setShape(shape: "cubes" | "points"): void {
    if (shape === this.shape) return;
    this.shape = shape;
    const { corners, index } = baseGeometry(shape);
    this.mesh.geometry.setAttribute("corner", new THREE.Float32BufferAttribute(corners, 3));
    this.mesh.geometry.setIndex(index);
  }

  setScale(scale: number): void {
    this.mesh.material.uniforms.halfEdge.value = 0.5 * scale * this.edge;
  }

  /** Says which field is to be drawn, if it is the one that the voxels have, and its axis. */
  setField(name: string | null, axis: IntensityAxis | null): void {
    const { hasField, fieldRange } = this.mesh.material.uniforms;
    hasField.value = axis !== null && name !== null && this.field === name;
    if (axis) fieldRange.value.set(forGpu(axis.min - this.fieldBase), forGpu(axis.bright - this.fieldBase));
  }

  /** Its voxels stay as they are drawn, but can no longer be asked for; returns their buffer, for use by others. */
  release(): ArrayBuffer | null {
    const before = this.voxels?.buffer ?? null;
    this.voxels = null;
    this.arrays = null;
    return before;
  }

  /** Takes a frame's voxels; returns the buffer of those drawn before. */
  show(voxels: PackedVoxels | null, edge: number, pose: Pose = identity): ArrayBuffer | null {
    const before = this.release();
    const [x, y, z, ...rotation] = pose;
    this.mesh.quaternion.fromArray(rotation);
    this.pose.compose(new THREE.Vector3(x, y, z), this.mesh.quaternion, new THREE.Vector3(1, 1, 1));
    this.voxels = voxels;
    this.arrays = voxels ? arraysOf(voxels.buffer, totalCount(voxels), voxels.field !== null) : null;
    const count = (this.count = voxels ? totalCount(voxels) : 0);
    this.field = voxels?.field ?? null;
    this.box.makeEmpty();
    this.mesh.geometry.instanceCount = count;
    if (this.arrays) {
      this.edge = edge;
      this.mesh.material.uniforms.hasIntensities.value = voxels?.hasIntensities ?? false;
      if (count > this.capacity) this.grow(Math.ceil(count * 1.3));
      this.upload(this.arrays, count);
      this.box.setFromArray(this.arrays.positions).applyMatrix4(this.pose);
    }
    return before;
  }

  /** Where the centre of a voxel is in the scene. */
  placeOf(voxel: number): [number, number, number] {
    return new THREE.Vector3().fromArray(this.arrays?.positions ?? [], 3 * voxel).applyMatrix4(this.pose).toArray();
  }

  /** Of that place, along an axis of the scene. */
  coordinateOf(voxel: number, axis: number): number {
    const [x, y, z] = this.arrays?.positions.subarray(3 * voxel, 3 * voxel + 3) ?? [];
    const { elements } = this.pose;
    return elements[axis] * x + elements[axis + 4] * y + elements[axis + 8] * z + elements[axis + 12];
  }

  /** Where the centres of all voxels are in the scene that are drawn. */
  drawnPlaces(): number[] {
    this.mesh.updateMatrixWorld();
    const centres = this.attribute("centre").array;
    return Array.from({ length: this.count }, (_, i) =>
      new THREE.Vector3().fromArray(centres, 3 * i).applyMatrix4(this.mesh.matrixWorld).toArray()).flat();
  }

  private attribute(name: string): THREE.InstancedBufferAttribute {
    return this.mesh.geometry.getAttribute(name) as unknown as THREE.InstancedBufferAttribute;
  }

  private grow(capacity: number): void {
    this.capacity = capacity;
    const old = this.mesh.geometry;
    const geometry = new THREE.InstancedBufferGeometry();
    for (const [name, size] of [["centre", 3], ["quantities", 3]] as const)
      geometry.setAttribute(name, this.dynamic(new Float32Array(size * capacity), size, false));
    geometry.setAttribute("paint", this.dynamic(new Uint8Array(4 * capacity), 4, true));
    if (old.index) {
      geometry.setAttribute("corner", old.getAttribute("corner"));
      geometry.setIndex(old.index);
    }
    geometry.instanceCount = old.instanceCount;
    this.mesh.geometry = geometry;
    old.dispose();
  }

  private dynamic(array: Float32Array | Uint8Array, size: number, isShare: boolean): THREE.InstancedBufferAttribute {
    const attribute = new THREE.InstancedBufferAttribute(array, size, isShare);
    attribute.setUsage(THREE.DynamicDrawUsage);
    return attribute;
  }

  private upload(arrays: VoxelArrays, count: number): void {
    const quantities = this.attribute("quantities").array as Float32Array;
    this.fieldBase = arrays.field?.find(Number.isFinite) ?? 0;
    for (let i = 0; i < count; ++i) {
      const value = arrays.field ? arrays.field[i] : NaN;
      quantities[3 * i] = arrays.intensities[i];
      quantities[3 * i + 1] = arrays.ages[i];
      quantities[3 * i + 2] = Number.isNaN(value) ? noValue : forGpu(value - this.fieldBase);
    }
    // The GPU's numbers are too coarse for cubes at the coordinates of maps, in the millions of metres.
    const [x, y, z] = count > 0 ? arrays.positions : [0, 0, 0];
    this.mesh.position.set(x, y, z).applyMatrix4(this.pose);
    const centres = this.attribute("centre").array as Float32Array;
    for (let i = 0; i < 3 * count; i += 3) {
      centres[i] = arrays.positions[i] - x;
      centres[i + 1] = arrays.positions[i + 1] - y;
      centres[i + 2] = arrays.positions[i + 2] - z;
    }
    (this.attribute("paint").array as Uint8Array).set(arrays.paint);
    for (const name of ["centre", "quantities", "paint"]) {
      const attribute = this.attribute(name);
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, count * attribute.itemSize);
      attribute.needsUpdate = true;
    }
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}
