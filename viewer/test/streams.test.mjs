// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The list of streams: its order and its colours, in whatever order streams come.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { openFiles, openViewer, seek, startBrowser, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { cellRecording, pagePath, pathInFolder, pclExt } from "./support/fixtures.mjs";
import { serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

const page = readFileSync(pagePath);
const described = (names) => names.map((name, id) => ({ id, name, metadata: {} }));

/** Colours of a page's streams by their names: those of the list, and those of the voxels. */
async function coloursOf(viewer) {
  const listed = await viewer.ask(() => [...document.querySelectorAll(".streams li")].map((row) =>
    [row.querySelector(".stream-name").textContent, row.querySelector(".swatch").style.background]));
  const drawn = await viewer.ask(() => window.pclExtViewer.streams().map(({ name, colour }) =>
    [name.replace(/^\//, ""), `rgb(${colour.map((value) => Math.round(255 * value)).join(", ")})`]));
  assert.deepEqual(Object.fromEntries(listed), Object.fromEntries(drawn));
  return { names: listed.map(([name]) => name), colours: Object.fromEntries(listed) };
}

/** What a live page shows of streams that come in some steps, each with all that are there by then. */
async function shownLive(...steps) {
  const server = await serveLive(page, described(steps[0]));
  const viewer = await openViewer({ url: server.url });
  for (const names of steps) {
    await viewer.until(() => window.pclExtViewer.state().source === "live");
    server.sendText({ type: "streams", streams: described(names) });
    await viewer.until((count) => document.querySelectorAll(".streams li").length === count, names.length);
  }
  const shown = await coloursOf(viewer);
  await viewer.finish();
  await server.close();
  return shown;
}

test("streams are listed by name, and have the same colours in whatever order they come", async () => {
  const sorted = ["cell_sensor_1", "cell_sensor_2", "cell_sensor_10", "front", "rear/points", "roof"];
  const topics = sorted.map((name) => `/${name}`);
  const first = await shownLive(topics);
  assert.deepEqual(first.names, sorted);
  assert.equal(new Set(Object.values(first.colours)).size, sorted.length);
  const reversed = [...topics].reverse();
  assert.deepEqual(await shownLive(reversed), first);
  assert.deepEqual(await shownLive(reversed.slice(0, 1), reversed.slice(0, 4), reversed), first);
});

test("a stream has its colour without the others, too, in recordings and live", async () => {
  const live = await shownLive(["/cell_sensor_3", "/cell_sensor_2", "/cell_sensor_1"]);
  const viewer = await openViewer();
  await openFiles(viewer, cellRecording(20, 2));
  const recorded = await coloursOf(viewer);
  for (const name of ["cell_sensor_1", "cell_sensor_2"]) assert.equal(recorded.colours[name], live.colours[name]);
  await viewer.finish();
});

test("of sixty streams each has a colour of its own", async () => {
  const { colours, names } = await shownLive(Array.from({ length: 60 }, (_, i) => `/lidar_${60 - i}`));
  assert.equal(new Set(Object.values(colours)).size, 60);
  assert.deepEqual(names, Array.from({ length: 60 }, (_, i) => `lidar_${i + 1}`));
});

test("many streams of a recording are listed at once, and not told unreadable before they are read", async () => {
  const folders = Array.from({ length: 100 }, (_, i) => {
    const folder = pathInFolder(`point_${i}`);
    mkdirSync(folder);
    writeFileSync(`${folder}/0.pcd`, ["VERSION .7", "FIELDS x y z", "SIZE 4 4 4", "TYPE F F F", "COUNT 1 1 1", "WIDTH 1",
      "HEIGHT 1", "POINTS 1", "DATA ascii", `${i} 0 0`, ""].join("\n"));
    return folder;
  });
  const path = pathInFolder("many.mcap");
  pclExt("encode", ...folders, "-o", path, "-q");
  const viewer = await openViewer();
  await viewer.evaluate(() => {
    window.seen = { notes: new Set(), lists: 0 };
    const list = document.querySelector(".streams");
    new MutationObserver((changes) => {
      window.seen.lists += changes.some(({ target }) => target === list) ? 1 : 0;
      for (const { textContent } of list.querySelectorAll(".stream-note")) if (textContent) window.seen.notes.add(textContent);
    }).observe(list, { subtree: true, childList: true });
  });
  await openFiles(viewer, path);
  await untilIndexed(viewer);
  await viewer.until(() => window.pclExtViewer.counts().all === 100);
  const { notes, lists } = await viewer.evaluate(() => ({ notes: [...window.seen.notes], lists: window.seen.lists }));
  assert.deepEqual(notes, []);
  assert.ok(lists <= 4, `the list was made ${lists} times`);
  await viewer.finish();
});

test("a stream that begins later is not drawn before its first frame, also after a step back", async () => {
  pclExt("demo", "-n", 20, "--sensors", 2, "--i-frame-rate", 10, "-o", pathInFolder("ten"), "-q");
  const cut = (name, ...options) => pclExt("cut", pathInFolder("ten/cell.mcap"), "-o", pathInFolder(name), "-q", ...options);
  cut("whole_1.mcap", "--streams", "/cell_sensor_1");
  cut("end_2.mcap", "--streams", "/cell_sensor_2", "--frames", "10:20");
  pclExt("merge", pathInFolder("whole_1.mcap"), pathInFolder("end_2.mcap"), "-o", pathInFolder("later.mcap"), "-q");
  const viewer = await openViewer();
  await openFiles(viewer, pathInFolder("later.mcap"));
  await untilIndexed(viewer);
  const frames = () => viewer.ask(() => window.pclExtViewer.streams().map(({ number, voxels }) => [number, voxels > 0]));
  await viewer.evaluate(() => window.pclExtViewer.set({ decaySeconds: 3 }));
  for (const moment of [14, 15]) await seek(viewer, moment);
  assert.ok((await viewer.ask(() => window.pclExtViewer.pastPositions(1))).length > 0);
  assert.deepEqual(await frames(), [[15, true], [5, true]]);
  await seek(viewer, 3);
  assert.deepEqual(await frames(), [[3, true], [null, false]]);
  assert.deepEqual(await viewer.ask(() => window.pclExtViewer.pastPositions(1)), []);
  await viewer.locator(".stream-note", { hasText: /^Begins at 0\.50 s$/ }).waitFor();
  await viewer.finish();
});
