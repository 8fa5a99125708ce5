// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Damaged recordings: what can be read is shown, with where it broke; a wrong cloud never.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, keyOf, openFiles, seek, startViewer, stopViewer, untilIndexed, viewer as page } from "./support/browser.mjs";
import { recordsOf, rewritten, withFlippedByte } from "./support/changed_recordings.mjs";
import { cellRecording, decodedByProgram, frameFile, pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startViewer);
after(stopViewer);

const recording = cellRecording();

/** Opens a file with some bytes, and returns its path. */
async function openBytes(name, bytes) {
  const path = pathInFolder(name);
  writeFileSync(path, bytes);
  await openFiles(page, path);
  await untilIndexed(page);
  return path;
}

/** Frames that the program finds, of each stream. */
function framesByProgram(path) {
  try {
    return JSON.parse(pclExt("info", "--json", path)).streams.map(({ frames }) => frames);
  } catch (error) {
    return JSON.parse(error.stdout).streams.map(({ frames }) => frames); // exit status 1 tells of damage
  }
}

function firstChunkOf(bytes) {
  return recordsOf(bytes).find(({ opcode }) => opcode === 6).at;
}

for (const share of [0.35, 0.8, 0.995])
  test(`a file that ends after ${100 * share} % shows as many frames as the program finds`, async () => {
    const bytes = readFileSync(recording);
    const path = await openBytes(`cut_${share}.mcap`, bytes.subarray(0, Math.floor(share * bytes.length)));
    const frames = framesByProgram(path);
    assert.equal(await page.ask(() => window.pclExtViewer.moments()), Math.max(...frames));
    assert.match(await page.notice("warning").innerText(), /byte \d+: the file ends within|not complete/);
    const stream = frames.indexOf(Math.max(...frames));
    const last = frames[stream] - 1;
    await seek(page, last);
    const { name } = (await page.ask(() => window.pclExtViewer.streams()))[stream];
    const decoded = decodedByProgram(recording, "--streams", name)[0];
    assert.deepEqual(await drawnVoxels(page, stream), decoded[last].map(keyOf).sort());
  });

test("a file with compressed chunks that ends early shows the whole frames of its last chunk", async () => {
  for (const compression of ["lz4", "zstd"]) {
    const bytes = await rewritten(recording, { compression });
    const path = await openBytes(`cut_${compression}.mcap`, bytes.subarray(0, 260_000));
    const frames = framesByProgram(path);
    assert.ok(Math.max(...frames) > 12);
    assert.equal(await page.ask(() => window.pclExtViewer.moments()), Math.max(...frames), compression);
  }
});

test("a frame that is damaged within is named, also where a later one was asked for", async () => {
  const path = frameFile();
  const bytes = readFileSync(path);
  const [, , , , fifth] = [...bytes.toString("latin1").matchAll(/PCXI/g)].map(({ index }) => index);
  await openBytes("within.pcxi", withFlippedByte(bytes, fifth + 1000));
  await seek(page, 12);
  const [stream] = await page.ask(() => window.pclExtViewer.streams());
  assert.equal(stream.voxels, 0);
  const [place] = await page.ask(() => window.pclExtViewer.damage());
  assert.match(place, /^within, frame 5: /);
});

test("a byte that has changed in a chunk loses that chunk, and it is said where", async () => {
  const bytes = readFileSync(recording);
  const path = await openBytes("flipped.mcap", withFlippedByte(bytes, Math.floor(0.1 * bytes.length)));
  const [place] = await page.ask(() => window.pclExtViewer.damage());
  assert.match(place, /flipped\.mcap, byte \d+: a chunk is damaged/);
  assert.match(await page.notice("warning").innerText(), /The recording is damaged/);
  const found = framesByProgram(path);
  const streams = await page.ask(() => window.pclExtViewer.streams());
  assert.equal(streams.length, found.length);
  // Of the streams whose chunk is lost nothing is drawn before the next I-frame.
  const decoded = decodedByProgram(recording);
  await seek(page, await page.ask(() => window.pclExtViewer.moments() - 1));
  for (const [i, { problem, number, name }] of (await page.ask(() => window.pclExtViewer.streams())).entries()) {
    const voxels = await drawnVoxels(page, i);
    if (problem || number === null) assert.deepEqual(voxels, []);
    else assert.deepEqual(voxels, decoded[name.endsWith("1") ? 0 : 1][number].map(keyOf).sort());
  }
});

/** Waits until the time line, which is drawn some time after frames have come, is red at just some of these shares of
 * its width. */
function untilRed(page, shares, red) {
  return page.until(({ wanted, expected }) => {
    const canvas = document.querySelector(".track canvas");
    const colourAt = (context, x, y) => [...context.getImageData(x, y, 1, 1).data].join();
    const sample = new OffscreenCanvas(1, 1).getContext("2d");
    sample.fillStyle = getComputedStyle(document.querySelector(".timeline")).getPropertyValue("--danger");
    sample.fillRect(0, 0, 1, 1);
    return wanted.every((share) => expected.includes(share) ===
      (colourAt(canvas.getContext("2d"), Math.round(share * canvas.width), canvas.height - 2) === colourAt(sample, 0, 0)));
  }, { wanted: shares, expected: red });
}

test("frames of a damaged first chunk are counted and red, and those after it keep times and numbers", async () => {
  pclExt("demo", "-n", 30, "--sensors", 1, "--i-frame-rate", 10, "-o", pathInFolder("ten"), "-q");
  const path = pathInFolder("ten/cell.mcap");
  const bytes = readFileSync(path);
  const decoded = decodedByProgram(path)[0];
  // The chunk has the description of the channel, and the I-frame of the next ten frames.
  const compressed = await rewritten(path, { compression: "lz4", chunkSize: 100_000 });
  for (const [damage, damaged] of Object.entries({
    "a byte": withFlippedByte(bytes, firstChunkOf(bytes) + 1000),
    "its length": withFlippedByte(bytes, firstChunkOf(bytes) + 7),
    "with the channel": withFlippedByte(compressed, firstChunkOf(compressed) + 1000),
  })) {
    writeFileSync(pathInFolder("first_chunk.mcap"), damaged);
    await page.setInputFiles("input[type=file]", pathInFolder("first_chunk.mcap"));
    await page.until(() => !window.pclExtViewer.state().isOpening);
    await untilIndexed(page);
    assert.equal(await page.ask(() => window.pclExtViewer.moments()), 30, damage);
    await page.locator(".times", { hasText: "/ 1.45 s" }).waitFor();
    await untilRed(page, [0.1, 0.95], [0.1]);
    await seek(page, 3);
    const [{ problem }] = await page.ask(() => window.pclExtViewer.streams());
    assert.equal(problem, "the part of the file that had this frame is damaged", damage);
    await seek(page, 29);
    assert.deepEqual(await drawnVoxels(page, 0), decoded[29].map(keyOf).sort(), damage);
  }
});

test("a recording whose chunks are all damaged is refused", async () => {
  let bytes = readFileSync(recording);
  for (const { at, opcode } of recordsOf(bytes)) if (opcode === 6) bytes = withFlippedByte(bytes, at + 1000);
  const path = pathInFolder("all_chunks.mcap");
  writeFileSync(path, bytes);
  await page.setInputFiles("input[type=file]", path);
  assert.match(await page.notice("error").innerText(), /None of its frames can be read/);
});

test("a frame that has changed in a file of frames is lost with those that need it, and nothing else", async () => {
  const path = pathInFolder("two_i_frames.mcap");
  pclExt("demo", "-n", 20, "--sensors", 1, "--i-frame-rate", 8, "-o", pathInFolder("eight"), "-q");
  pclExt("cut", pathInFolder("eight/cell.mcap"), "-o", pathInFolder("eight.pcxi"), "--overwrite", "-q");
  const bytes = readFileSync(pathInFolder("eight.pcxi"));
  const begins = [];
  for (let at = bytes.indexOf("PCXI"); at >= 0; at = bytes.indexOf("PCXI", at + 1)) begins.push(at);
  assert.equal(begins.length, 20, path);
  const lost = 5;
  await openBytes("eight_flipped.pcxi", withFlippedByte(bytes, begins[lost] + 2000));
  const decoded = decodedByProgram(pathInFolder("eight.pcxi"))[0];
  const shown = [];
  for (let frame = 0; frame < 20; ++frame) {
    await seek(page, frame);
    const [{ problem }] = await page.ask(() => window.pclExtViewer.streams());
    const voxels = await drawnVoxels(page, 0);
    if (problem) assert.deepEqual(voxels, [], `frame ${frame}: ${problem}`);
    else assert.deepEqual(voxels, decoded[frame].map(keyOf).sort(), `frame ${frame}`);
    shown.push(problem === null);
  }
  assert.deepEqual(shown, shown.map((_, i) => i < lost || i >= 8));
  await seek(page, 6);
  await page.locator(".stream-note", { hasText: "Not shown: " }).waitFor();
});

test("bytes between frames are skipped, and it is said how many", async () => {
  const bytes = readFileSync(frameFile());
  const second = bytes.indexOf("PCXI", 4);
  await openBytes("gap.pcxi",
    Buffer.concat([bytes.subarray(0, second), Buffer.alloc(1234, 7), bytes.subarray(second)]));
  assert.equal(await page.ask(() => window.pclExtViewer.moments()), 20);
  const [place] = await page.ask(() => window.pclExtViewer.damage());
  assert.match(place, new RegExp(`byte ${second}: 1234 bytes that are no frame`));
});

test("a file of frames that ends early shows all whole frames", async () => {
  const bytes = readFileSync(frameFile());
  const last = bytes.lastIndexOf("PCXI");
  await openBytes("cut.pcxi", bytes.subarray(0, last + 300));
  assert.equal(await page.ask(() => window.pclExtViewer.moments()), 19);
  assert.match((await page.ask(() => window.pclExtViewer.damage()))[0], new RegExp(`byte ${last}: the file ends within`));
});
