// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Live sources that stop: no old picture looks like a new one.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { openViewer, startBrowser, stopBrowser, untilBadge } from "./support/browser.mjs";
import { cellRecording, pagePath } from "./support/fixtures.mjs";
import { framesOf, repeatFirst, serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

const { streams, frames } = framesOf(cellRecording());
const page = readFileSync(pagePath);

async function liveViewer() {
  const server = await serveLive(page, streams);
  const viewer = await openViewer({ url: server.url });
  for (let i = 0; i < 600 && server.viewers() === 0; ++i) await new Promise((resolve) => setTimeout(resolve, 50));
  const finish = async () => {
    await viewer.finish();
    await server.close();
  };
  return { server, viewer, finish };
}

const isStale = (viewer) => viewer.ask(() => document.querySelector(".stage").classList.contains("is-stale"));
const untilNothingComes = (viewer) => viewer.locator(".status .figure", { hasText: /^0\.0 kB\/s compressed$/ }).waitFor();

test("a stream that stops is told beside it and over the scene, and so are all of them", async () => {
  const { server, viewer, finish } = await liveViewer();
  const banner = viewer.locator(".live-banner");
  let stop = repeatFirst(server, frames, [0, 1]);
  await untilBadge(viewer, "Live");
  assert.doesNotMatch(await banner.textContent(), /No frames/);
  await viewer.locator(".status .figure", { hasText: /^(?!0\.0 ).*compressed/ }).waitFor(); // of the last two seconds
  stop();
  stop = repeatFirst(server, frames, [1]);
  await untilBadge(viewer, "1 of 2 live");
  assert.match(await banner.innerText(), /^No frames of cell_sensor_1 for \d+ s$/m);
  await viewer.locator(".streams li:first-child", { hasText: /No frames for \d+ s/ }).waitFor();
  assert.doesNotMatch(await viewer.locator(".streams li:last-child").innerText(), /No frames/);
  assert.equal(await isStale(viewer), false);
  stop();
  await untilBadge(viewer, "No frames");
  assert.match(await banner.innerText(), /^No frames for \d+ s$/m);
  await untilNothingComes(viewer);
  assert.equal(await isStale(viewer), true);
  stop = repeatFirst(server, frames, [0, 1]);
  await untilBadge(viewer, "Live");
  assert.doesNotMatch(await banner.textContent(), /No frames/);
  stop();
  server.sendText({ type: "end" });
  await untilBadge(viewer, "Ended");
  assert.equal(await isStale(viewer), false);
  await finish();
});

test("a page that is busy says that it is late, and takes neither streams nor the server for lost", async () => {
  const { server, viewer, finish } = await liveViewer();
  let stop = repeatFirst(server, frames, [0, 1]);
  const state = setInterval(() => server.sendText({ type: "state", problem: "", ages_ms: [0, 0] }), 1000).unref();
  await untilBadge(viewer, "Live");
  const told = await viewer.ask(async () => {
    const texts = new Set();
    const note = () => texts.add(document.querySelector(".live-banner").textContent);
    new MutationObserver(note).observe(document.querySelector(".live-banner"), { childList: true });
    for (const ms of [3500, 3500, 7500]) {
      for (const end = performance.now() + ms; performance.now() < end; );
      await new Promise((resolve) => setTimeout(resolve, 700));
    }
    return [...texts];
  });
  assert.deepEqual(told.filter((text) => text.includes("No frames")), []);
  assert.ok(told.some((text) => /too slow for these streams: it shows them [3-9]\.\d s late/.test(text)), told.join());
  assert.equal(await viewer.notice("warning").count(), 0);
  assert.equal(server.viewers(), 1);
  stop();
  stop = repeatFirst(server, frames, [1]);
  await untilBadge(viewer, "1 of 2 live");
  stop();
  clearInterval(state);
  await finish();
});

test("a wrong file that is opened leaves the live source as it is", async () => {
  const { server, viewer, finish } = await liveViewer();
  const stop = repeatFirst(server, frames, [0, 1]);
  await untilBadge(viewer, "Live");
  await viewer.setInputFiles("input[type=file]", { name: "a.txt", mimeType: "text/plain", buffer: Buffer.from("no recording") });
  await viewer.notice("error").filter({ hasText: "a.txt" }).waitFor();
  const numberThen = await viewer.ask(() => window.pclExtViewer.streams()[0].number);
  await viewer.until((before) => window.pclExtViewer.streams()[0].number > before + 1, numberThen);
  await untilBadge(viewer, "Live");
  assert.equal(await viewer.title(), "robot cell – pcl_ext viewer");
  stop();
  await finish();
});

test("a page that comes late knows how old the frames are that it gets", async () => {
  const { server, viewer, finish } = await liveViewer();
  server.sendText({ type: "state", problem: "", ages_ms: [3_700_000, 65_000] });
  const published_before = 2;
  for (const frame of frames.slice(0, streams.length)) server.send(frame, published_before);
  await viewer.locator(".live-banner", { hasText: /^No frames for 1 min \d+ s$/ }).waitFor();
  await untilBadge(viewer, "No frames");
  await viewer.locator(".streams li:first-child", { hasText: /No frames for 1 h \d+ min/ }).waitFor();
  await untilNothingComes(viewer);
  await finish();
});

test("what the server says is wrong with its source is shown until that is over", async () => {
  const { server, viewer, finish } = await liveViewer();
  const stop = repeatFirst(server, frames, [0, 1]);
  server.sendText({ type: "state", problem: "The connection of the site is lost", ages_ms: [] });
  await viewer.locator(".live-banner", { hasText: "The connection of the site is lost" }).waitFor();
  await untilBadge(viewer, "Problem");
  server.sendText({ type: "state", problem: "", ages_ms: [] });
  await untilBadge(viewer, "Live");
  stop();
  await finish();
});

test("a server that falls silent is lost, though its connection is open", async () => {
  const { server, viewer, finish } = await liveViewer();
  server.sendText({ type: "state", problem: "", ages_ms: [] });
  // In one step: the notice is there only until the page has connected again.
  await viewer.notice("warning").filter({ hasText: /connection is lost/ }).waitFor();
  await viewer.notice("warning").waitFor({ state: "detached" });
  await finish();
});
