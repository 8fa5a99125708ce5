// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The golden streams decode to the voxels of their checksums, see
 * test/stream/test_golden_streams.cpp. */
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

import { data, loadCodec, stream, streamNames } from "./files.mjs";

/** FNV-1a with 64 bits over 64-bit numbers, in 32-bit halves, as BigInt takes minutes. */
class Checksum {
  #low = 0x84222325;
  #high = 0xcbf29ce4;

  add(number) {
    this.addHalves(number >>> 0, 0);
  }

  addHalves(low, high) {
    for (const half of [low, high])
      for (let shift = 0; shift < 32; shift += 8) this.#addByte((half >>> shift) & 0xff);
  }

  #addByte(byte) {
    // times 2^40 + 0x1b3
    const low = (this.#low ^ byte) >>> 0;
    const product = low * 0x1b3; // below 2^53
    this.#high =
      (Math.imul(this.#high, 0x1b3) + Math.floor(product / 2 ** 32) + (low << 8)) >>> 0;
    this.#low = product % 2 ** 32;
  }

  toString() {
    const hex = (half) => half.toString(16).padStart(8, "0");
    return hex(this.#high) + hex(this.#low);
  }
}

/** Number that a level of a companded scale stands for, from its intensity. */
const numberOf = (voxels, i) =>
  Math.round((voxels.intensities[i] - voxels.intensityRange.min) / voxels.intensityRange.step);

function checksumOf(voxels, colourBits) {
  const checksum = new Checksum();
  const { grid, coded, intensityRange: range, colours, pointCounts } = voxels;
  for (const index of grid.firstIndex) checksum.add(index);
  const parameters = [grid.depth, range?.bits ?? 0, range?.compandedRange ?? 0, voxels.count];
  for (const number of parameters) checksum.add(number);
  const keys = new Uint32Array(coded.keys.buffer);
  const highest = 2 ** colourBits - 1;
  for (let i = 0; i < voxels.count; ++i) {
    checksum.addHalves(keys[2 * i], keys[2 * i + 1]);
    if (range) checksum.add(coded.symbols[i]);
    if (range?.compandedRange) checksum.add(numberOf(voxels, i));
    if (colours)
      for (const channel of colours.subarray(3 * i, 3 * i + 3))
        checksum.add(Math.round((channel * highest) / 255));
    if (pointCounts) checksum.add(pointCounts[i]);
  }
  return checksum.toString();
}

/** What checksums.txt has of the frames of a stream. If it has checksums of points, it has
 * none of voxels: the number of points stands for them. */
function linesOf(codec, bytes, hasPoints) {
  const decoder = codec.createDecoder();
  const lines = [];
  let colourBits = 0;
  let disorder = 0; // bytes that were skipped, and frames that were refused
  for (let at = 0; at < bytes.length; ) {
    const { status, voxels, bytesRead } = decoder.decode(bytes.subarray(at), { coded: true });
    const frame = bytes.subarray(at + bytesRead - (voxels?.bytes ?? 0), at + bytesRead);
    at += bytesRead;
    disorder += voxels?.skippedBytes ?? 1;
    if (!status.ok) continue;
    const { description } = codec.describeFrame(frame);
    assert.equal(description.bytes, voxels.bytes);
    assert.equal(description.hasPointsInOrder, hasPoints);
    if (voxels.isIFrame) colourBits = description.colourBits;
    const stamp = voxels.stamp === null ? "-" : `${voxels.stamp} '${voxels.frameId ?? ""}'`;
    const kind = voxels.isIFrame ? "I" : "P";
    const content = hasPoints
      ? description.points
      : `${voxels.count} ${checksumOf(voxels, colourBits)}`;
    lines.push(`${kind} ${content} ${stamp}`);
  }
  decoder.free();
  return { lines, disorder };
}

const expected = new Map();
for (const line of (await readFile(new URL("golden/checksums.txt", data), "utf8")).split("\n")) {
  const [name, ...rest] = line.split(" ");
  // JavaScript gets neither the numbers of fields, nor points, nor layouts of messages.
  const known = rest.join(" ").replace(/ (fields|layout) [0-9a-f]{16}/g, "");
  const ofPoints = known.replace(/^(. \d+) [0-9a-f]{16} (.*) points [0-9a-f]{16}$/, "$1 $2");
  const golden = expected.get(name) ?? { hasPoints: ofPoints !== known, lines: [] };
  golden.lines.push(ofPoints);
  if (name) expected.set(name, golden);
}

test("checksums.txt names all golden streams", async () => {
  assert.deepEqual([...expected.keys()].sort(), (await streamNames("golden/")).sort());
});

for (const [name, { hasPoints, lines }] of expected)
  test(`golden stream ${name}`, async () => {
    const found = linesOf(await loadCodec(), await stream(`golden/${name}.pcxi`), hasPoints);
    assert.deepEqual(found.lines, lines);
    assert.equal(found.disorder > 0, name === "disorder");
  });
