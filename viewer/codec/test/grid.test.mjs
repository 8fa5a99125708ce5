// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Positions of voxels from one of them on. */
import assert from "node:assert/strict";
import { test } from "node:test";

import { localPositions, needsDoubles } from "../dist/index.js";
import { framesOf, loadCodec, stream, streamNames } from "./files.mjs";

test("local positions are those of the frame, from one of its voxels on", async () => {
  const codec = await loadCodec();
  const found = { near: 0, far: 0 };
  for (const name of (await streamNames("golden/")).filter((each) => each !== "disorder")) {
    const decoder = codec.createDecoder();
    for (const frame of framesOf(codec, await stream(`golden/${name}.pcxi`))) {
      const { voxels } = decoder.decode(frame, { coded: true });
      const { origin, positions } = localPositions(voxels);
      const isFar = needsDoubles(voxels.grid);
      assert.equal(positions.length, voxels.positions.length);
      for (const [i, expected] of voxels.positions.entries()) {
        const mostError = isFar ? 2 ** -23 * Math.abs(expected) : voxels.resolution / 8;
        assert.ok(Math.abs(positions[i] + origin[i % 3] - expected) < mostError, `${name}, ${i}`);
      }
      found[isFar ? "far" : "near"] += voxels.count;
    }
    decoder.free();
  }
  assert.ok(found.near > 10_000 && found.far > 100, JSON.stringify(found));
});

test("each level of a key counts, up to those of the largest grid", () => {
  for (const depth of [1, 9, 10, 11, 20, 21]) {
    const highest = 2 ** depth - 1;
    const places = [0, highest, ...Array.from({ length: depth }, (_, level) => 2 ** level)].map(
      (index) => [index, highest - index, (index * 5) & highest],
    );
    const keyOf = (place) =>
      place.reduce((key, index, axis) => {
        for (let level = 0; level < depth; ++level)
          key |= BigInt((index >> level) & 1) << BigInt(3 * level + 2 - axis);
        return key;
      }, 0n);
    const grid = { resolution: 0.5, origin: [0.25, 0, 1e6], firstIndex: [7, -8, 9], depth };
    const coded = { keys: BigUint64Array.from(places, keyOf), symbols: null };
    const { origin, positions } = localPositions({ count: places.length, coded, grid });
    const decoded = [...positions].map((position, i) => position + origin[i % 3]);
    const expected = places.flatMap((place) =>
      place.map((index, axis) => 0.5 * (grid.firstIndex[axis] + index + 0.5) + grid.origin[axis]),
    );
    assert.deepEqual(decoded, expected);
  }
});

test("without keys there are none, and of no voxels neither", async () => {
  const codec = await loadCodec();
  const [frame] = framesOf(codec, await stream("golden/balanced_colours.pcxi"));
  const { voxels } = codec.createDecoder().decode(frame);
  assert.throws(() => localPositions(voxels), { code: "InvalidInput" });
  const coded = { keys: new BigUint64Array(), symbols: null };
  assert.deepEqual(localPositions({ ...voxels, count: 0, coded }), { origin: [0, 0, 0], positions: new Float32Array() });
});
