// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The time of live sources: stamps that begin again, and a picture that is kept.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, keyOf, openViewer, startBrowser, stopBrowser, untilBadge } from "./support/browser.mjs";
import { cellRecording, decodedByProgram, pagePath, pathInFolder, pclExt } from "./support/fixtures.mjs";
import { framesOf, serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

const { streams, frames } = framesOf(cellRecording());
const decoded = decodedByProgram(cellRecording());
const page = readFileSync(pagePath);
const perFrame = streams.length;

async function liveViewer(sources = streams) {
  const server = await serveLive(page, sources);
  const viewer = await openViewer({ url: server.url });
  for (let i = 0; i < 600 && server.viewers() === 0; ++i) await new Promise((resolve) => setTimeout(resolve, 50));
  const finish = async () => {
    await viewer.finish();
    await server.close();
  };
  return { server, viewer, finish };
}

/** Waits until a frame is shown, by its number of voxels; the page tells numbers, but they begin anew. */
async function untilVoxels(viewer, stream, count) {
  await viewer.until(([i, voxels]) => window.pclExtViewer.streams()[i]?.voxels === voxels, [stream, count]);
}

/** Waits until a frame of both streams is drawn, and checks its voxels. */
async function untilFrameDrawn(viewer, frame) {
  for (const stream of [0, 1]) {
    await untilVoxels(viewer, stream, decoded[stream][frame].length);
    assert.deepEqual(await drawnVoxels(viewer, stream), decoded[stream][frame].map(keyOf).sort());
  }
}

test("stamps that begin again begin the time line again, and small steps back do not", async () => {
  const { server, viewer, finish } = await liveViewer();
  const send = (first, last, seconds) => {
    for (const frame of frames.slice(first * perFrame, last * perFrame))
      server.send({ ...frame, time: frame.time + BigInt(Math.round(1e9 * seconds)) });
  };
  send(0, 10, 100);
  send(10, 12, 99.5); // half a second back
  await viewer.until(() => window.pclExtViewer.moments() === 12);
  await untilVoxels(viewer, 0, decoded[0][11].length);
  await viewer.evaluate(() => window.pclExtViewer.set({ colourBy: "age" }));
  send(0, 6, 0);
  await viewer.until(() => window.pclExtViewer.moments() === 6);
  await viewer.locator(".time b", { hasText: "0.25 s" }).waitFor();
  await untilFrameDrawn(viewer, 5);
  await finish();
});

test("frames of one stream are moments of their own, however near they are", async () => {
  const { server, viewer, finish } = await liveViewer(streams.slice(0, 1));
  const ofFirst = frames.filter(({ stream }) => stream === 0).slice(0, 20);
  // Every fifth one comes late, nearer to the next one than half of the usual interval.
  for (const [i, frame] of ofFirst.entries())
    server.send({ ...frame, time: frame.time + (i % 5 === 4 ? 30_000_000n : 0n) });
  await untilVoxels(viewer, 0, decoded[0][19].length);
  await viewer.until(() => window.pclExtViewer.moments() === 20);
  await finish();
});

test("streams that a live source has no more are no longer drawn", async () => {
  const { server, viewer, finish } = await liveViewer();
  for (const frame of frames.slice(0, 2 * perFrame)) server.send(frame);
  await untilVoxels(viewer, 1, decoded[1][1].length);
  await viewer.keyboard.press("Space"); // also those that are held back
  for (const frame of frames.slice(2 * perFrame, 3 * perFrame)) server.send(frame);
  server.sendText({ type: "streams", streams: streams.slice(0, 1) });
  await viewer.locator(".stream-note", { hasText: "no longer has this stream" }).waitFor();
  await viewer.keyboard.press("Space");
  server.send(frames.find(({ stream }) => stream === 0));
  await untilVoxels(viewer, 0, decoded[0][0].length);
  assert.deepEqual(await drawnVoxels(viewer, 1), []);
  await finish();
});

test("a source that begins again with other intensities has an axis for them", async () => {
  const law = { intensity_law: "quadratic" };
  const other = pathInFolder("other");
  pclExt("demo", "-n", 2, "--sensors", 2, "--law", "quadratic", "-o", other, "-q");
  const { server, viewer, finish } = await liveViewer();
  for (const frame of frames.slice(0, 2 * perFrame)) server.send(frame);
  const ticks = () => viewer.locator(".threshold .ticks").innerText();
  await viewer.until(() => document.querySelector(".threshold .ticks").textContent !== "");
  const before = await ticks();
  const changed = framesOf(`${other}/cell.mcap`);
  server.sendText({ type: "streams", streams: streams.map((stream) => ({ ...stream, metadata: law })) });
  for (const frame of changed.frames) server.send(frame);
  await viewer.until((old) => document.querySelector(".threshold .ticks").innerText !== old, before);
  await finish();
});

test("Space keeps the picture of a live source, and goes on with the newest frame", async () => {
  const { server, viewer, finish } = await liveViewer();
  for (const frame of frames.slice(0, 3 * perFrame)) server.send(frame);
  await untilVoxels(viewer, 1, decoded[1][2].length);
  await viewer.keyboard.press("Space");
  await untilBadge(viewer, "Paused");
  for (const frame of frames.slice(3 * perFrame, 9 * perFrame)) server.send(frame);
  await viewer.until(() => window.pclExtViewer.moments() === 9);
  for (const stream of [0, 1]) assert.deepEqual(await drawnVoxels(viewer, stream), decoded[stream][2].map(keyOf).sort());
  await viewer.getByRole("button", { name: "Play" }).click();
  await untilFrameDrawn(viewer, 8);
  await finish();
});

test("a paused picture keeps its time and date where stamps begin again", async () => {
  const { server, viewer, finish } = await liveViewer(streams.slice(0, 1));
  const ofFirst = frames.filter(({ stream }) => stream === 0);
  const send = (first, last, seconds) => {
    for (const frame of ofFirst.slice(first, last)) server.send({ ...frame, time: frame.time + BigInt(seconds) * 1_000_000_000n });
  };
  const told = () => viewer.evaluate(() => document.querySelector(".times").innerText);
  send(0, 4, 1_700_000_100);
  await untilVoxels(viewer, 0, decoded[0][3].length);
  await viewer.until(() => window.pclExtViewer.moments() === 4);
  await viewer.until(() => /0\.15 s/.test(document.querySelector(".times").innerText));
  const before = await told();
  assert.match(before, /2023-11-14/);
  await viewer.keyboard.press("Space");
  send(0, 6, 1_700_000_000);
  await viewer.until(() => window.pclExtViewer.moments() === 6);
  await viewer.until(() => document.querySelector(".track").getAttribute("aria-valuemax") === "6");
  assert.equal(await told(), before);
  await viewer.keyboard.press("Space");
  await viewer.until((text) => document.querySelector(".times").innerText !== text, before);
  await finish();
});

test("a paused picture keeps streams that the source has no more, and tells of those that wait", async () => {
  const { server, viewer, finish } = await liveViewer();
  for (const frame of frames.slice(0, 3 * perFrame)) server.send(frame);
  await untilVoxels(viewer, 1, decoded[1][2].length);
  await viewer.keyboard.press("Space");
  const { name } = streams[1];
  server.sendText({ type: "streams", streams: [streams[0], { id: 2, name: "/another", metadata: {} }] });
  server.send({ ...frames.find(({ stream }) => stream === 1), stream: 2, time: frames[3 * perFrame].time });
  const note = (stream) => viewer.locator(".streams li", { hasText: stream });
  await note("another").getByText("Shown when the picture goes on").waitFor();
  await note(name.slice(1)).getByText("The source no longer has this stream").waitFor();
  assert.deepEqual(await drawnVoxels(viewer, 1), decoded[1][2].map(keyOf).sort());
  await viewer.keyboard.press("Space");
  await untilVoxels(viewer, 2, decoded[1][0].length);
  assert.deepEqual(await drawnVoxels(viewer, 1), []);
  await finish();
});
