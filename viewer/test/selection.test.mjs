// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Voxels that are picked: their marks, and the distance between two of them.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { largeDesk, openFiles, openViewer, phone, seek, startBrowser, stillPicture, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { cellRecording, cloudRecording } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

/** Two blocks of voxels, 2 m from each other along x and 0.5 m along z, with a gap of nothing between them. */
const block = Array.from({ length: 1000 }, (_, i) => [i % 10, Math.floor(i / 10) % 10, Math.floor(i / 100)].map((v) => 0.05 * v + 0.02));
const blocks = [...block, ...block.map(([x, y, z]) => [x + 2, y, z + 0.5])].map((point) => point.map((v) => v.toFixed(3)).join(" "));

const details = (viewer) => viewer.getByLabel("Selected voxel");
const told = async (viewer, name) => new RegExp(`^${name}\\n(.*)$`, "m").exec(await details(viewer).innerText())?.[1];
const numbers = (text) => text.match(/-?\d+\.\d+/g).map(Number);

/** Looks along y at both blocks; where on the screen the middle of each one's front is. */
async function openBlocks(options = largeDesk) {
  const viewer = await openViewer(options);
  await openFiles(viewer, [cloudRecording("blocks", blocks, "-r", 0.05)]);
  await untilIndexed(viewer);
  await viewer.evaluate(() => window.pclExtViewer.setCamera([1.25, -6, 0.5, 1.25, 0, 0.5]));
  const box = await viewer.locator("canvas.scene").boundingBox();
  const perMetre = box.height / (2 * Math.tan(Math.PI / 8) * 6);
  const at = (x, z) => ({ x: box.x + box.width / 2 + (x - 1.25) * perMetre, y: box.y + box.height / 2 - (z - 0.5) * perMetre });
  return { viewer, left: at(0.25, 0.25), right: at(2.25, 0.75), nowhere: at(1.25, 0.5) };
}

test("a voxel that is picked is marked, and of two the distance is told", async () => {
  const { viewer, left, right, nowhere } = await openBlocks();
  const clip = { x: left.x - 14, y: left.y - 14, width: 28, height: 28 };
  const shoot = () => stillPicture(viewer, { clip });
  const unmarked = await shoot();
  await viewer.mouse.click(left.x, left.y);
  const first = numbers(await told(viewer, "Position"));
  assert.ok(Math.abs(first[0] - 0.25) < 0.06 && Math.abs(first[2] - 0.25) < 0.06, `${first}`);
  assert.notDeepEqual(await shoot(), unmarked);
  assert.equal(await told(viewer, "Distance"), undefined);

  await viewer.mouse.move(right.x, right.y);
  await viewer.keyboard.down("Shift");
  await viewer.mouse.click(nowhere.x, nowhere.y); // leaves the first one as it is
  await viewer.mouse.click(right.x, right.y);
  await viewer.keyboard.up("Shift");
  const second = numbers(await told(viewer, "Position"));
  assert.deepEqual(numbers(await told(viewer, "From")), first);
  const steps = second.map((value, axis) => value - first[axis]);
  const [distance] = numbers(await told(viewer, "Distance"));
  assert.ok(Math.abs(distance - Math.hypot(...steps)) < 0.002, `${distance} between ${first} and ${second}`);
  assert.ok(distance > 2 && distance < 2.2);
  numbers(await told(viewer, "Along x, y, z")).forEach((value, axis) => assert.ok(Math.abs(value - steps[axis]) < 0.0015));

  await viewer.mouse.click(left.x, left.y); // begins anew
  assert.equal(await told(viewer, "Distance"), undefined);
  await viewer.keyboard.press("Escape");
  assert.equal(await details(viewer).isVisible(), false);
  await viewer.mouse.move(5, 5);
  assert.deepEqual(await shoot(), unmarked);
  await viewer.finish();
});

test("on a phone a button makes the next voxel the other end", async () => {
  const { viewer, left, right } = await openBlocks(phone);
  await viewer.touchscreen.tap(left.x, left.y);
  const button = details(viewer).getByRole("button", { name: "Distance to" });
  await button.tap();
  assert.equal(await details(viewer).getByRole("button", { name: "Pick the other voxel" }).getAttribute("aria-pressed"), "true");
  await viewer.touchscreen.tap(right.x, right.y);
  await details(viewer).getByText("Distance", { exact: true }).waitFor(); // the page clicks after the tap
  assert.ok(numbers(await told(viewer, "Distance"))[0] > 2);
  assert.equal(await viewer.ask(() => document.scrollingElement.scrollWidth), 390);
  const box = await details(viewer).boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390);
  await viewer.finish();
});

test("the distance stays while frames come, also of voxels that these do not have", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cellRecording()]);
  await untilIndexed(viewer);
  const box = await viewer.locator("canvas.scene").boundingBox();
  await viewer.keyboard.down("Shift");
  // Clicks next to each other may pick the same voxel.
  const distance = async () => parseFloat((await told(viewer, "Distance")) ?? "0");
  for (let i = 0; i < 40 && (await distance()) === 0; ++i)
    await viewer.mouse.click(box.x + box.width * (0.3 + 0.01 * i), box.y + box.height * (0.35 + 0.006 * i));
  await viewer.keyboard.up("Shift");
  const ends = [await told(viewer, "From"), await told(viewer, "Position"), await told(viewer, "Distance")];
  assert.ok(ends.every(Boolean) && parseFloat(ends[2]) > 0, `${ends}`);
  for (const moment of [1, 7, 15, 3]) {
    await seek(viewer, moment);
    assert.deepEqual([await told(viewer, "From"), await told(viewer, "Position"), await told(viewer, "Distance")], ends);
  }
  await openFiles(viewer, [cloudRecording("blocks", blocks, "-r", 0.05)]);
  assert.equal(await details(viewer).isVisible(), false);
  await viewer.finish();
});

test("voxels of less than a pixel are picked where they are drawn", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cloudRecording("grid", Array.from({ length: 27 }, (_, i) => [i % 3, (i / 3) % 3 | 0, i / 9 | 0].join(" ")), "-r", 0.04)]);
  await untilIndexed(viewer);
  await viewer.evaluate(() => window.pclExtViewer.setCamera([1, -60, 1, 1, 1, 1]));
  const box = await viewer.locator("canvas.scene").boundingBox();
  for (const [x, y] of [[0, 0], [0.9, 0], [-0.9, 0], [0, 0.9], [0, -0.9]]) {
    await viewer.mouse.click(box.x + box.width / 2 + x, box.y + box.height / 2 + y);
    assert.deepEqual(numbers(await told(viewer, "Position")).map(Math.round), [1, 0, 1]);
  }
  await viewer.finish();
});

test("of voxels below a centimetre places and heights are told with the digits that tell them apart", async () => {
  const viewer = await openViewer();
  const points = block.map((point) => point.map((value) => (value / 500).toFixed(6)).join(" ")); // 1 mm wide
  await openFiles(viewer, cloudRecording("tiny", points, "-r", 0.0001, "--law", "none"));
  const heights = (await viewer.locator(".legend .ticks span").allTextContents()).map(parseFloat);
  assert.ok(heights[0] < heights[1] && heights[1] < heights[2], `${heights}`);
  const box = await viewer.locator("canvas.scene").boundingBox();
  await viewer.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const cells = numbers(await told(viewer, "Position")).map((value) => value / 0.0001);
  for (const cell of cells) assert.ok(Math.abs(cell - Math.round(cell - 0.5) - 0.5) < 0.001, `${cells}`); // centres
  await viewer.finish();
});
