// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The invalid streams of test/data/invalid are refused as in C++: the expectations are the
 * table of test/stream/test_invalid_files.cpp. */
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

import { data, framesOf, loadCodec, stream, streamNames } from "./files.mjs";

const source = await readFile(new URL("../stream/test_invalid_files.cpp", data), "utf8");
const expected = [
  ...source.matchAll(/\{"(\w+)",\s*CompressionCode::(\w+),\s*"([^"]+)"\}/g),
].map(([, name, code, message]) => ({ name, code, message }));

test("the table covers the folder", async () => {
  const names = expected.map(({ name }) => name);
  assert.deepEqual(names.sort(), (await streamNames("invalid/")).sort());
});

for (const { name, code, message } of expected)
  test(`invalid stream ${name}`, async () => {
    const codec = await loadCodec();
    const [good] = framesOf(codec, await stream("golden/fast_noise.pcxi"));
    const decoder = codec.createDecoder();
    const { status, voxels } = decoder.decode(await stream(`invalid/${name}.pcxi`));
    assert.equal(status.code, code);
    assert.ok(status.message.includes(message), status.message);
    assert.equal(status.ok, false);
    assert.equal(voxels, null);
    assert.equal(decoder.decode(good).status.code, "Ok");
  });
