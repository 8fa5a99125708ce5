// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The native codec as a program, see reference.cpp. */
import { execFileSync } from "node:child_process";
import { mkdirSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import path from "node:path";

const root = fileURLToPath(new URL("../../../", import.meta.url));

const folders = ["bytes", "voxels", "voxelizing", "codec", "rate", "stream", "outliers"];

/** The library's files of a kind, relative to the root. */
const filesOf = (folder, extension) =>
  readdirSync(path.join(root, folder), { recursive: true })
    .filter((name) => name.endsWith(extension))
    .map((name) => path.join(folder, name))
    .sort();

/** Builds the program, unless it is newer than all sources.
 * @param optimisation "-O1" for tests, "-O3" for benchmarks
 * @returns its path
 */
export function buildReference(optimisation = "-O1") {
  const out = path.join(root, "viewer/codec/dist/native");
  mkdirSync(out, { recursive: true });
  const program = path.join(out, `reference${optimisation}`);
  const sources = folders.flatMap((folder) => filesOf(`src/${folder}`, ".cpp"));
  sources.push("viewer/codec/test/reference.cpp");
  const headers = [...filesOf("src", ".h"), ...filesOf("include", ".h")];
  const time = (file) => statSync(file, { throwIfNoEntry: false })?.mtimeMs ?? 0;
  const newest = Math.max(...[...sources, ...headers].map((file) => time(path.join(root, file))));
  if (time(program) > newest) return program;
  const unit = `${program}.cpp`;
  // Files with other instructions are compiled by themselves, see src/simd/lanes_target.h.
  const isAlone = (file) => file.endsWith("_avx2.cpp");
  const included = sources.filter((file) => !isAlone(file));
  writeFileSync(unit, included.map((file) => `#include "${file}"\n`).join(""));
  const flags = `-std=c++17 -DNDEBUG -w -I. -Isrc -Iinclude -I/usr/include/eigen3`.split(" ");
  execFileSync("g++", [optimisation, ...flags, unit, ...sources.filter(isAlone), "-lz", "-o", program], {
    cwd: root,
    stdio: "inherit",
  });
  return program;
}

/** Reads what the program wrote. */
function readDump(bytes) {
  let at = 0;
  const take = (ArrayT, count) => {
    const size = count * ArrayT.BYTES_PER_ELEMENT;
    const values = new ArrayT(bytes.buffer.slice(bytes.byteOffset + at, bytes.byteOffset + at + size));
    at += size;
    return values;
  };
  const frames = [];
  while (at < bytes.length) {
    const [count, hasIntensities, hasColours, hasPointCounts] = take(Uint32Array, 4);
    frames.push({
      count,
      positions: take(Float32Array, 3 * count),
      intensities: hasIntensities ? take(Float32Array, count) : null,
      colours: hasColours ? take(Uint8Array, 3 * count) : null,
      pointCounts: hasPointCounts ? take(Uint32Array, count) : null,
      noise: take(Uint8Array, count),
    });
  }
  return frames;
}

let program = null;

/** What the native codec decodes of a file of frames.
 * @param unit number of the DensityUnit by which noise is judged
 */
export function decodedNatively(path, unit = 0) {
  program ??= buildReference();
  return readDump(execFileSync(program, ["dump", path, String(unit)], { maxBuffer: 2 ** 30 }));
}
