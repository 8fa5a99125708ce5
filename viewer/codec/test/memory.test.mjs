// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Where memory runs out, or the module fails, there is a status, and the codec goes on. */
import assert from "node:assert/strict";
import { test } from "node:test";

import { framesOf, loadCodec, stream } from "./files.mjs";

const pageSize = 65536;
const least = 32 * pageSize;

const balanced = async (codec) => framesOf(codec, await stream("golden/balanced_colours.pcxi"));

/** An allocation that no memory is enough for. */
const failAllocation = (codec) => codec.call((instance) => instance.exports.allocate(2 ** 31));

test("a frame that asks for much memory under a small maximum", async () => {
  const greedy = await stream("invalid/voxels_out_of_nothing.pcxi"); // takes 25 MB
  const found = new Set();
  // Each maximum makes another allocation fail.
  for (let pages = 32; pages < 480; pages += 7) {
    const codec = await loadCodec({ maximumMemory: pages * pageSize });
    const { status, voxels } = codec.createDecoder().decode(greedy);
    found.add(status.code);
    assert.equal(voxels, null);
    assert.ok(codec.memoryBytes <= pages * pageSize);
    if (status.code === "OutOfMemory") {
      assert.match(status.message, /^out of memory; .*next I-frames$/);
      assert.equal(codec.memoryBytes, 0);
    }
    const [frame] = framesOf(codec, await stream("golden/fast_noise.pcxi"));
    assert.equal(codec.createDecoder().decode(frame).status.code, "Ok");
  }
  assert.deepEqual([...found].sort(), ["Corrupt", "OutOfMemory"]);
});

test("more bytes than there is memory", async () => {
  const codec = await loadCodec({ maximumMemory: least });
  const bytes = new Uint8Array(least);
  const decoder = codec.createDecoder();
  assert.equal(decoder.decode(bytes).status.code, "OutOfMemory");
  assert.equal(decoder.decode(bytes.subarray(0, 1000)).status.code, "NoFrame");
  assert.throws(() => codec.frameSize(bytes), { code: "OutOfMemory", bytesToSkip: 1 });
  assert.equal(codec.describeFrame(bytes).status.code, "NoFrame");
});

test("more decoders than there is memory for", async () => {
  const codec = await loadCodec({ maximumMemory: 8 * least });
  const [frame] = await balanced(codec);
  const decoders = [];
  const codes = new Set();
  for (let i = 0; i < 60; ++i) {
    decoders.push(codec.createDecoder());
    codes.add(decoders[i].decode(frame).status.code);
  }
  assert.deepEqual([...codes], ["Ok", "OutOfMemory"]);
  for (const decoder of decoders) decoder.free();
  assert.equal(codec.createDecoder().decode(frame).status.code, "Ok");
});

test("after a failed allocation streams go on with their next I-frames", async () => {
  const codec = await loadCodec();
  const frames = await balanced(codec);
  const isIFrame = frames.map((frame) => codec.describeFrame(frame).description.kind === "I");
  const next = isIFrame.indexOf(true, 1);
  assert.ok(next > 3);
  const decoders = [codec.createDecoder(), codec.createDecoder()];
  const filter = codec.createOutlierFilter({ unit: "voxels" });
  const expected = frames.map((frame) => decoders[1].decode(frame).voxels);
  for (const frame of frames.slice(0, 2)) decoders[0].decode(frame);
  assert.equal(filter.judge(decoders[0]).status.ok, true);

  assert.equal(failAllocation(codec).failure.code, "OutOfMemory");
  assert.equal(filter.judge(decoders[0]).status.code, "NoDecodedFrame");
  for (const frame of frames.slice(2, next))
    for (const decoder of decoders) {
      assert.equal(decoder.decode(frame).status.code, "MissingReference");
      assert.equal(filter.judge(decoder).status.code, "NoDecodedFrame");
    }
  for (let i = next; i < frames.length; ++i)
    for (const decoder of decoders) assert.deepEqual(decoder.decode(frames[i]).voxels, expected[i]);
  assert.equal(filter.judge(decoders[0]).isNoise.length, expected.at(-1).count);
});

test("what was made before a failure can be freed and reset after it", async () => {
  const codec = await loadCodec();
  const [frame, next] = await balanced(codec);
  const [decoder, other] = [codec.createDecoder(), codec.createDecoder()];
  const filter = codec.createOutlierFilter({ unit: "voxels" });
  decoder.decode(frame);
  filter.judge(decoder);
  failAllocation(codec);
  other.decode(frame); // lies where the first decoder was
  decoder.free();
  filter.reset();
  filter.free();
  assert.equal(other.decode(next).status.code, "Ok");
});

test("another failure of the module has a name of its own", async () => {
  const codec = await loadCodec();
  const decoder = codec.createDecoder();
  const failed = codec.call(() => {
    throw new WebAssembly.RuntimeError("unreachable");
  });
  assert.equal(failed.failure.code, "Trap");
  assert.match(failed.failure.message, /unreachable/);
  const [frame] = await balanced(codec);
  assert.equal(decoder.decode(frame).status.code, "Ok");
});

test("a browser that makes no instance at once gets one a little later", async () => {
  const codec = await loadCodec();
  const [frame] = await balanced(codec);
  const decoder = codec.createDecoder();
  const { Instance } = WebAssembly;
  WebAssembly.Instance = class {
    constructor() {
      throw new RangeError("WebAssembly.Instance is disallowed on the main thread");
    }
  };
  try {
    failAllocation(codec);
    assert.equal(decoder.decode(frame).status.code, "OutOfMemory");
    assert.equal(decoder.decode(frame).status.code, "OutOfMemory");
    let code;
    do {
      await new Promise((resolve) => setTimeout(resolve, 10));
      ({ code } = decoder.decode(frame).status);
    } while (code === "OutOfMemory");
    assert.equal(code, "Ok");
  } finally {
    WebAssembly.Instance = Instance;
  }
});
