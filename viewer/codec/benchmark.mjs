// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Compares the speed of decoding in WebAssembly with that of native code.
 *
 *     npm run benchmark -- FILE.pcxi ...
 *
 * Each file is one stream, e.g. `pcl_ext demo --sensors 1 -e fast`, and then
 * `pcl_ext cut out/cell.mcap -o fast.pcxi`. Both compute positions and intensities, and take
 * turns. Times are those of the processor, and the best round counts, so that other programs
 * disturb little.
 */
import { execFileSync } from "node:child_process";
import { readFile } from "node:fs/promises";

import { Codec } from "./dist/index.js";
import { buildReference } from "./test/reference.mjs";

const rounds = 9;
const warmUpRounds = 3; // then the engine has compiled it with optimisation

/** Milliseconds of the processor a frame, and what was decoded. */
function decodeAll(codec, bytes) {
  const decoder = codec.createDecoder();
  const begin = process.cpuUsage();
  let frames = 0;
  let voxels = 0;
  for (let at = 0; at < bytes.length; ++frames) {
    const decoded = decoder.decode(bytes.subarray(at));
    if (!decoded.status.ok) throw new Error(decoded.status.message);
    voxels += decoded.voxels.count;
    at += decoded.bytesRead;
  }
  const { user, system } = process.cpuUsage(begin);
  const time = (user + system) / 1000 / frames;
  decoder.free();
  return { time, frames, voxels };
}

const codec = await Codec.load(await readFile(new URL("dist/codec.wasm", import.meta.url)));
const program = buildReference("-O3");
for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(await readFile(file));
  const times = { wasm: [], native: [] };
  let content;
  for (let round = 0; round < warmUpRounds; ++round) decodeAll(codec, bytes);
  for (let round = 0; round < rounds; ++round) {
    content = decodeAll(codec, bytes);
    times.wasm.push(content.time);
    times.native.push(Number(execFileSync(program, ["time", file], { encoding: "utf8" })));
  }
  const [wasm, native] = [Math.min(...times.wasm), Math.min(...times.native)];
  console.log(
    `${file}: ${content.frames} frames of ${Math.round(content.voxels / content.frames)} voxels, ` +
      `wasm ${wasm.toFixed(2)} ms (${Math.round(1000 / wasm)} frames/s), ` +
      `native ${native.toFixed(2)} ms (${Math.round(1000 / native)} frames/s), ` +
      `ratio ${(native / wasm).toFixed(2)}`,
  );
}
