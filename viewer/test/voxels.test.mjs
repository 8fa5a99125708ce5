// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// What is drawn is what the C++ library decodes.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, keyOf, openFiles, openViewer, seek, startBrowser, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { cellRecording, cloudRecording, cubeRecording, decodedByProgram } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

const recording = cellRecording();

async function openCell() {
  const page = await openViewer();
  await openFiles(page, recording);
  await untilIndexed(page);
  return page;
}

test("a frame of more voxels than a decoder takes by default is drawn", async () => {
  const { path, points } = cubeRecording(129);
  assert.ok(points > 2 ** 20);
  const page = await openViewer();
  await openFiles(page, path);
  assert.equal((await page.ask(() => window.pclExtViewer.counts())).drawn, points);
  await page.finish();
});

test("a threshold draws as many voxels of each frame as the program keeps", async () => {
  const page = await openCell();
  for (const threshold of [2, 5]) {
    const kept = decodedByProgram(recording, "--min-intensity", threshold);
    await page.evaluate((value) => window.pclExtViewer.set({ threshold: value }), threshold);
    for (const frame of [0, 7, 19]) {
      await seek(page, frame);
      const { drawn } = await page.ask(() => window.pclExtViewer.counts());
      assert.equal(drawn, kept[0][frame].length + kept[1][frame].length, `threshold ${threshold}, frame ${frame}`);
    }
  }
  await page.finish();
});

test("a seek shows exactly the voxels of the frame, from whatever frame it comes", async () => {
  const decoded = decodedByProgram(recording);
  const page = await openCell();
  assert.equal(await page.ask(() => window.pclExtViewer.moments()), 20);
  for (const frame of [13, 4, 5, 19, 0, 12]) {
    await seek(page, frame);
    for (const stream of [0, 1])
      assert.deepEqual(await drawnVoxels(page, stream), decoded[stream][frame].map(keyOf).sort(), `frame ${frame}`);
  }
  await page.finish();
});

test("the outlier filter keeps the voxels that the program keeps", async () => {
  const kept = decodedByProgram(recording, "--remove-outliers");
  const page = await openCell();
  await page.evaluate(() => window.pclExtViewer.set({ removesOutliers: true }));
  for (let frame = 0; frame < 10; ++frame) {
    await seek(page, frame);
    for (const stream of [0, 1])
      assert.deepEqual(await drawnVoxels(page, stream), kept[stream][frame].map(keyOf).sort(), `frame ${frame}`);
  }
  await page.finish();
});

/** Points "x y z ring" of a turning lidar between walls, before some of which is snow. */
function lidarPoints() {
  const points = [];
  for (let column = 0; column < 720; ++column)
    for (let ring = 0; ring < 16; ++ring) {
      const [azimuth, elevation] = [(column * Math.PI) / 360, ((2 * ring - 15) * Math.PI) / 180];
      const wall = 5 / Math.max(Math.abs(Math.cos(azimuth)), Math.abs(Math.sin(azimuth)));
      const range = (5 * (column + 7 * ring)) % 211 === 0 ? wall / 2 : wall;
      const place = [range * Math.cos(azimuth), range * Math.sin(azimuth), range * Math.tan(elevation)];
      points.push(`${place.map((value) => value.toFixed(4)).join(" ")} ${ring}`);
    }
  return points;
}

test("of a lidar's points in order the outlier filter keeps the voxels that the program keeps", async () => {
  const edge = 0.2;
  const path = cloudRecording("lidar", lidarPoints(), "-r", edge, "--keep-order");
  const voxelsOf = ([points]) => [...new Set(points.map((point) => point.slice(0, 3).map((value) => Math.floor(value / edge)).join()))].sort();
  const [all, kept] = [[], ["--remove-outliers"]].map((options) => voxelsOf(decodedByProgram(path, ...options)[0]));
  assert.ok(kept.length < all.length && kept.length > 0.8 * all.length, `${kept.length} of ${all.length}`);
  const page = await openViewer();
  await page.evaluate(() => window.pclExtViewer.set({ removesOutliers: true }));
  await openFiles(page, path);
  const positions = await page.ask(() => window.pclExtViewer.positions(0));
  const drawn = [];
  for (let i = 0; i < positions.length; i += 3) drawn.push(positions.slice(i, i + 3));
  assert.deepEqual(voxelsOf([drawn]), kept);
  await page.finish();
});

test("noise that is coloured stays in the picture, and streams can be switched off", async () => {
  const page = await openCell();
  await page.evaluate(() => window.pclExtViewer.set({ threshold: 2, noise: "colour" }));
  const coloured = await page.ask(() => window.pclExtViewer.counts());
  assert.equal(coloured.drawn, coloured.all);
  assert.ok(coloured.kept < coloured.all);
  await page.getByLabel("cell_sensor_1").uncheck();
  const one = await page.ask(() => window.pclExtViewer.counts());
  const [, second] = await page.ask(() => window.pclExtViewer.streams());
  assert.equal(one.all, second.voxels);
  await page.finish();
});

test("voxels that were there within the last seconds stay when coloured by time", async () => {
  const page = await openCell();
  await seek(page, 10);
  const { all } = await page.ask(() => window.pclExtViewer.counts());
  await page.evaluate(() => window.pclExtViewer.set({ colourBy: "age" }));
  await page.until(() => window.pclExtViewer.streams().every(({ past }) => past > 0));
  assert.equal((await page.ask(() => window.pclExtViewer.counts())).all, all, "they are no voxels of the frame");
  await page.finish();
});

test("the exported PLY file has the voxels that are drawn", async () => {
  const page = await openCell();
  await page.evaluate(() => window.pclExtViewer.set({ threshold: 3 }));
  await seek(page, 6);
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "PLY" }).click()]);
  assert.equal(download.suggestedFilename(), "cell_000006.ply");
  const bytes = readFileSync(await download.path());
  const end = bytes.indexOf("end_header\n") + 11;
  const header = bytes.subarray(0, end).toString();
  const count = Number(/element vertex (\d+)/.exec(header)[1]);
  assert.equal(bytes.length - end, 18 * count);
  const exported = [[], []];
  for (let i = 0; i < count; ++i) {
    const at = end + 18 * i;
    exported[bytes.readUInt16LE(at + 16)].push(keyOf([0, 4, 8].map((offset) => bytes.readFloatLE(at + offset))));
    assert.ok(bytes.readFloatLE(at + 12) >= 3);
  }
  for (const stream of [0, 1]) assert.deepEqual(exported[stream].sort(), await drawnVoxels(page, stream));
  await page.evaluate(() => window.pclExtViewer.set({ threshold: 1e6 }));
  await page.getByRole("button", { name: "PLY" }).click();
  await page.notice("info").filter({ hasText: "no voxels to save" }).waitFor();
  await page.finish();
});

test("a click on a voxel tells its position, intensity and stream", async () => {
  const page = await openCell();
  await page.evaluate(() => window.pclExtViewer.fit("oblique"));
  const box = await page.locator("canvas.scene").boundingBox();
  const details = page.getByLabel("Selected voxel");
  for (let i = 0; i < 40 && !(await details.isVisible()); ++i)
    await page.mouse.click(box.x + box.width * (0.3 + 0.01 * i), box.y + box.height * (0.35 + 0.006 * i));
  const text = await details.innerText();
  assert.match(text, /Position\n-?\d+\.\d{3}, -?\d+\.\d{3}, -?\d+\.\d{3} m/);
  assert.match(text, /Intensity\n\d+/);
  assert.match(text, /Stream\ncell_sensor_[12]/);
  await page.keyboard.press("Escape");
  assert.equal(await details.isVisible(), false);
  await page.finish();
});

test("points in order are drawn as the voxels that they lie in, and the time line counts points", async () => {
  const page = await openViewer();
  await openFiles(page, cloudRecording("in_order", ["0.2 0 0", "0.3 0 0", "5 0 0"], "-r", 1, "--law", "none", "--keep-order"));
  assert.deepEqual(await drawnVoxels(page, 0), [[0.5, 0.5, 0.5], [5.5, 0.5, 0.5]].map(keyOf));
  const plot = page.locator(".plot-legend");
  await page.until(() => document.querySelector(".plot-scale").textContent !== "");
  assert.match(await plot.innerText(), /\bpoints\b[^]* 3 points$/);
  await page.finish();
});

test("points that are too far away for the grid of voxels are not left out without a word", async () => {
  const page = await openViewer();
  const near = Array.from({ length: 100 }, (_, i) => `${0.17 * i} ${(0.61 * i) % 3} ${(0.013 * i).toFixed(3)}`);
  await openFiles(page, cloudRecording("far_point", [...near, "60000 0 0"], "-r", 0.01, "--law", "none", "--keep-order"));
  assert.equal((await page.ask(() => window.pclExtViewer.counts())).all, 100);
  await page.locator(".stream-note", { hasText: /^1 points? .* left out/ }).waitFor();
  await page.finish();
});
