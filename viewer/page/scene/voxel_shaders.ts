// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { texelOfVoxel } from "./voxel_textures";

/** Three faces of a cube are visible from anywhere, of two triangles each. There are no attributes: the number of the
 * vertex tells the voxel, whose texels are looked up, and the corner. */
export const voxelVertexShader = /* glsl */ `
precision highp float;
uniform highp sampler2D centres; // metres from the layer's origin, and intensity
uniform highp sampler2D values;  // seconds since the voxel was seen, value of the field
uniform sampler2D paint;         // recorded colour, and 1 for noise
uniform int shape;               // 0 cubes, 1 squares, 2 discs
uniform float halfEdge;
uniform float threshold;
uniform bool hasIntensities;
uniform bool hidesNoise;
uniform vec3 noiseColour;
uniform int colourBy;           // 0 intensity, 1 height, 2 stream, 3 age, 4 recorded, 5 field
uniform vec3 streamColour;
uniform vec4 intensityAxis;     // min, max, step, 1 if logarithmic
uniform vec3 up;
uniform vec2 cut;               // heights between which voxels are drawn, as all from the layer's origin
uniform vec2 heightRange;
uniform bool hasField;
uniform vec2 fieldRange;
uniform float trailSeconds;
uniform sampler2D colourMap;
uniform vec2 viewport;           // pixels
flat out vec3 colour;
flat out float light;
out vec2 place;
out float pixels;               // of an edge

float intensityShare(float intensity) {
  float span = intensityAxis.y - intensityAxis.x;
  float value = clamp(intensity - intensityAxis.x, 0.0, span);
  if (intensityAxis.w < 0.5) return value / max(span, 1e-6);
  return log(1.0 + value / intensityAxis.z) / log(1.0 + span / intensityAxis.z);
}

float fieldShare(float value) {
  float span = fieldRange.y - fieldRange.x;
  return span > 0.0 ? clamp(value - fieldRange.x, 0.0, span) / span : 0.0;
}

vec3 colourOf(ivec2 texel, bool isNoise, float intensity, float height) {
  if (isNoise) return noiseColour;
  if (colourBy == 2) return streamColour;
  if (colourBy == 4) return texelFetch(paint, texel, 0).rgb;
  vec2 ageAndField = texelFetch(values, texel, 0).xy;
  if (colourBy == 5 && (!hasField || ageAndField.y < -2e38)) return vec3(160.0 / 255.0); // as where no colour was recorded
  float share = colourBy == 0 ? intensityShare(intensity)
    : colourBy == 1 ? (height - heightRange.x) / max(heightRange.y - heightRange.x, 1e-6)
    : colourBy == 3 ? ageAndField.x / trailSeconds
    : fieldShare(ageAndField.y);
  return texture(colourMap, vec2(clamp(share, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
}

const float leastPixels = 2.0;

void main() {
  int voxel = shape == 0 ? gl_VertexID / 18 : gl_VertexID;
  ivec2 texel = ${texelOfVoxel};
  vec4 centreAndIntensity = texelFetch(centres, texel, 0);
  vec3 centre = centreAndIntensity.xyz;
  float intensity = centreAndIntensity.w;
  bool isNoise = texelFetch(paint, texel, 0).a > 0.5 || (hasIntensities && intensity < threshold);
  light = 1.0;
  place = vec2(0.0);
  colour = vec3(0.0);
  pixels = 0.0;
  float height = dot(up, mat3(modelMatrix) * centre);
  if ((isNoise && hidesNoise) || height < cut.x - 0.002 * halfEdge || height > cut.y + 0.002 * halfEdge) {
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0); // all corners of it outside of the view
    return;
  }
  colour = colourOf(texel, isNoise, intensity, height);
  vec3 toCamera = -(transpose(mat3(modelViewMatrix)) * modelViewMatrix[3].xyz) - centre;
  float size = isNoise ? 0.6 * halfEdge : halfEdge;
  vec4 middle = projectionMatrix * (modelViewMatrix * vec4(centre, 1.0));
  pixels = projectionMatrix[1][1] * viewport.y * size / max(middle.w, 1e-6);
  size *= max(1.0, leastPixels / max(pixels, 1e-6)); // or far voxels would fall between pixels
  if (shape == 2) {
    gl_PointSize = max(pixels, 2.5);
    gl_Position = middle;
    return;
  }
  vec3 side = vec3(toCamera.x < 0.0 ? -1.0 : 1.0, toCamera.y < 0.0 ? -1.0 : 1.0, toCamera.z < 0.0 ? -1.0 : 1.0);
  vec3 lights = vec3(side.x > 0.0 ? 0.8 : 0.7, side.y > 0.0 ? 0.66 : 0.86, side.z > 0.0 ? 1.0 : 0.5);
  if (shape == 1) { // of the cube's area in the picture, and of its mean light
    vec3 areas = abs(normalize(toCamera));
    float area = areas.x + areas.y + areas.z;
    light = dot(areas, lights) / area;
    gl_PointSize = max(pixels, leastPixels) * sqrt(area);
    gl_Position = middle;
    return;
  }
  int face = gl_VertexID % 18 / 6; // across x, y, z
  int corner = gl_VertexID % 6;    // of two triangles
  place = vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0, corner == 2 || corner > 3 ? 1.0 : -1.0);
  light = lights[face];
  vec3 offset = face == 0 ? vec3(side.x, place) : face == 1 ? vec3(place.x, side.y, place.y) : vec3(place, side.z);
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(centre + size * offset, 1.0));
}
`;

export const voxelFragmentShader = /* glsl */ `
precision highp float;
flat in vec3 colour;
flat in float light;
in vec2 place;
in float pixels;
uniform int shape;
out vec4 result;

void main() {
  if (shape == 1) {
    result = vec4(colour * light, 1.0);
    return;
  }
  if (shape == 2) {
    vec2 fromMiddle = 2.0 * gl_PointCoord - 1.0;
    float radius = dot(fromMiddle, fromMiddle);
    if (radius > 1.0) discard;
    result = vec4(colour * (1.0 - 0.25 * radius), 1.0);
    return;
  }
  // A dark line along the edges, a pixel wide, that fades where voxels are only some pixels large.
  vec2 toEdge = (1.0 - abs(place)) / max(fwidth(place), vec2(1e-6));
  float line = 1.0 - clamp(min(toEdge.x, toEdge.y), 0.0, 1.0);
  float strength = 0.4 * smoothstep(7.0, 22.0, pixels);
  result = vec4(colour * light * (1.0 - line * strength), 1.0);
}
`;
