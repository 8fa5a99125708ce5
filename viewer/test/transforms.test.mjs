// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Frames are drawn where the transforms of a bag place them.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { openFiles, seek, startViewer, stopViewer, untilIndexed, viewer } from "./support/browser.mjs";
import { writeBag } from "./support/bags.mjs";
import { pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startViewer);
after(stopViewer);

const edge = 0.02;
const half = Math.SQRT1_2;

/** Opens what the program makes of a bag. */
async function openBag(name, clouds, transforms, isRos1 = false) {
  const bag = pathInFolder(`${name}_raw.mcap`);
  const recording = pathInFolder(`${name}.mcap`);
  await writeBag(bag, clouds, transforms, isRos1);
  pclExt("encode", bag, "-o", recording, "-r", edge, "-q");
  await openFiles(viewer, [recording]);
  await untilIndexed(viewer);
}

/** Expects that a stream's only voxel is drawn at a place, up to the error of a voxel. */
async function expectPlace(stream, place) {
  const position = await viewer.evaluate((index) => window.pclExtViewer.positions(index), stream);
  assert.equal(position.length, 3);
  place.forEach((value, axis) =>
    assert.ok(Math.abs(position[axis] - value) < edge, `${position} instead of ${place}`));
}

function cloudsOf(topic, frameId, times, point = [1.01, 0.01, 0.01]) {
  return times.map((time) => ({ topic, frameId, time, points: [point] }));
}

/** A robot that goes two metres along x and turns by 90 degrees in two seconds, and has a lidar; and a mast. */
const staticLinks = {
  isStatic: true,
  time: 1000,
  transforms: [
    { parent: "map", child: "odom", pose: [10, 0, 0, 0, 0, 0, 1] },
    { parent: "base_link", child: "lidar", pose: [0, 0, 0.5, 0, 0, 0, 1] },
    { parent: "map", child: "mast", pose: [0, 0, 4, 0, half, 0, half] }, // looks down
  ],
};
const motion = [
  { time: 1000, transforms: [{ parent: "odom", child: "base_link", pose: [0, 0, 0, 0, 0, 0, 1] }] },
  { time: 1002, transforms: [{ parent: "odom", child: "base_link", pose: [2, 0, 0, 0, 0, half, half] }] },
];

for (const isRos1 of [false, true])
  test(`frames of a moving robot are placed by interpolated transforms, in messages of ROS ${isRos1 ? 1 : 2}`, async () => {
    const clouds = [...cloudsOf("/lidar", "lidar", [1000, 1001, 1002]), ...cloudsOf("/mast", "mast", [1000, 1001, 1002])];
    await openBag(`robot_${isRos1}`, clouds, [staticLinks, ...motion], isRos1);
    for (const [moment, place] of [[0, [11, 0, 0.5]], [1, [11 + half, half, 0.5]], [2, [12, 1, 0.5]]]) {
      await seek(viewer, moment);
      await expectPlace(0, place);
      await expectPlace(1, [0, 0, 3]);
    }
    assert.equal(await viewer.notice("info").count(), 0, "one tree of frames needs no word");
  });

test("what no transform connects is drawn around the same origin, and the page says so", async () => {
  const clouds = [...cloudsOf("/lidar", "lidar", [1000, 1001]), ...cloudsOf("/arm", "arm", [1000, 1001])];
  await openBag("unconnected", clouds, [staticLinks, ...motion]);
  await expectPlace(0, [11, 0, 0.5]);
  await expectPlace(1, [1, 0, 0]);
  assert.match(await viewer.notice("info").innerText(), /\(map, arm\).*no transform connects them/);
});

test("frames far from their nearest transform, and circles of parents, are named", async () => {
  const circle = {
    isStatic: true,
    time: 1000,
    transforms: [["a", "b"], ["b", "c"], ["c", "a"]].map(([parent, child]) => ({ parent, child, pose: [1, 0, 0, 0, 0, 0, 1] })),
  };
  const clouds = [...cloudsOf("/lidar", "lidar", [1000, 1007]), ...cloudsOf("/round", "b", [1000, 1007])];
  await openBag("circle", clouds, [staticLinks, ...motion, circle]);
  await seek(viewer, 1);
  await expectPlace(0, [12, 1, 0.5]);
  await expectPlace(1, [1, 0, 0]);
  const streams = viewer.locator(".streams");
  await streams.getByText("the nearest transform of “base_link” is 5.00 s away").waitFor();
  await streams.getByText("the parents of “b” form a circle at “b”").waitFor();
});

test("invalid transforms are left out, and the page says so", async () => {
  const odd = {
    time: 1000.5,
    transforms: [
      { parent: "map", child: "nowhere", pose: [Number.NaN, 0, 0, 0, 0, 0, 1] },
      { parent: "map", child: "undirected", pose: [0, 0, 0, 0, 0, 0, 0] },
      { parent: "mast", child: "lidar", pose: [5, 5, 5, 0, 0, 0, 1] },
    ],
  };
  await openBag("odd", cloudsOf("/lidar", "lidar", [1000]), [staticLinks, ...motion, odd]);
  await expectPlace(0, [11, 0, 0.5]);
  const notice = await viewer.notice("info").innerText();
  assert.match(notice, /some transforms are no rotation and translation/);
  assert.match(notice, /“lidar” has several parents, of which the first one, “base_link”, is used/);
});

test("of more transforms than are kept, and in any order, the rest places frames as well", async () => {
  const straight = Array.from({ length: 300 }, (_, message) => ({
    time: 1000 + message / 100,
    transforms: Array.from({ length: 1000 }, (_, i) => {
      const seconds = message / 100 + (999 - i) / 100_000;
      return { parent: "map", child: "lidar", stamp: 1000 + seconds, pose: [seconds, 0, 0, 0, 0, 0, 1] };
    }),
  }));
  await openBag("many", cloudsOf("/lidar", "lidar", [1000, 1002.5]), straight);
  await seek(viewer, 1);
  await expectPlace(0, [3.5, 0, 0]);
});
