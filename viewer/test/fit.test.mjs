// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// What the view is fitted to, and that the rest can be seen.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { openFiles, openViewer, startBrowser, stillPicture, stopBrowser, untilAllDrawn } from "./support/browser.mjs";
import { cloudRecording } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

/** A room of 10 by 8 by 3 metres without its wall towards x, as 20,000 points on its other sides. */
function room() {
  const points = [];
  for (let i = 0; i < 20_000; ++i) {
    const [u, v] = [((i * 7919) % 20_000) / 20_000, i / 20_000];
    const sides = [[-5, 8 * u - 4, 3 * v], [10 * u - 5, -4, 3 * v], [10 * u - 5, 4, 3 * v], [10 * u - 5, 8 * v - 4, 0]];
    points.push(sides[i % sides.length].map((value) => value.toFixed(3)).join(" "));
  }
  return points;
}

/** Through the open side. */
const farAway = Array.from({ length: 60 }, (_, i) => `${170 + (i % 10)} ${(i % 15) - 7} ${(i % 8) - 2}`);

function distanceOf([x, y, z, ...target]) {
  return Math.hypot(x - target[0], y - target[1], z - target[2]);
}

test("the view is that of the room, whatever few points are far behind it", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cloudRecording("room", room(), "-r", 0.1)]);
  const camera = await viewer.ask(() => window.pclExtViewer.camera());
  await openFiles(viewer, [cloudRecording("room_and_far", [...room(), ...farAway], "-r", 0.1)]);
  const { all } = await viewer.ask(() => window.pclExtViewer.counts());
  const other = await viewer.ask(() => window.pclExtViewer.camera());
  assert.ok(farAway.length > 0.002 * all && farAway.length < 0.02 * all, `${farAway.length} of ${all} are far away`);
  // A quarter of the room's length may be added to it.
  assert.ok(distanceOf(other) < 2 * distanceOf(camera), `${distanceOf(other)} m instead of ${distanceOf(camera)} m`);
  await viewer.finish();
});

test("points that the view is not fitted to are drawn all the same", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cloudRecording("room_and_far", [...room(), ...farAway], "-r", 0.1)]);
  await viewer.evaluate(() => {
    window.pclExtViewer.set({ showsGrid: false, showsAxes: false, colourBy: "stream" });
    window.pclExtViewer.setCamera([-3, 0, 1.5, -1, 0, 1.5]); // looks out of the room
  });
  const clip = await viewer.locator("canvas.scene").boundingBox();
  const middle = { x: clip.x + clip.width / 2 - 20, y: clip.y + clip.height / 2 - 20, width: 40, height: 40 };
  const drawn = await stillPicture(viewer, { clip: middle });
  await viewer.evaluate(() => window.pclExtViewer.set({ hiddenStreams: ["room_and_far"] }));
  await viewer.until(() => window.pclExtViewer.counts().all === 0);
  assert.notDeepEqual(drawn, await stillPicture(viewer, { clip: middle }));
  await viewer.finish();
});

test("a small stream beside a large one is in the view", async () => {
  const viewer = await openViewer();
  const small = Array.from({ length: 100 }, (_, i) => `${30 + (i % 10) / 10} ${Math.floor(i / 10) / 10} 1`);
  const paths = [cloudRecording("large", room(), "-r", 0.1), cloudRecording("small", small, "-r", 0.1)];
  await openFiles(viewer, paths.slice(0, 1));
  const alone = distanceOf(await viewer.ask(() => window.pclExtViewer.camera()));
  await openFiles(viewer, paths);
  await untilAllDrawn(viewer, 2);
  await viewer.evaluate(() => window.pclExtViewer.fit("oblique"));
  assert.ok(distanceOf(await viewer.ask(() => window.pclExtViewer.camera())) > 1.5 * alone);
  await viewer.finish();
});
