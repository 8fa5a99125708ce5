// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Recordings that the program pcl_ext makes, and what it decodes of them.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const viewer = resolve(dirname(fileURLToPath(import.meta.url)), "../..");
export const pagePath = process.env.PCL_EXT_VIEWER_PAGE ?? join(viewer, "dist", "viewer.html");
const program = process.env.PCL_EXT_PROGRAM ?? resolve(viewer, "../build/tools/bin/pcl_ext");

for (const [what, path] of [["the page, by viewer/build.sh", pagePath], ["the program, or set PCL_EXT_PROGRAM", program]])
  if (!existsSync(path)) throw new Error(`${path} is missing: build ${what}`);

const folder = mkdtempSync(join(tmpdir(), "pcl_ext_viewer_"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

export function pclExt(...args) {
  return execFileSync(program, args.map(String), { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

export function pathInFolder(name) {
  return join(folder, name);
}

/** The robot cell's recording: cell.mcap, made once for each number of frames and sensors. */
export function cellRecording(frames = 20, sensors = 2) {
  const made = join(folder, `cell_${frames}_${sensors}`);
  if (!existsSync(made)) pclExt("demo", "-n", frames, "--sensors", sensors, "-o", made, "-q");
  return join(made, "cell.mcap");
}

/** The same as a file of frames, of the first sensor. */
export function frameFile(frames = 20) {
  const path = join(folder, `cell_${frames}.pcxi`);
  if (!existsSync(path)) pclExt("cut", cellRecording(frames), "-o", path, "--streams", "/cell_sensor_1", "-q");
  return path;
}

/** A recording of one cloud: points as texts "x y z", or "x y z ring". */
export function cloudRecording(name, points, ...options) {
  const cloud = pathInFolder(`${name}.pcd`);
  const fields = points[0].split(" ").length === 3
    ? "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    : "VERSION .7\nFIELDS x y z ring\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\n";
  writeFileSync(cloud, `${fields}WIDTH ${points.length}\nHEIGHT 1\nPOINTS ${points.length}\nDATA ascii\n${points.join("\n")}\n`);
  const path = pathInFolder(`${name}.mcap`);
  pclExt("encode", cloud, "-o", path, "--overwrite", "-q", ...options);
  return path;
}

/** A recording of one frame, a cube of voxels of 4 cm, about half of which have a point.
 * @returns its path and the number of points
 */
export function cubeRecording(width) {
  const points = [];
  for (let i = 0, random = 1; i < width ** 3; ++i) {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    if (random >>> 31) points.push([i % width, Math.floor(i / width) % width, Math.floor(i / width ** 2)]);
  }
  const header = ["VERSION .7", "FIELDS x y z", "SIZE 4 4 4", "TYPE F F F", "COUNT 1 1 1", `WIDTH ${points.length}`,
    "HEIGHT 1", `POINTS ${points.length}`, "DATA binary", ""].join("\n");
  const coordinates = Float32Array.from(points.flat(), (index) => 0.04 * (index + 0.5));
  const cloud = join(folder, `cube_${width}.pcd`);
  writeFileSync(cloud, Buffer.concat([Buffer.from(header), Buffer.from(coordinates.buffer)]));
  const path = join(folder, `cube_${width}.pcxi`);
  pclExt("encode", cloud, "-o", path, "-r", 0.04, "-e", "fast", "-q");
  return { path, points: points.length };
}

/** Points of an ASCII PCD file. */
function readPcd(path) {
  const lines = readFileSync(path, "utf8").trim().split("\n");
  const begin = lines.findIndex((line) => line.startsWith("DATA")) + 1;
  return lines.slice(begin).map((line) => line.split(" ").map(Number));
}

/** What the program decodes: for each stream the points of each frame, [x, y, z, intensity]. */
export function decodedByProgram(recording, ...options) {
  const output = mkdtempSync(join(folder, "decoded_"));
  pclExt("decode", recording, "-o", output, "--pcd", "ascii", "--overwrite", "-q", ...options);
  const streams = readdirSync(output, { withFileTypes: true }).filter((entry) => entry.isDirectory());
  const framesOf = (path) => readdirSync(path).filter((name) => name.endsWith(".pcd")).sort()
    .map((name) => readPcd(join(path, name)));
  return streams.length > 0
    ? streams.map(({ name }) => name).sort().map((name) => framesOf(join(output, name)))
    : [framesOf(output)];
}
