// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import assert from "node:assert/strict";
import { test } from "node:test";

import { Codec } from "../dist/index.js";
import { framesOf, loadCodec, stream, wasm } from "./files.mjs";

const framesOfStream = async (codec, name) => framesOf(codec, await stream(`golden/${name}.pcxi`));

test("bytes that are no frame give a status, and the stream goes on", async () => {
  const codec = await loadCodec();
  const [first, second] = await framesOfStream(codec, "balanced_colours");
  const decoder = codec.createDecoder();
  decoder.decode(first);
  for (let at = 0; at < second.length; ++at) {
    const damaged = second.slice();
    damaged[at] ^= 0xff;
    const { status } = decoder.decode(damaged);
    assert.equal(status.ok, false);
    assert.ok(!["Trap", "OutOfMemory"].includes(status.code), status.message);
  }
  for (const [size, code] of [[0, "EndOfStream"], [1, "NoFrame"], [second.length - 1, "Truncated"]]) {
    const { status, voxels, bytesRead } = decoder.decode(second.subarray(0, size));
    assert.equal(status.code, code);
    assert.equal(voxels, null);
    assert.ok(size === 0 ? bytesRead === 0 : bytesRead > 0 && bytesRead <= size);
  }
  assert.equal(decoder.decode(second).status.code, "Ok");
});

test("a stamp of 0, which a frame has beside its frame_id, is none", async () => {
  const decoder = (await loadCodec()).createDecoder();
  const frame = Buffer.from("UENYSQHOZOohzQEAAACAAZqZmZmZmbk/AAAAAAAAAAAAAAAAAZqZmZmZmam/mpmZmZmZqb+amZmZmZmpvwAAAAAAAAAABGNlbGwBBgCBAAAAEA==", "base64");
  const { status, voxels } = decoder.decode(frame);
  assert.equal(status.code, "Ok");
  assert.deepEqual([voxels.stamp, voxels.frameId], [null, "cell"]);
});

test("decoders of a codec share no state", async () => {
  const codec = await loadCodec();
  const names = ["fast_noise", "balanced_colours", "balanced_moving_sensor", "fast_counts"];
  const alone = new Map();
  for (const name of names) {
    const decoder = codec.createDecoder();
    const frames = await framesOfStream(codec, name);
    alone.set(name, frames.map((frame) => decoder.decode(frame)));
  }
  const decoders = names.map(() => codec.createDecoder());
  const frames = await Promise.all(names.map((name) => framesOfStream(codec, name)));
  const most = Math.max(...frames.map(({ length }) => length));
  for (let i = 0; i < most; ++i)
    for (const [stream, decoder] of decoders.entries())
      if (i < frames[stream].length)
        assert.deepEqual(decoder.decode(frames[stream][i]), alone.get(names[stream])[i]);
  const fresh = codec.createDecoder();
  assert.equal(fresh.decode(frames[0][1]).status.code, "MissingReference");
});

test("results are copies that belong to the caller", async () => {
  const codec = await loadCodec();
  const frames = await framesOfStream(codec, "balanced_noise");
  const decoder = codec.createDecoder();
  const { voxels } = decoder.decode(frames[0], { coded: true });
  const before = structuredClone(voxels);
  decoder.decode(frames[1]);
  assert.deepEqual(voxels, before);
  const buffers = [voxels.positions.buffer, voxels.coded.keys.buffer];
  structuredClone(voxels, { transfer: buffers });
  assert.equal(voxels.positions.length, 0);
  assert.equal(decoder.decode(frames[2]).status.code, "Ok");
});

test("memory does not grow over 10,000 frames", async () => {
  const codec = await loadCodec();
  const names = ["fast_moving_sensor", "balanced_colours", "small_counts"];
  let decoded = 0;
  const decodeAll = async () => {
    for (const name of names) {
      const decoder = codec.createDecoder();
      const filter = codec.createOutlierFilter({ unit: "voxels" });
      for (const frame of await framesOfStream(codec, name)) {
        assert.equal(decoder.decode(frame).status.code, "Ok");
        filter.judge(decoder);
        ++decoded;
      }
      decoder.free();
      filter.free();
    }
  };
  for (let i = 0; i < 3; ++i) await decodeAll();
  const bytes = codec.memoryBytes;
  while (decoded < 10_000) await decodeAll();
  assert.equal(codec.memoryBytes, bytes);
});

test("a description says what decoding finds", async () => {
  const codec = await loadCodec();
  for (const name of ["fast_scales", "balanced_colours", "small_counts", "balanced_companded"]) {
    const decoder = codec.createDecoder();
    for (const frame of await framesOfStream(codec, name)) {
      const { voxels } = decoder.decode(frame);
      const { status, description } = codec.describeFrame(frame);
      assert.equal(status.code, "Ok");
      assert.equal(description.format, "version1");
      assert.equal(description.effort, name.split("_")[0]);
      assert.equal(description.kind, voxels.isIFrame ? "I" : "P");
      assert.equal(description.frameNumber, voxels.frameNumber);
      assert.equal(description.voxels, voxels.count);
      assert.equal(description.bytes, frame.length);
      assert.equal(description.resolution, voxels.isIFrame ? voxels.resolution : null);
      assert.deepEqual(description.grid, voxels.isIFrame ? voxels.grid : null);
      assert.deepEqual(
        description.intensityRange,
        voxels.isIFrame ? voxels.intensityRange : null,
      );
    }
  }
});

test("the size of a frame is known by its beginning", async () => {
  const codec = await loadCodec();
  const [frame] = await framesOfStream(codec, "balanced_colours");
  const header = [...frame.keys()].find((size) => codec.frameSize(frame.subarray(0, size)));
  assert.ok(header > 16 && header < 150);
  for (let size = 0; size <= frame.length; ++size)
    assert.equal(codec.frameSize(frame.subarray(0, size)), size < header ? null : frame.length);
  const shifted = new Uint8Array([1, 2, 3, ...frame]);
  assert.throws(() => codec.frameSize(shifted), {
    name: "CodecError",
    code: "NoFrame",
    bytesToSkip: 3,
  });
});

test("limits and settings outside their ranges are refused by name", async () => {
  const codec = await loadCodec();
  const refuses = (call, name) =>
    assert.throws(call, { code: "InvalidSettings", message: new RegExp(name) });
  for (const name of ["maxFrameBytes", "maxVoxels", "maxPoints", "maxFieldValues"])
    for (const value of [0, -1, 1.5, NaN, 2 ** 32, "4"])
      refuses(() => codec.createDecoder({ [name]: value }), name);
  refuses(() => codec.createOutlierFilter({ unit: "feet" }), "unit");
  refuses(() => codec.createOutlierFilter({ minLogOdds: NaN }), "min_log_odds");
  for (const [unit, setting, value, name] of [
    ["faces", "fullIntensity", 0, "full_intensity"],
    ["rays", "sensorPosition", [0, 0, NaN], "sensor_position"],
    ["rays", "azimuthStep", 0, "azimuth_step"],
    ["rays", "elevationStep", 2, "elevation_step"],
  ]) {
    refuses(() => codec.createOutlierFilter({ unit, [setting]: value }), name);
    refuses(() => codec.createOutlierFilter({ [setting]: value }), "unit automatic does not");
  }
  refuses(() => codec.createOutlierFilter({ unit: "rays", useHistory: true }), "unit rays does");
  const rays = { sensorPosition: [1, 2, 3], azimuthStep: 0.01, elevationStep: 0.01 };
  for (const settings of [
    { useHistory: false, intensitiesAreCounts: true },
    { unit: "faces", useHistory: false, fullIntensity: 100 },
    { unit: "rays", intensitiesAreCounts: true, ...rays },
  ])
    codec.createOutlierFilter({ ...settings, minLogOdds: 1, maxBlocks: 7 }).free();
  refuses(() => codec.createOutlierFilter({ maxBlocks: -1 }), "maxBlocks");
  for (const maximumMemory of [0, 1e6, NaN, 2 ** 33])
    await assert.rejects(loadCodec({ maximumMemory }), { code: "InvalidSettings" });
});

test("limits are those of the decoder", async () => {
  const codec = await loadCodec();
  const [frame] = await framesOfStream(codec, "balanced_colours");
  const decoder = codec.createDecoder({ maxVoxels: 100 });
  assert.equal(decoder.decode(frame).status.code, "LimitExceeded");
  const narrow = codec.createDecoder({ maxFrameBytes: frame.length - 1 });
  assert.equal(narrow.decode(frame).status.code, "LimitExceeded");
  const exact = codec.createDecoder({ maxFrameBytes: frame.length, maxVoxels: 552 });
  assert.equal(exact.decode(frame).status.code, "Ok");
});

test("what was freed, or is of another codec, is refused", async () => {
  const codec = await loadCodec();
  const [frame] = await framesOfStream(codec, "balanced_colours");
  const decoder = codec.createDecoder();
  const filter = codec.createOutlierFilter({ unit: "voxels" });
  assert.equal(filter.judge(decoder).status.code, "NoDecodedFrame");
  decoder.decode(frame);
  const other = (await loadCodec()).createDecoder();
  assert.throws(() => filter.judge(other), { code: "InvalidInput" });
  assert.equal(filter.judge(decoder).isNoise.length, 552);
  filter.reset();
  assert.equal(filter.judge(decoder).isNoise.length, 552);
  decoder.decode(frame.subarray(1));
  assert.equal(filter.judge(decoder).status.code, "NoDecodedFrame");
  decoder.free();
  decoder.free();
  assert.throws(() => decoder.decode(frame), { code: "InvalidInput" });
  assert.throws(() => filter.judge(decoder), { code: "InvalidInput" });
  filter.free();
  filter.free();
  assert.throws(() => filter.judge(decoder), { code: "InvalidInput" });
  assert.throws(() => filter.reset(), { code: "InvalidInput" });
});

test("a codec that is loaded at once decodes as others do", async () => {
  const [frame] = await framesOfStream(await loadCodec(), "balanced_colours");
  const codec = Codec.loadNow(wasm, { maximumMemory: 2 ** 26 });
  assert.equal(codec.createDecoder().decode(frame).voxels.count, 552);
  assert.throws(() => Codec.loadNow(wasm, { maximumMemory: 0 }), { code: "InvalidSettings" });
});

test("bytes that are no module are refused", async () => {
  await assert.rejects(Codec.load(new Uint8Array(8)), WebAssembly.CompileError);
  assert.throws(() => Codec.loadNow(new Uint8Array(8)), WebAssembly.CompileError);
});
