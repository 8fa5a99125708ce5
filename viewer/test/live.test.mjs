// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Live sources: connecting late, a server that goes and comes back, lost frames.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, keyOf, openViewer, startBrowser, stopBrowser, untilBadge } from "./support/browser.mjs";
import { cellRecording, decodedByProgram, pagePath } from "./support/fixtures.mjs";
import { framesOf, repeatFirst, serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

const recording = cellRecording();
const { streams, frames } = framesOf(recording);
const decoded = decodedByProgram(recording);
const page = readFileSync(pagePath);
const perFrame = streams.length;

/** Resolves when the condition holds on this side. */
async function until(condition) {
  for (let i = 0; i < 600 && !condition(); ++i) await new Promise((resolve) => setTimeout(resolve, 50));
  assert.ok(condition());
}

async function untilShown(viewer, numbers) {
  await viewer.until((wanted) => {
    const shown = window.pclExtViewer.streams().map(({ number }) => number);
    return wanted.every((number, i) => shown[i] === number);
  }, numbers);
}

async function assertShows(viewer, frame) {
  for (const stream of [0, 1])
    assert.deepEqual(await drawnVoxels(viewer, stream), decoded[stream][frame].map(keyOf).sort(), `frame ${frame}`);
}

test("live frames are shown as they come; a viewer that comes late begins with the next I-frame", async () => {
  const server = await serveLive(page, streams);
  const viewer = await openViewer({ url: server.url });
  await until(() => server.viewers() === 1);
  // Frames that cannot be decoded show nothing, and the page asks for I-frames.
  for (const frame of frames.slice(3 * perFrame, 4 * perFrame)) server.send(frame);
  await until(() => server.received.some((text) => text.includes("i-frame")));
  assert.deepEqual(JSON.parse(server.received[0]), { type: "i-frame", stream: 0 });
  assert.equal((await viewer.ask(() => window.pclExtViewer.counts())).all, 0);
  for (const frame of frames.slice(0, 5 * perFrame)) server.send(frame);
  await untilShown(viewer, [5, 5]);
  await assertShows(viewer, 4);
  assert.equal(await viewer.title(), "robot cell – pcl_ext viewer");
  const stop = repeatFirst(server, frames, [0, 1]);
  await untilBadge(viewer, "Live");
  stop();
  await viewer.finish();
  await server.close();
});

test("a lost frame never shows a wrong cloud: the stream is empty until the next I-frame", async () => {
  const server = await serveLive(page, streams);
  const viewer = await openViewer({ url: server.url });
  await until(() => server.viewers() === 1);
  for (const frame of frames.slice(0, 2 * perFrame)) server.send(frame);
  const [first, second] = [frames.slice(3 * perFrame, 4 * perFrame), frames.slice(2 * perFrame, 3 * perFrame)];
  for (const frame of [first.find(({ stream }) => stream === 0), second.find(({ stream }) => stream === 1)]) server.send(frame);
  await untilShown(viewer, [2, 2]);
  const shown = await viewer.ask(() => window.pclExtViewer.streams());
  assert.match(shown[0].problem, /frame/);
  assert.deepEqual(await drawnVoxels(viewer, 0), []);
  assert.deepEqual(await drawnVoxels(viewer, 1), decoded[1][2].map(keyOf).sort());
  await viewer.finish();
  await server.close();
});

test("when the server is gone the last frame stays, and the page finds the server when it is back", async () => {
  const server = await serveLive(page, streams);
  const viewer = await openViewer({ url: server.url });
  await until(() => server.viewers() === 1);
  for (const frame of frames.slice(0, 3 * perFrame)) server.send(frame);
  await untilShown(viewer, [2, 2]);
  await server.close();
  await viewer.notice("warning").waitFor();
  assert.match(await viewer.notice("warning").innerText(), /connection is lost/);
  await untilBadge(viewer, "Waiting");
  await assertShows(viewer, 2);
  const again = await serveLive(page, streams, server.port);
  await until(() => again.viewers() === 1);
  await viewer.notice("warning").waitFor({ state: "detached" });
  for (const frame of frames.slice(0, 6 * perFrame)) again.send(frame);
  await untilShown(viewer, [5, 5]);
  await assertShows(viewer, 5);
  again.sendText({ type: "end" });
  await viewer.notice("info").waitFor();
  assert.match(await viewer.notice("info").innerText(), /has ended/);
  await viewer.finish();
  await again.close();
});

test("messages that are none of the protocol harm nobody", async () => {
  const server = await serveLive(page, streams);
  const viewer = await openViewer({ url: server.url });
  await until(() => server.viewers() === 1);
  server.sendText({ type: "streams", streams: 7 });
  server.sendText([1, 2]);
  server.send({ stream: 99, time: 0n, bytes: Buffer.from("nobody") });
  server.send({ stream: 0, time: 0n, bytes: Buffer.from("no frame") });
  for (const frame of frames.slice(0, 2 * perFrame)) server.send(frame);
  await untilShown(viewer, [2, 1]);
  await assertShows(viewer, 1);
  await viewer.finish();
  await server.close();
});
