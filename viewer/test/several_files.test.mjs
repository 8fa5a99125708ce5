// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Several files that are opened together.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, keyOf, openFiles, openViewer, seek, startBrowser, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { cellRecording, decodedByProgram, frameFile, pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

const recording = cellRecording();

/** The frames of a sensor of the cell in a file of their own. */
function frameFileOf(sensor, name) {
  const path = pathInFolder(name);
  mkdirSync(path.replace(/\/[^/]*$/, ""), { recursive: true });
  pclExt("cut", recording, "-o", path, "--streams", `/cell_sensor_${sensor}`, "--overwrite", "-q");
  return path;
}

const left = frameFileOf(1, "left/frames.pcxi");
const right = frameFileOf(2, "right/frames.pcxi");

function names(viewer) {
  return viewer.ask(() => window.pclExtViewer.streams().map(({ name }) => name));
}

test("each file of frames is a stream with a name of its own, and what is none is named", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [left, right, writtenText("cloud.pcd", "VERSION 0.7\n")]);
  await untilIndexed(viewer);
  assert.deepEqual(await names(viewer), ["frames", "frames (2)"]);
  const notice = await viewer.notice("info").innerText();
  assert.match(notice, /Not all of it is shown.*“cloud\.pcd” is not a recording/s);
  await seek(viewer, 7);
  const decoded = decodedByProgram(recording);
  for (const stream of [0, 1])
    assert.deepEqual(await drawnVoxels(viewer, stream), decoded[stream][7].map(keyOf).sort());
  await viewer.finish();
});

test("of .mcap and .pcxi files those of the recording are shown, and the others are named", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [recording, writtenText("metadata.yaml", "version: 8\n")]);
  await untilIndexed(viewer);
  assert.equal(await viewer.notice("info").count(), 0);
  await openFiles(viewer, [frameFile(), recording]);
  await untilIndexed(viewer);
  assert.deepEqual(await names(viewer), ["/cell_sensor_1", "/cell_sensor_2"]);
  assert.match(await viewer.notice("info").innerText(), /Left out: cell_20\.pcxi/);
  await viewer.finish();
});

test("stamps that begin again in a recording go on, and all frames are reached", async () => {
  const once = readFileSync(frameFile());
  const path = pathInFolder("twice.pcxi");
  writeFileSync(path, Buffer.concat([once, once]));
  const viewer = await openViewer();
  await openFiles(viewer, [path]);
  await untilIndexed(viewer);
  assert.equal(await viewer.ask(() => window.pclExtViewer.moments()), 40);
  assert.match(await viewer.notice("info").innerText(), /Stamps begin again/);
  await seek(viewer, 27);
  const decoded = decodedByProgram(frameFile())[0];
  assert.deepEqual(await drawnVoxels(viewer, 0), decoded[7].map(keyOf).sort());
  await viewer.finish();
});

function writtenText(name, text) {
  const path = pathInFolder(name);
  writeFileSync(path, text);
  return path;
}
