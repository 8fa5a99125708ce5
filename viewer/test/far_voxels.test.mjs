// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Small voxels are drawn as squares, larger ones as cubes.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { largeDesk, openFiles, openViewer, startBrowser, stillPicture, stopBrowser } from "./support/browser.mjs";
import { cloudRecording } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

const edge = 0.04;
const fieldOfView = 45; // degrees, vertical

/** Runs in the page: the light of a picture, beside that of its first pixel. */
async function lightOf(png) {
  const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  let light = 0;
  for (let i = 0; i < data.length; i += 4) for (let c = 0; c < 3; ++c) light += Math.abs(data[i + c] - data[c]);
  return light;
}

test("squares give as much light as the cubes in whose place they are, from all sides", async () => {
  const viewer = await openViewer(largeDesk);
  const points = Array.from({ length: 4096 }, (_, i) => [i & 15, (i >> 4) & 15, i >> 8].map((index) => (index - 7.5) * 0.32).join(" "));
  await openFiles(viewer, [cloudRecording("apart", points, "-r", edge)]);
  await viewer.ask(() => window.pclExtViewer.set({ colourBy: "stream", showsGrid: false, showsAxes: false }));
  await viewer.addStyleTag({ content: "body > :not(:has(canvas.scene)), .status { opacity: 0 }" });
  const clip = await viewer.locator("canvas.scene").boundingBox();
  const distanceFor = (pixels) => (edge * clip.height) / (2 * pixels * Math.tan((fieldOfView * Math.PI) / 360));
  const lightAt = async (direction, pixels) => {
    // The nearest voxel has so many pixels, others fewer.
    const distance = distanceFor(pixels) + 2.4 * Math.hypot(...direction);
    const camera = [...direction.map((value) => (value * distance) / Math.hypot(...direction)), 0, 0, 0];
    await viewer.evaluate((values) => window.pclExtViewer.setCamera(values), camera);
    const picture = await stillPicture(viewer, { clip });
    return (await viewer.evaluate(lightOf, picture.toString("base64"))) * distance ** 2;
  };
  for (const direction of [[0.02, -1, 0.05], [1, -1, 1], [-1, 0.6, 0.3], [0.3, 0.2, -1]]) {
    const cubes = await lightAt(direction, 3.3);
    const squares = await lightAt(direction, 2.7);
    assert.ok(Math.abs(squares / cubes - 1) < 0.1, `${direction}: ${(squares / cubes).toFixed(3)}`);
  }
  await viewer.finish();
});
