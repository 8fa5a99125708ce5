// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Which axis of the coordinates points up, and that the view follows it.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { openFiles, startViewer, stopViewer, untilIndexed, viewer } from "./support/browser.mjs";
import { writeBag } from "./support/bags.mjs";
import { cellRecording, cloudRecording, pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startViewer);
after(stopViewer);

/** A wall in 4 m and a floor, as a camera sees them that is held level at 1.2 m, 70 degrees wide: y points down. */
const seenByCamera = Array.from({ length: 4000 }, (_, i) => {
  const [u, v] = [((i * 613) % 4000) / 2000 - 1, i / 2000 - 1];
  return i % 2 ? [2.8 * u, 1.2 * v, 4] : [(2 + v) * 0.7 * u, 1.2, 2.8 + v];
});
/** The same room in coordinates with z up and its floor at 0. */
const inRoom = seenByCamera.map(([x, y, z]) => [z, -x, 1.2 - y]);
const texts = (points) => points.map((point) => point.map((value) => value.toFixed(3)).join(" "));

const auto = () => viewer.locator("select[aria-label=Up] option").first().textContent();
const ticks = () => viewer.locator(".legend .ticks span").allTextContents();

/** From the target of the view to the camera. */
async function towardsCamera() {
  const [x, y, z, ...target] = await viewer.ask(() => window.pclExtViewer.camera());
  return [x - target[0], y - target[1], z - target[2]];
}

async function open(recording) {
  await openFiles(viewer, [recording]);
  await untilIndexed(viewer);
}

test("a camera's cloud in its own coordinates stands upright, which is guessed, shown and changed", async () => {
  await open(cloudRecording("camera", texts(seenByCamera), "-r", 0.02));
  assert.equal(await auto(), "−y, guessed from the cloud");
  await viewer.evaluate(() => window.pclExtViewer.set({ colourBy: "height" }));
  const [lowest, , highest] = (await ticks()).map(parseFloat);
  assert.ok(Math.abs(lowest + 1.2) < 0.03 && Math.abs(highest - 1.2) < 0.03, `${lowest} to ${highest}`);
  const [, y, z] = await towardsCamera();
  assert.ok(y < -1 && z < -1, "above, and on the side of the camera");
  await viewer.keyboard.press("w");
  assert.ok((await towardsCamera())[1] < y, "higher");

  await viewer.getByRole("combobox", { name: "Up" }).selectOption("z");
  assert.ok((await towardsCamera())[2] > 1);
  assert.ok(parseFloat((await ticks())[0]) > 1.5);
  await viewer.until(() => location.hash.includes("up=z"));
  await viewer.getByRole("combobox", { name: "Up" }).selectOption("y");
  assert.ok((await towardsCamera())[1] > 1);
  await viewer.getByRole("combobox", { name: "Up" }).selectOption("auto");
  assert.ok((await towardsCamera())[1] < -1);
});

test("z is up where poses or the cloud say so", async () => {
  for (const [recording, reason] of [
    [cellRecording(), "z, from the sensors' poses"],
    [cloudRecording("in_room", texts(inRoom), "-r", 0.02), "z, guessed from the cloud"],
    // A thing that stands above the floor, in front of the origin only.
    [cloudRecording("thing", texts(seenByCamera.map(([x, y, z]) => [3 + x, y, z])), "-r", 0.02), "z, guessed from the cloud"],
  ]) {
    await open(recording);
    assert.equal(await auto(), reason);
    assert.ok((await towardsCamera())[2] > 1);
  }
});

test("transforms say that z is up, whatever the cloud looks like, and names of frames which ones are a camera's", async () => {
  const recordingOf = async (name, frameId, points, transforms) => {
    const bag = pathInFolder(`${name}_raw.mcap`);
    await writeBag(bag, [1000, 1001].map((time) => ({ topic: "/points", frameId, time, points })), transforms);
    pclExt("encode", bag, "-o", pathInFolder(`${name}.mcap`), "-r", 0.02, "-q");
    return pathInFolder(`${name}.mcap`);
  };
  const level = { isStatic: true, time: 1000, transforms: [{ parent: "map", child: "camera", pose: [0, 0, 0, 0, 0, 0, 1] }] };
  for (const [name, frameId, points, transforms, reason] of [
    ["placed", "camera", seenByCamera, [level], "z, from the transforms"],
    ["unplaced", "camera", seenByCamera, [], "−y, guessed from the cloud"],
    ["optical", "front_optical_frame", inRoom, [], "−y, as front_optical_frame is a camera's"],
  ]) {
    await open(await recordingOf(name, frameId, points, transforms));
    await viewer.until((text) => document.querySelector("select[aria-label=Up]").options[0].text === text, reason);
  }
});

test("a link keeps the axis", async () => {
  await viewer.evaluate(() => (location.hash = "#up=-z"));
  await openFiles(viewer, [cellRecording()]);
  assert.ok((await towardsCamera())[2] < -1);
});
