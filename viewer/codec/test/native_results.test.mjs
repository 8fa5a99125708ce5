/** Positions, intensities, colours, numbers of points and noise are those of native code. */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { data, framesOf, loadCodec, stream, streamNames } from "./files.mjs";
import { buildReference } from "./reference.mjs";

const program = buildReference();
const units = ["automatic", "faces", "points", "voxels", "rays"];

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

const dump = (name, unit) =>
  readDump(
    execFileSync(program, ["dump", fileURLToPath(new URL(`${name}.pcxi`, data)), String(unit)], {
      maxBuffer: 2 ** 28,
    }),
  );

const streams = (await streamNames("golden/")).filter((name) => name !== "disorder");
let withNoise = 0;

for (const name of streams)
  test(`same voxels and noise in ${name}`, async () => {
    const codec = await loadCodec();
    const frames = framesOf(codec, await stream(`golden/${name}.pcxi`));
    for (const [number, unit] of units.entries()) {
      const expected = dump(`golden/${name}`, number);
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
