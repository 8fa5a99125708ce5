// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// What is left out of the scene by its height.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { openFiles, openViewer, startBrowser, stillPicture, stopBrowser, untilAllDrawn, untilIndexed } from "./support/browser.mjs";
import { cellRecording } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

async function openCell() {
  const viewer = await openViewer();
  await openFiles(viewer, [cellRecording()]);
  await untilIndexed(viewer);
  await untilAllDrawn(viewer, 2);
  return viewer;
}

const set = (viewer, values) => viewer.evaluate((state) => window.pclExtViewer.set(state), values);
const drawn = async (viewer) => (await viewer.ask(() => window.pclExtViewer.counts())).drawn;

/** Places of all voxels, of which none is noise. */
async function places(viewer) {
  const flat = await viewer.ask(() => [0, 1].flatMap((stream) => window.pclExtViewer.positions(stream)));
  return Array.from({ length: flat.length / 3 }, (_, i) => flat.slice(3 * i, 3 * i + 3));
}

async function shoot(viewer) {
  return stillPicture(viewer, { clip: await viewer.locator("canvas.scene").boundingBox() });
}

test("voxels above and below two heights are neither drawn nor counted", async () => {
  const viewer = await openCell();
  const all = await places(viewer);
  assert.equal(await drawn(viewer), all.length);
  for (const [cutBelow, cutAbove] of [[-Infinity, 1.01], [0.51, Infinity], [0.51, 1.01]]) {
    await set(viewer, { cutBelow, cutAbove });
    const expected = all.filter(([, , z]) => z >= cutBelow && z <= cutAbove).length;
    assert.ok(expected > 100 && expected < all.length - 100);
    assert.equal(await drawn(viewer), expected);
  }
  await set(viewer, { up: "-y" });
  await set(viewer, { cutBelow: -4.01, cutAbove: -2.01 });
  assert.equal(await drawn(viewer), all.filter(([, y]) => y >= 2.01 && y <= 4.01).length);
  await viewer.finish();
});

test("the picture has what is drawn", async () => {
  const viewer = await openCell();
  await viewer.addStyleTag({ content: ".status { opacity: 0 }" });
  const whole = await shoot(viewer);
  await set(viewer, { cutAbove: 1.01 });
  const cut = await shoot(viewer);
  await set(viewer, { cutAbove: -100 });
  await viewer.locator(".status", { hasText: "cut off, by their heights" }).waitFor();
  const nothing = await shoot(viewer);
  await set(viewer, { cutAbove: Infinity, hiddenStreams: ["cell_sensor_1", "cell_sensor_2"], showsSensors: false });
  const hidden = await shoot(viewer);
  await set(viewer, { cutAbove: -100, hiddenStreams: [] });
  assert.deepEqual(await shoot(viewer), hidden);
  assert.notDeepEqual(cut, whole);
  assert.notDeepEqual(cut, nothing);
  await viewer.finish();
});

test("voxels whose centres lie at a cut stay, in the picture and in numbers", async () => {
  const viewer = await openCell();
  await viewer.addStyleTag({ content: ".status { opacity: 0 }" });
  const all = await places(viewer);
  const height = all.map(([, , z]) => z).sort((a, b) => a - b)[Math.floor(all.length / 3)];
  const expected = all.filter(([, , z]) => Math.abs(z - height) < 1e-5).length;
  assert.ok(expected > 10 && expected < all.length / 2);
  const shots = [];
  for (const margin of [0, 0.004]) {
    await set(viewer, { cutBelow: height - margin, cutAbove: height + margin });
    assert.equal(await drawn(viewer), expected);
    shots.push(await shoot(viewer));
  }
  assert.deepEqual(shots[0], shots[1]);
  await viewer.finish();
});

test("the sliders go from all to nothing, links and files keep what is cut, another recording has all", async () => {
  const viewer = await openCell();
  const all = await places(viewer);
  const slider = viewer.getByRole("slider", { name: "Cut above" });
  assert.equal(await slider.getAttribute("aria-valuetext"), "off");
  await slider.focus();
  for (let i = 0; i < 5; ++i) await viewer.keyboard.press("PageDown");
  const { cutAbove } = await viewer.ask(() => window.pclExtViewer.state());
  assert.ok(cutAbove > 0 && cutAbove < 3, `${cutAbove}`);
  assert.equal(parseFloat(await slider.getAttribute("aria-valuetext")).toFixed(1), cutAbove.toFixed(1));
  await viewer.until((height) => location.hash.includes(`cutabove=${height}`), cutAbove);
  const downloading = viewer.waitForEvent("download");
  await viewer.getByRole("button", { name: "PLY" }).click();
  const ply = readFileSync(await (await downloading).path(), "latin1");
  assert.equal(Number(/element vertex (\d+)/.exec(ply)[1]), all.filter(([, , z]) => z <= cutAbove + 1e-4).length);
  await slider.focus();
  await viewer.keyboard.press("End");
  assert.equal((await viewer.ask(() => window.pclExtViewer.state())).cutAbove, Infinity);
  await set(viewer, { cutAbove: -100 });
  await openFiles(viewer, [cellRecording(10)]);
  await viewer.until(() => window.pclExtViewer.counts().drawn > 0);
  await viewer.finish();
});

test("after the graphics card was lost the same is drawn", async () => {
  const viewer = await openCell();
  await viewer.addStyleTag({ content: ".notices { opacity: 0 }" });
  const before = await shoot(viewer);
  await viewer.ask(async () => {
    const canvas = document.querySelector("canvas.scene");
    const lost = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
    const told = (event) => new Promise((resolve) => canvas.addEventListener(event, () => setTimeout(resolve), { once: true }));
    const isLost = told("webglcontextlost");
    lost.loseContext();
    await isLost;
    const isBack = told("webglcontextrestored");
    lost.restoreContext();
    await isBack;
  });
  // A picture can come to rest before the scene is drawn again.
  for (const end = Date.now() + 30_000; !(await shoot(viewer)).equals(before); ) assert.ok(Date.now() < end, "another picture");
  await viewer.finish();
});
