// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Recordings for the tests: their frames, and what the native codec decodes of them.
import { readFileSync } from "node:fs";

import { framesOf, loadCodec } from "../../codec/test/files.mjs";
import { decodedNatively } from "../../codec/test/reference.mjs";
import { pathInFolder, pclExt } from "../../test/support/fixtures.mjs";

export const codec = await loadCodec();

/** A stream: its frames, which are I-frames, and the voxels of all. */
export function streamOf(path) {
  const frames = framesOf(codec, new Uint8Array(readFileSync(path)));
  const isIFrame = frames.map((frame) => codec.describeFrame(frame).description.kind === "I");
  return { frames, isIFrame, voxels: decodedNatively(path) };
}

/** Streams of sensors of the robot cell, as files of frames; their names tell the options. */
export function cellStreams(name, sensors, frames, ...options) {
  const folder = pathInFolder(name);
  pclExt("demo", "-n", frames, "--sensors", sensors, "-o", folder, "-q", ...options);
  return Array.from({ length: sensors }, (_, i) => {
    const path = pathInFolder(`${name}_${i}.pcxi`);
    pclExt("cut", `${folder}/cell.mcap`, "-o", path, "--streams", `/cell_sensor_${i + 1}`, "-q");
    return path;
  });
}

/** Numbers below a limit, the same in each run. */
export function randomNumbers(seed) {
  let state = seed;
  return (limit) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * limit);
  };
}
