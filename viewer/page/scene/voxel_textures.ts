// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

/** Texels of a row, a power of two. */
const width = 2048;

/** The texel of a voxel, in the shader's language. */
export const texelOfVoxel = `ivec2(voxel & ${width - 1}, voxel >> ${Math.log2(width)})`;

/** Voxels that a frame may have more than the last one without new textures. */
const mostSpare = 2 ** 20;

/** Voxels on the GPU, a texel of each texture for a voxel. They are no instances, whose drawing takes software renderers
 * seven times as long. */
export class VoxelTextures {
  /** x, y, z in metres from the layer's origin, and intensity. */
  readonly centres: Float32Array<ArrayBuffer>;
  /** Seconds since the voxel was seen, and value of the field. */
  readonly values: Float32Array<ArrayBuffer>;
  /** Recorded colour, and 255 for noise. */
  readonly paint: Uint8Array<ArrayBuffer>;
  private readonly textures: Record<"centres" | "values" | "paint", THREE.DataTexture>;

  private constructor(private readonly rows: number) {
    this.centres = new Float32Array(4 * this.capacity);
    this.values = new Float32Array(2 * this.capacity);
    this.paint = new Uint8Array(4 * this.capacity);
    this.textures = {
      centres: new THREE.DataTexture(this.centres, width, rows, THREE.RGBAFormat, THREE.FloatType),
      values: new THREE.DataTexture(this.values, width, rows, THREE.RGFormat, THREE.FloatType),
      paint: new THREE.DataTexture(this.paint, width, rows, THREE.RGBAFormat, THREE.UnsignedByteType),
    };
  }

  get capacity(): number {
    return width * this.rows;
  }

  /** Those before, if they suit so many voxels, else new ones. Each upload writes the whole of them. */
  static of(before: VoxelTextures | null, count: number): VoxelTextures {
    const rows = Math.ceil((count + Math.min(0.3 * count, mostSpare)) / width);
    if (before && count <= before.capacity && before.rows <= 4 * rows + 2) return before;
    before?.dispose();
    return new VoxelTextures(Math.max(2, rows));
  }

  /** Uploads what was written, before the next picture. */
  upload(uniforms: Record<string, THREE.IUniform>): void {
    for (const [name, texture] of Object.entries(this.textures)) {
      texture.needsUpdate = true;
      uniforms[name].value = texture;
    }
  }

  dispose(): void {
    for (const texture of Object.values(this.textures)) texture.dispose();
  }
}
