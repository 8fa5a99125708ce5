/** Compares the speed of decoding in WebAssembly with that of native code.
 *
 *     npm run benchmark -- FILE.pcxi ...
 *
 * Each file is one stream, e.g. `pcl_ext demo --sensors 1 -e fast`, and then
 * `pcl_ext cut out/cell.mcap -o fast.pcxi`. Both compute positions and intensities, and take
 * turns; the median of the rounds counts.
 */
import { execFileSync } from "node:child_process";
import { readFile } from "node:fs/promises";

import { Codec } from "./dist/index.js";
import { buildReference } from "./test/reference.mjs";

const rounds = 7;

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

/** Milliseconds a frame, and what was decoded. */
function decodeAll(codec, bytes) {
  const decoder = codec.createDecoder();
  const begin = performance.now();
  let frames = 0;
  let voxels = 0;
  for (let at = 0; at < bytes.length; ++frames) {
    const decoded = decoder.decode(bytes.subarray(at, at + codec.frameSize(bytes.subarray(at, at + 2048))));
    if (!decoded.status.ok) throw new Error(decoded.status.message);
    voxels += decoded.voxels.count;
    at += decoded.bytesRead;
  }
  const time = (performance.now() - begin) / frames;
  decoder.free();
  return { time, frames, voxels };
}

const codec = await Codec.load(await readFile(new URL("dist/codec.wasm", import.meta.url)));
const program = buildReference("-O3");
for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(await readFile(file));
  const times = { wasm: [], native: [] };
  let content = decodeAll(codec, bytes); // compiles
  for (let round = 0; round < rounds; ++round) {
    content = decodeAll(codec, bytes);
    times.wasm.push(content.time);
    times.native.push(Number(execFileSync(program, ["time", file], { encoding: "utf8" })));
  }
  const [wasm, native] = [median(times.wasm), median(times.native)];
  console.log(
    `${file}: ${content.frames} frames of ${Math.round(content.voxels / content.frames)} voxels, ` +
      `wasm ${wasm.toFixed(2)} ms (${Math.round(1000 / wasm)} frames/s), ` +
      `native ${native.toFixed(2)} ms (${Math.round(1000 / native)} frames/s), ` +
      `ratio ${(native / wasm).toFixed(2)}`,
  );
}
