// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

const vertexShader = /* glsl */ `
out vec2 place;
void main() {
  place = uv;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

/** Eye-dome lighting (C. Boucheny, 2009): a pixel is darker the farther it lies behind those around it. */
const fragmentShader = /* glsl */ `
precision highp float;
precision highp sampler2D;
in vec2 place;
uniform sampler2D picture;
uniform sampler2D depths;
uniform vec2 viewport;
uniform vec2 range; // near and far plane
uniform float radius; // pixels
out vec4 result;

float distanceAt(vec2 at) {
  float depth = texture(depths, at).r;
  return range.x * range.y / (range.y - depth * (range.y - range.x));
}

void main() {
  vec4 colour = texture(picture, place);
  float here = distanceAt(place);
  float behind = 0.0;
  if (here < 0.98 * range.y) {
    float logHere = log2(here);
    for (int i = 0; i < 8; ++i) {
      float angle = 0.785398 * float(i);
      vec2 beside = place + radius * vec2(cos(angle), sin(angle)) / viewport;
      behind += clamp(logHere - log2(distanceAt(beside)), 0.0, 0.06) / 8.0;
    }
  }
  result = vec4(colour.rgb * exp(-24.0 * behind), 1.0);
}
`;

/** Draws a scene with edges in depth made visible, which shows shapes that colours do not. */
export class DepthShading {
  private readonly target: THREE.WebGLRenderTarget;
  private readonly quad: THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial>;
  private readonly quadCamera = new THREE.Camera();

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    this.target = new THREE.WebGLRenderTarget(1, 1, { samples: 4, depthBuffer: true });
    this.target.depthTexture = new THREE.DepthTexture(1, 1, THREE.UnsignedIntType);
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader,
      fragmentShader,
      depthTest: false,
      depthWrite: false,
      uniforms: {
        picture: { value: this.target.texture },
        depths: { value: this.target.depthTexture },
        viewport: { value: new THREE.Vector2(1, 1) },
        range: { value: new THREE.Vector2(0.1, 100) },
        radius: { value: 1.5 },
      },
    });
    this.quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    this.quad.frustumCulled = false;
  }

  setSize(width: number, height: number, pixelRatio: number): void {
    this.target.setSize(width, height);
    this.quad.material.uniforms.viewport.value.set(width, height);
    this.quad.material.uniforms.radius.value = 1.4 * pixelRatio;
  }

  draw(scene: THREE.Scene, camera: THREE.PerspectiveCamera): void {
    this.quad.material.uniforms.range.value.set(camera.near, camera.far);
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(scene, camera);
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.quad, this.quadCamera);
  }
}
