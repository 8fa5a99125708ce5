// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The date of what is shown, beside the seconds since the start.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { openFiles, openViewer, phone, seek, startBrowser, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { writeBag } from "./support/bags.mjs";
import { cellRecording, pagePath, pathInFolder, pclExt } from "./support/fixtures.mjs";
import { framesOf, serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

/** Four clouds, from 2023-11-14 22:13:20.25 UTC on. */
async function datedRecording() {
  const clouds = [0, 0.1, 0.2, 7200].map((later) =>
    ({ topic: "/points", frameId: "map", time: 1_700_000_000.25 + later, points: [[1, 2, 3], [2, 3, 4]] }));
  await writeBag(pathInFolder("dated_raw.mcap"), clouds, []);
  pclExt("encode", pathInFolder("dated_raw.mcap"), "-o", pathInFolder("dated.mcap"), "-r", 0.05, "--overwrite", "-q");
  return pathInFolder("dated.mcap");
}

const date = (viewer) => viewer.locator(".date");

test("the date of a frame is told in UTC, or where the computer is", async () => {
  const viewer = await openViewer({ timezoneId: "Asia/Kathmandu" });
  await openFiles(viewer, [await datedRecording()]);
  await untilIndexed(viewer);
  assert.equal(await date(viewer).textContent(), "2023-11-14 22:13:20.250 UTC");
  await seek(viewer, 1);
  assert.equal(await date(viewer).textContent(), "2023-11-14 22:13:20.350 UTC");
  await date(viewer).click();
  assert.equal(await date(viewer).textContent(), "2023-11-15 03:58:20.350 +05:45");
  await viewer.until(() => location.hash.includes("clock=local"));
  await seek(viewer, 3);
  assert.equal(await date(viewer).textContent(), "2023-11-15 05:58:20.250 +05:45");
  await viewer.keyboard.press("Home");
  await date(viewer).click();
  assert.equal(await date(viewer).textContent(), "2023-11-14 22:13:20.250 UTC");
  await viewer.finish();
});

test("west of Greenwich, too", async () => {
  const viewer = await openViewer({ timezoneId: "America/St_Johns" });
  await openFiles(viewer, [await datedRecording()]);
  await date(viewer).click();
  assert.equal(await date(viewer).textContent(), "2023-11-14 18:43:20.250 −03:30");
  await viewer.finish();
});

test("a recording of a simulated clock has no date", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, [cellRecording()]);
  assert.equal(await date(viewer).isVisible(), false);
  await viewer.finish();
});

test("a live source has the date of its last frame", async () => {
  const { streams, frames } = framesOf(cellRecording());
  const server = await serveLive(readFileSync(pagePath), streams);
  const viewer = await openViewer({ url: server.url });
  while (server.viewers() === 0) await new Promise((resolve) => setTimeout(resolve, 50));
  const start = 1_700_000_000_250_000_000n - frames[0].time;
  for (const frame of frames.slice(0, 3 * streams.length)) server.send({ ...frame, time: frame.time + start });
  await date(viewer).filter({ hasText: "2023-11-14 22:13:20.350 UTC" }).waitFor();
  await viewer.finish();
  await server.close();
});

test("on a phone there is room for it", async () => {
  const viewer = await openViewer(phone);
  await openFiles(viewer, [await datedRecording()]);
  await untilIndexed(viewer);
  const box = await date(viewer).boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390 && box.y + box.height <= 844, JSON.stringify(box));
  const last = await viewer.getByRole("combobox", { name: "Speed" }).boundingBox();
  assert.ok(last.x + last.width <= box.x, "beside the buttons");
  await viewer.finish();
});
