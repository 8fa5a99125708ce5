// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Clouds at the coordinates of maps, which floats do not hold, look as near the origin, and what is told of them is exact.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { largeDesk, openFiles, openViewer, seek, startBrowser, stillPicture, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { writeBag } from "./support/bags.mjs";
import { pathInFolder, pclExt } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

const edge = 0.05;
const utm = [691234, 5335678, 520];
const half = Math.SQRT1_2;

/** Centres of voxels: two blocks, 2 m from each other along x and 0.5 m along z, and between them nothing. */
const block = Array.from({ length: 1000 }, (_, i) => [i % 10, Math.floor(i / 10) % 10, Math.floor(i / 100)]
  .map((index) => edge * (index + 0.5)));
const rightBlock = block.map(([x, y, z]) => [x + 2, y, z + 0.5]);

const moved = (points, by) => points.map((point) => point.map((value, axis) => value + by[axis]));
const set = (viewer, values) => viewer.evaluate((state) => window.pclExtViewer.set(state), values);

async function openBag(name, clouds, transforms = []) {
  const [bag, recording] = [`${name}_raw.mcap`, `${name}.mcap`].map(pathInFolder);
  await writeBag(bag, clouds.map((cloud) => ({ ...cloud, isDouble: true })), transforms);
  pclExt("encode", bag, "-o", recording, "-r", edge, "--overwrite", "-q");
  const viewer = await openViewer(largeDesk);
  await openFiles(viewer, [recording]);
  await untilIndexed(viewer);
  return viewer;
}

/** Both blocks in two frames, the right one in a third, and nothing in a fourth, seen along y. */
async function openBlocks(offset) {
  const frames = [[...block, ...rightBlock], [...block, ...rightBlock], rightBlock, []];
  const viewer = await openBag(`blocks_${offset[0]}`, frames.map((points, i) =>
    ({ topic: "/blocks", frameId: "map", time: 1000 + i / 10, points: moved(points, offset) })));
  await set(viewer, { showsGrid: false, showsAxes: false, colourBy: "height" });
  const camera = moved([[1.25, -6, 0.5], [1.25, 0, 0.5]], offset).flat();
  await viewer.evaluate((values) => window.pclExtViewer.setCamera(values), camera);
  const box = await viewer.locator("canvas.scene").boundingBox();
  const perMetre = box.height / (2 * Math.tan(Math.PI / 8) * 6);
  const at = (x, z) => [box.x + box.width / 2 + (x - 1.25) * perMetre, box.y + box.height / 2 - (z - 0.5) * perMetre];
  return { viewer, camera, box, left: at(0.26, 0.26), right: at(2.26, 0.76) };
}

/** Runs in the page: the share of pixels that two pictures do not have in common, and of those that are no background. */
async function compare(pngs) {
  const [a, b] = await Promise.all(pngs.map(async (png) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
  }));
  const differs = (x, i, y, j) => [0, 1, 2].some((c) => Math.abs(x[i + c] - y[j + c]) > 8);
  let [different, drawn] = [0, 0];
  for (let i = 0; i < a.length; i += 4) {
    if (differs(a, i, b, i)) ++different;
    if (differs(a, i, a, 0)) ++drawn;
  }
  return { different: (4 * different) / a.length, drawn: (4 * drawn) / a.length };
}

test("pictures are those of the same cloud near the origin, also of what is past and what is cut", async () => {
  const plain = { colourBy: "height", shape: "cubes", up: "auto", decaySeconds: 0, cutBelow: -Infinity, cutAbove: Infinity };
  const scenes = [
    { moment: 0, state: {} },
    { moment: 0, state: { shape: "points" }, cut: { axis: 2, below: 0.2, above: 0.575 } },
    { moment: 0, state: { up: "y" }, cut: { axis: 1, below: 0.125, above: 0.375 } },
    { moment: 2, state: { colourBy: "age" }, past: 1000 },
    { moment: 3, state: { colourBy: "age" }, past: 2000 },
    { moment: 2, state: { colourBy: "stream", decaySeconds: 10 } },
  ];
  const shoot = async ({ viewer, box }, offset, { moment, state, cut, past = 0 }) => {
    await set(viewer, plain);
    for (let passed = 0; passed < moment; ++passed) await seek(viewer, passed);
    const cuts = cut ? { cutBelow: cut.below + offset[cut.axis], cutAbove: cut.above + offset[cut.axis] } : {};
    await set(viewer, { ...state, ...cuts });
    await seek(viewer, moment);
    await viewer.until((count) => window.pclExtViewer.streams()[0].past === count, past);
    const camera = moved([[4, -5, 3], [1.25, 0, 0.5]], offset).flat(); // which another up axis has moved
    await viewer.evaluate((values) => window.pclExtViewer.setCamera(values), camera);
    return (await stillPicture(viewer, { clip: box })).toString("base64");
  };
  const shots = [];
  for (const offset of [[0, 0, 0], utm]) {
    const opened = await openBlocks(offset);
    await opened.viewer.addStyleTag({ content: "body > :not(:has(canvas.scene)), .status { opacity: 0 }" });
    for (const [i, scene] of scenes.entries()) {
      const shot = await shoot(opened, offset, scene);
      if (offset !== utm) shots.push(shot);
      else {
        const { different, drawn } = await opened.viewer.evaluate(compare, [shots[i], shot]);
        assert.ok(drawn > 0.005 && different < 0.02 * drawn, `${JSON.stringify(scene)}: ${different} of ${drawn}`);
      }
    }
    await opened.viewer.finish();
  }
});

test("positions, distances, links and files have them to the millimetre", async () => {
  const { viewer, camera, left, right } = await openBlocks(utm);
  const told = async (name) => new RegExp(`^${name}\\n(.*)$`, "m")
    .exec(await viewer.getByLabel("Selected voxel").innerText())[1].match(/-?\d+\.\d+/g).map(Number);
  const expectNear = (values, expected, most = 0.0011) => {
    assert.equal(values.length, expected.length);
    expected.forEach((value, i) => assert.ok(Math.abs(values[i] - value) < most, `${values} instead of ${expected}`));
  };
  await viewer.mouse.click(...left);
  expectNear(await told("Position"), [utm[0] + 0.275, utm[1] + 0.025, utm[2] + 0.275]);
  await viewer.keyboard.down("Shift");
  await viewer.mouse.click(...right);
  await viewer.keyboard.up("Shift");
  expectNear(await told("Position"), [utm[0] + 2.275, utm[1] + 0.025, utm[2] + 0.775]);
  expectNear(await told("Distance"), [Math.hypot(2, 0.5)]);
  await seek(viewer, 1);
  expectNear(await told("Along x, y, z"), [2, 0, 0.5]);
  assert.doesNotMatch(await viewer.getByLabel("Selected voxel").innerText(), /not in this frame/);

  await viewer.until(() => location.hash.includes("camera="));
  expectNear(await viewer.ask(() => /camera=([^&]*)/.exec(location.hash)[1].split(",").map(Number)), camera);

  const sorted = (points) => points.map((point) => point.map((value) => value.toFixed(4)).join()).sort();
  const expected = sorted(moved([...block, ...rightBlock], utm));
  const positions = await viewer.ask(() => window.pclExtViewer.positions(0));
  const inThrees = (values) => Array.from({ length: values.length / 3 }, (_, i) => values.slice(3 * i, 3 * i + 3));
  assert.deepEqual(sorted(inThrees(positions)), expected);
  const [download] = await Promise.all([viewer.waitForEvent("download"), viewer.getByRole("button", { name: "PLY" }).click()]);
  const bytes = readFileSync(await download.path());
  const begin = bytes.indexOf("end_header\n") + 11;
  const [, properties] = /element vertex 2000\n([^]*)end_header/.exec(bytes.toString("latin1", 0, begin));
  assert.deepEqual(properties.trim().split("\n").map((line) => line.slice("property ".length)),
    ["double x", "double y", "double z", "ushort stream"]);
  const stride = (bytes.length - begin) / 2000;
  assert.equal(stride, 26);
  const saved = Array.from({ length: 2000 }, (_, i) => [0, 8, 16].map((at) => bytes.readDoubleLE(begin + stride * i + at)));
  assert.deepEqual(sorted(saved), expected);
  await viewer.finish();
});

test("transforms place clouds with and without such coordinates in one place", async () => {
  const place = [0.275, 0.125, 0.075];
  const clouds = [
    { topic: "/1_map", frameId: "map", points: moved([place], utm) },
    { topic: "/2_site", frameId: "site", points: [[utm[1] + place[1], -utm[0] - place[0], place[2]]] }, // turned back
    { topic: "/3_lidar", frameId: "lidar", points: [place] },
  ];
  const links = [
    { parent: "map", child: "site", pose: [0, 0, utm[2], 0, 0, half, half] },
    { parent: "map", child: "lidar", pose: [...utm, 0, 0, 0, 1] },
  ];
  const viewer = await openBag("placed", clouds.map((cloud) => ({ ...cloud, time: 1000 })),
    [{ isStatic: true, time: 1000, transforms: links }]);
  for (const stream of [0, 1, 2]) {
    const position = await viewer.evaluate((index) => window.pclExtViewer.positions(index), stream);
    assert.equal(position.length, 3);
    position.forEach((value, axis) =>
      assert.ok(Math.abs(value - utm[axis] - place[axis]) < 1e-4, `stream ${stream}: ${position}`));
  }
  await viewer.finish();
});
