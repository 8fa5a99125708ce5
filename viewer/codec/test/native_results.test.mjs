// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Positions, intensities, colours, numbers of points and noise are those of native code. */
import assert from "node:assert/strict";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { data, framesOf, loadCodec, stream, streamNames } from "./files.mjs";
import { decodedNatively } from "./reference.mjs";

const units = ["automatic", "faces", "points", "voxels", "rays"];

const streams = (await streamNames("golden/")).filter((name) => name !== "disorder");
let withNoise = 0;

for (const name of streams)
  test(`same voxels and noise in ${name}`, async () => {
    const codec = await loadCodec();
    const path = fileURLToPath(new URL(`golden/${name}.pcxi`, data));
    const frames = framesOf(codec, await stream(`golden/${name}.pcxi`));
    for (const [number, unit] of units.entries()) {
      const expected = decodedNatively(path, number);
      assert.equal(frames.length, expected.length);
      const decoder = codec.createDecoder();
      const filter = codec.createOutlierFilter({ unit });
      for (const [i, { noise, ...voxels }] of expected.entries()) {
        const { count, positions, intensities, colours, pointCounts } =
          decoder.decode(frames[i]).voxels;
        assert.deepEqual({ count, positions, intensities, colours, pointCounts }, voxels);
        const { status, isNoise } = filter.judge(decoder);
        const wasJudged = count === 0 || noise[0] !== 2;
        if (count > 0) assert.equal(status.ok, wasJudged, status.message);
        if (status.ok) assert.deepEqual(isNoise, noise);
        if (wasJudged && noise.includes(1) && noise.includes(0)) ++withNoise;
      }
      decoder.free();
      filter.free();
    }
  });

test("there is noise in these streams", () => assert.ok(withNoise > 100, `${withNoise} frames`));
