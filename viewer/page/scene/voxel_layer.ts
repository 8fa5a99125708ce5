// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import { arraysOf, totalCount } from "../decoding/packed_voxels";
import type { VoxelArrays } from "../decoding/packed_voxels";
import type { PackedVoxels } from "../decoding/messages";
import { identity } from "../recordings/transforms";
import type { Pose } from "../recordings/transforms";
import type { Rgb } from "./colour_maps";
import type { IntensityAxis } from "./intensity_axis";
import { VoxelTextures } from "./voxel_textures";
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

/** As the shader has them. */
const verticesOfCube = 18;
const shapes = { cubes: 0, squares: 1, discs: 2 };

/** Voxels of which the nearest has fewer pixels are drawn as squares, each a single vertex. */
const leastPixelsOfCubes = 3;

/** Draws the voxels of one stream. */
export class VoxelLayer {
  /** What is drawn, where the frame is. */
  readonly group = new THREE.Group();
  readonly material: THREE.ShaderMaterial;
  /** What is drawn now; null after a loss and before the first frame. */
  voxels: PackedVoxels | null = null;
  arrays: VoxelArrays | null = null;
  /** Number of voxels that are drawn, those seen before among them. */
  count = 0;
  time = 0; // of the frame, seconds
  edge = 0; // metres
  /** From the positions of the voxels to places in the scene. */
  readonly pose = new THREE.Matrix4();
  /** Around all voxels, in the scene. */
  readonly box = new THREE.Box3();
  /** Values of fields are drawn as differences from it, as the GPU's numbers are too coarse for times of today. */
  private fieldBase = 0;
  private field: string | null = null; // that they are of
  private textures: VoxelTextures | null = null;
  private shape: "cubes" | "points" = "cubes";
  /** Triangles of cubes, and points: vertices without attributes. */
  private readonly cubes = new THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>();
  private readonly points = new THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>();

  constructor(shared: SharedUniforms) {
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: voxelVertexShader,
      fragmentShader: voxelFragmentShader,
      side: THREE.DoubleSide,
      uniforms: {
        ...shared,
        centres: { value: null },
        values: { value: null },
        paint: { value: null },
        shape: { value: shapes.cubes },
        halfEdge: { value: 0 },
        cut: { value: new THREE.Vector2() },
        heightRange: { value: new THREE.Vector2() },
        hasIntensities: { value: true },
        hasField: { value: false },
        fieldRange: { value: new THREE.Vector2(0, 1) },
        streamColour: { value: new THREE.Vector3() },
      },
    });
    for (const object of [this.cubes, this.points]) {
      object.material = this.material;
      object.frustumCulled = false;
    }
    this.group.add(this.cubes, this.points);
    this.group.visible = false;
  }

  setColour(colour: Rgb): void {
    this.material.uniforms.streamColour.value.fromArray(colour);
  }

  takeColour(other: VoxelLayer): void {
    this.material.uniforms.streamColour.value.copy(other.material.uniforms.streamColour.value);
  }

  setShape(shape: "cubes" | "points"): void {
    this.shape = shape;
  }

  /** Draws voxels that are small from here in a simpler way.
   * @param height of the picture, pixels
   */
  chooseDetail(camera: THREE.PerspectiveCamera, height: number): void {
    const { halfEdge, shape } = this.material.uniforms;
    const distance = Math.max(1e-6, this.box.distanceToPoint(camera.position));
    const pixels = (camera.projectionMatrix.elements[5] * height * halfEdge.value) / distance;
    const isSmall = pixels < leastPixelsOfCubes;
    shape.value = this.shape === "points" ? shapes.discs : isSmall ? shapes.squares : shapes.cubes;
    this.cubes.visible = shape.value === shapes.cubes;
    this.points.visible = !this.cubes.visible;
  }

  /** Says which heights are drawn, and which the ends of the colours are. The GPU has them from the layer's own
   * origin on, as its numbers are too coarse for heights in the coordinates of maps. */
  setHeights(up: THREE.Vector3, drawn: readonly [number, number], coloured: readonly [number, number]): void {
    const { cut, heightRange } = this.material.uniforms;
    const height = up.dot(this.group.position);
    cut.value.set(forGpu(drawn[0] - height), forGpu(drawn[1] - height));
    heightRange.value.set(coloured[0] - height, coloured[1] - height);
  }

  setScale(scale: number): void {
    this.material.uniforms.halfEdge.value = 0.5 * scale * this.edge;
  }

  /** Says which field is to be drawn, if it is the one that the voxels have, and its axis. */
  setField(name: string | null, axis: IntensityAxis | null): void {
    const { hasField, fieldRange } = this.material.uniforms;
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
    this.group.quaternion.fromArray(rotation);
    this.pose.compose(new THREE.Vector3(x, y, z), this.group.quaternion, new THREE.Vector3(1, 1, 1));
    this.group.position.set(...(voxels?.origin ?? [0, 0, 0])).applyMatrix4(this.pose);
    this.pose.setPosition(this.group.position);
    this.voxels = voxels;
    this.arrays = voxels ? arraysOf(voxels.buffer, totalCount(voxels), voxels.field !== null) : null;
    const count = (this.count = voxels ? totalCount(voxels) : 0);
    this.field = voxels?.field ?? null;
    this.box.makeEmpty();
    this.cubes.geometry.setDrawRange(0, verticesOfCube * count);
    this.points.geometry.setDrawRange(0, count);
    if (this.arrays) {
      this.edge = edge;
      this.material.uniforms.hasIntensities.value = voxels?.hasIntensities ?? false;
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
    const { elements } = this.pose;
    if (this.arrays === null) return NaN;
    const { positions } = this.arrays;
    const at = 3 * voxel;
    return elements[axis] * positions[at] + elements[axis + 4] * positions[at + 1] + elements[axis + 8] * positions[at + 2] + elements[axis + 12];
  }

  /** Where the centres of all voxels are in the scene that are drawn. */
  drawnPlaces(): number[] {
    this.group.updateMatrixWorld();
    const centres = this.textures?.centres ?? new Float32Array();
    return Array.from({ length: this.count }, (_, i) =>
      new THREE.Vector3().fromArray(centres, 4 * i).applyMatrix4(this.group.matrixWorld).toArray()).flat();
  }

  private upload(arrays: VoxelArrays, count: number): void {
    this.textures = VoxelTextures.of(this.textures, count);
    const { centres, values, paint } = this.textures;
    this.fieldBase = arrays.field?.find(Number.isFinite) ?? 0;
    for (let i = 0; i < count; ++i) {
      centres[4 * i] = arrays.positions[3 * i];
      centres[4 * i + 1] = arrays.positions[3 * i + 1];
      centres[4 * i + 2] = arrays.positions[3 * i + 2];
      centres[4 * i + 3] = arrays.intensities[i];
      const value = arrays.field ? arrays.field[i] : NaN;
      values[2 * i] = arrays.ages[i];
      values[2 * i + 1] = Number.isNaN(value) ? noValue : forGpu(value - this.fieldBase);
    }
    paint.set(arrays.paint);
    this.textures.upload(this.material.uniforms);
  }

  dispose(): void {
    this.cubes.geometry.dispose();
    this.points.geometry.dispose();
    this.textures?.dispose();
    this.material.dispose();
  }
}
