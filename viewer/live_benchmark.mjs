// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Measures the page with live streams of 10 frames a second each.
 *
 *     PCL_EXT_PROGRAM=../build/tools/bin/pcl_ext node live_benchmark.mjs [STREAMS ...]
 *
 * The streams are those of the six sensors of robot cells that stand beside each other. Processor times are shares of one core, by
 * process of the browser: the page with its decoder, and the one that draws, which does so by software
 * where there is no GPU.
 */
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";

import { openViewer, processorTimes, startBrowser, stopBrowser } from "./test/support/browser.mjs";
import { pagePath, pathInFolder, pclExt } from "./test/support/fixtures.mjs";
import { framesOf, serveLive } from "./test/support/servers.mjs";

const sensors = 6;
const framesOfSensor = 20;
const cellsApart = 8; // metres
const cellsOfRow = 4;
const rate = 10; // Hz
const secondsToSettle = 5;
const secondsMeasured = 10;

const wait = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

/** A stream of each sensor of some cells, which stand beside each other: its name, metadata and frames. */
function cellStreams(cells) {
  const [made, clouds] = [pathInFolder("demo"), pathInFolder("clouds")];
  pclExt("demo", "-n", framesOfSensor, "--sensors", sensors, "-o", made, "-q");
  pclExt("decode", `${made}/cell.mcap`, "-o", clouds, "-q");
  const all = [];
  for (let cell = 0; cell < cells; ++cell) {
    const recording = pathInFolder(`cell_${cell}.mcap`);
    pclExt("encode", ...readdirSync(clouds).map((name) => join(clouds, name)), "-o", recording, "-r", 0.04, "-e", "fast", "--temporal-filter=8", "--i-frame-rate", framesOfSensor,
      "--pose", [cellsApart * (cell % cellsOfRow), cellsApart * Math.floor(cell / cellsOfRow), 0, 0, 0, 0].join(), "-q");
    const { streams, frames } = framesOf(recording);
    for (const { id, name, metadata } of streams)
      all.push({ name: `/cell_${cell}${name}`, metadata, frames: frames.filter(({ stream }) => stream === id) });
  }
  return all;
}

/** Sends frames at their rate, evenly, until it is told to stop. */
function startSending(server, streams) {
  const count = streams.length;
  const begin = performance.now();
  let sent = 0;
  const timer = setInterval(() => {
    const due = ((performance.now() - begin) / 1000) * rate * count;
    for (; sent < due; ++sent) {
      const cloud = Math.floor(sent / count);
      const { bytes } = streams[sent % count].frames[cloud % framesOfSensor];
      server.send({ stream: sent % count, time: BigInt(Math.round((cloud * 1e9) / rate)), bytes });
    }
  }, 5);
  return () => clearInterval(timer);
}

async function measure(streams) {
  const count = streams.length;
  const server = await serveLive(readFileSync(pagePath), streams.map(({ name, metadata }, id) => ({ id, name, metadata })));
  const stopSending = startSending(server, streams);
  const begin = performance.now();
  const page = await openViewer({ url: server.url, viewport: { width: 1440, height: 900 } });
  await page.until((all) => window.pclExtViewer.streams().filter(({ voxels }) => voxels > 0).length === all, count);
  const secondsToAll = (performance.now() - begin) / 1000;
  await wait(secondsToSettle);
  const look = async () => ({
    times: await processorTimes(),
    pictures: await page.ask(() => window.pclExtViewer.pictures()),
    frames: await page.ask(() => window.pclExtViewer.streams().reduce((sum, { number }) => sum + number, 0)),
    at: performance.now(),
  });
  const before = await look();
  await wait(secondsMeasured);
  const after = await look();
  stopSending();
  const voxels = await page.ask(() => window.pclExtViewer.counts().all);
  await page.finish();
  await server.close();
  const passed = (after.at - before.at) / 1000;
  const share = (type) => ((after.times[type] - before.times[type]) / passed).toFixed(2);
  return {
    streams: count,
    voxels,
    "first picture of all, s": secondsToAll.toFixed(1),
    "pictures a second": ((after.pictures - before.pictures) / passed).toFixed(1),
    "frames a second": ((after.frames - before.frames) / passed).toFixed(0),
    "page, cores": share("renderer"),
    "drawing, cores": share("GPU"),
  };
}

const asked = process.argv.slice(2).map(Number);
const counts = asked.length > 0 ? asked : [1, 6, 24, 60];
const streams = cellStreams(Math.ceil(Math.max(...counts) / sensors));
await startBrowser();
const rows = [];
for (const count of counts) rows.push(await measure(streams.slice(0, count)));
console.table(rows);
await stopBrowser();
