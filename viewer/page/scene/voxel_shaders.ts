// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Three faces of a cube are visible from anywhere: `corner` has the face and a corner of it. */
export const voxelVertexShader = /* glsl */ `
precision highp float;
in vec3 corner;      // two coordinates in the face, -1 or 1, and the face's axis; 3: a disc
in vec3 centre;      // metres, from the layer's origin
in vec3 quantities;  // intensity, seconds since the voxel was seen, value of the field
in vec4 paint;       // recorded colour, and 1 for noise
uniform float halfEdge;
uniform float threshold;
uniform bool hasIntensities;
uniform bool hidesNoise;
uniform vec3 noiseColour;
uniform int colourBy;           // 0 intensity, 1 height, 2 stream, 3 age, 4 recorded, 5 field
uniform vec3 streamColour;
uniform vec4 intensityAxis;     // min, max, step, 1 if logarithmic
uniform vec3 up;
uniform vec2 cut;               // heights between which voxels are drawn
uniform vec2 heightRange;
uniform bool hasField;
uniform vec2 fieldRange;
uniform float trailSeconds;
uniform sampler2D colourMap;
uniform vec2 viewport;          // pixels
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

vec3 colourOf(bool isNoise, float height) {
  if (isNoise) return noiseColour;
  if (colourBy == 2) return streamColour;
  if (colourBy == 4) return paint.rgb;
  if (colourBy == 5 && (!hasField || quantities.z < -2e38)) return vec3(160.0 / 255.0); // as where no colour was recorded
  float share = colourBy == 0 ? intensityShare(quantities.x)
    : colourBy == 1 ? (height - heightRange.x) / max(heightRange.y - heightRange.x, 1e-6)
    : colourBy == 3 ? quantities.y / trailSeconds
    : fieldShare(quantities.z);
  return texture(colourMap, vec2(clamp(share, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
}

const float leastPixels = 2.0;

void main() {
  bool isNoise = paint.a > 0.5 || (hasIntensities && quantities.x < threshold);
  place = corner.xy;
  light = 1.0;
  colour = vec3(0.0);
  pixels = 0.0;
  float height = dot(up, (modelMatrix * vec4(centre, 1.0)).xyz);
  if ((isNoise && hidesNoise) || height < cut.x - 0.002 * halfEdge || height > cut.y + 0.002 * halfEdge) {
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0); // all corners of it outside of the view
    return;
  }
  colour = colourOf(isNoise, height);
  vec3 toCamera = -(transpose(mat3(modelViewMatrix)) * modelViewMatrix[3].xyz) - centre;
  float size = isNoise ? 0.6 * halfEdge : halfEdge;
  vec4 middle = projectionMatrix * (modelViewMatrix * vec4(centre, 1.0));
  pixels = projectionMatrix[1][1] * viewport.y * size / max(middle.w, 1e-6);
  size *= max(1.0, leastPixels / max(pixels, 1e-6)); // or far voxels would fall between pixels
  if (corner.z > 2.5) {
    float diameter = max(pixels, 2.5);
    gl_Position = middle + vec4(corner.xy * diameter / viewport * middle.w, 0.0, 0.0);
    return;
  }
  vec3 side = vec3(toCamera.x < 0.0 ? -1.0 : 1.0, toCamera.y < 0.0 ? -1.0 : 1.0, toCamera.z < 0.0 ? -1.0 : 1.0);
  vec3 offset;
  if (corner.z < 0.5) { offset = vec3(side.x, corner.xy); light = side.x > 0.0 ? 0.8 : 0.7; }
  else if (corner.z < 1.5) { offset = vec3(corner.x, side.y, corner.y); light = side.y > 0.0 ? 0.66 : 0.86; }
  else { offset = vec3(corner.xy, side.z); light = side.z > 0.0 ? 1.0 : 0.5; }
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(centre + size * offset, 1.0));
}
`;

export const voxelFragmentShader = /* glsl */ `
precision highp float;
flat in vec3 colour;
flat in float light;
in vec2 place;
in float pixels;
uniform bool isDisc;
out vec4 result;

void main() {
  if (isDisc) {
    float radius = dot(place, place);
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
