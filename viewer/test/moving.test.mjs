// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Sensors that move: the camera goes with them, and frames stay for the decay time.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { openFiles, openViewer, seek, startBrowser, stillPicture, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { writeBag } from "./support/bags.mjs";
import { cellRecording, pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

const edge = 0.02;
const times = [1000, 1001, 1002, 1003];

/** A lidar that goes 2 m along x and 1 m along y each second and sees one point, 1 m ahead, and one that stands still. */
async function openRobot() {
  const bag = pathInFolder("moving_raw.mcap");
  const recording = pathInFolder("moving.mcap");
  const clouds = ["lidar", "mast"].flatMap((frameId) =>
    times.map((time) => ({ topic: `/${frameId}`, frameId, time, points: [[1.01, 0.01, 0.01]] })));
  const mast = { isStatic: true, time: 1000, transforms: [{ parent: "map", child: "mast", pose: [0, 5, 0, 0, 0, 0, 1] }] };
  const motion = times.map((time, i) =>
    ({ time, transforms: [{ parent: "map", child: "lidar", pose: [2 * i, i, 0, 0, 0, 0, 1] }] }));
  await writeBag(bag, clouds, [mast, ...motion]);
  pclExt("encode", bag, "-o", recording, "-r", edge, "-q", "--overwrite");
  const viewer = await openViewer();
  await openFiles(viewer, [recording]);
  await untilIndexed(viewer);
  return viewer;
}

const set = (viewer, values) => viewer.evaluate((state) => window.pclExtViewer.set(state), values);

function expectNear(values, expected) {
  assert.equal(values.length, expected.length);
  expected.forEach((value, i) => assert.ok(Math.abs(values[i] - value) < edge, `${values} instead of ${expected}`));
}

test("the camera goes with the sensor that moves, forwards and back, as long as it is followed", async () => {
  const viewer = await openRobot();
  const camera = () => viewer.ask(() => window.pclExtViewer.camera());
  const before = await camera();
  await seek(viewer, 1);
  expectNear(await camera(), before);
  await viewer.getByText("Follow", { exact: true }).click();
  const expectMoved = async (x, y) => expectNear(await camera(), before.map((value, i) => value + [x, y, 0][i % 3]));
  await seek(viewer, 3);
  await expectMoved(4, 2);
  await seek(viewer, 0);
  await expectMoved(-2, -1);
  await viewer.until(() => location.hash.includes("follow=1"));
  await set(viewer, { hiddenStreams: ["lidar"] });
  await seek(viewer, 2);
  await expectMoved(-2, -1); // the mast stands still
  await viewer.finish();
});

test("where no sensor moves there is none to follow", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cellRecording()]);
  await untilIndexed(viewer);
  assert.equal(await viewer.getByText("Follow", { exact: true }).isVisible(), false);
  await viewer.finish();
});

test("frames stay where they were for the decay time, and are taken away after it and by going back", async () => {
  const viewer = await openRobot();
  const past = (stream) => viewer.evaluate((index) => window.pclExtViewer.pastPositions(index), stream);
  const shoot = async () => stillPicture(viewer, { clip: await viewer.locator("canvas.scene").boundingBox() });
  await viewer.addStyleTag({ content: ".status { opacity: 0 }" });
  await seek(viewer, 1);
  expectNear(await past(0), []);
  await seek(viewer, 0);
  await set(viewer, { decaySeconds: 1.5 });
  await seek(viewer, 1);
  expectNear(await past(0), [1, 0, 0]);
  await seek(viewer, 2);
  expectNear(await past(0), [3, 1, 0]);
  expectNear(await past(1), [1, 5, 0]);
  const withPast = await shoot();
  await set(viewer, { decaySeconds: 0 });
  expectNear(await past(0), []);
  assert.notDeepEqual(await shoot(), withPast);
  await set(viewer, { decaySeconds: 10 });
  for (const moment of [3, 0, 1, 2, 3]) await seek(viewer, moment);
  expectNear(await past(0), [1, 0, 0, 3, 1, 0, 5, 2, 0]);
  await seek(viewer, 1);
  expectNear(await past(0), [1, 0, 0]);
  await openFiles(viewer, [cellRecording()]);
  await viewer.until(() => window.pclExtViewer.pastPositions(0).length === 0);
  await viewer.finish();
});
