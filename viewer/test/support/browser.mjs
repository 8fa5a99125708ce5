// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A browser and pages in it, for the tests.
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

import { pagePath } from "./fixtures.mjs";

const executablePath = process.env.PCL_EXT_CHROMIUM ?? "/usr/bin/chromium";
const patienceMs = 60_000;

// Whatever hangs, a file of tests ends.
setTimeout(() => {
  console.error("the tests of this file take more than 15 minutes");
  process.exit(1);
}, 15 * 60_000).unref();
let browser = null;

/** For tests that need the pixels. */
export const largeDesk = { viewport: { width: 1000, height: 700 } };
export const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };

export async function startBrowser() {
  browser = await chromium.launch({
    executablePath,
    args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"],
  });
}

export async function stopBrowser() {
  await browser?.close();
  browser = null;
}

/** A page for all tests of a file that begin with another recording: to open one takes two seconds. */
export let viewer = null;

export async function startViewer() {
  await startBrowser();
  viewer = await openViewer();
}

export async function stopViewer() {
  await viewer.finish();
  await stopBrowser();
}

/** Seconds of processor that the browser's processes took, by their type; 0 for those that do not run. */
export async function processorTimes() {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  const times = { renderer: 0, GPU: 0 };
  for (const { type, cpuTime } of processInfo) times[type] = (times[type] ?? 0) + cpuTime;
  return times;
}

/** A page of the viewer, as small as the layout of a desk may be, since the processor draws it; errors in it fail the
 * test when it is closed. */
export async function openViewer({ url = pathToFileURL(pagePath).href, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 500 }, colorScheme: "dark", ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(patienceMs);
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.stack));
  await page.goto(url);
  await page.waitForFunction(() => window.pclExtViewer !== undefined);
  return Object.assign(page, {
    async finish() {
      await context.close();
      assert.deepEqual(errors, [], "errors in the page");
    },
    ask: (expression) => page.evaluate(expression),
    until: (condition, argument) => page.waitForFunction(condition, argument),
    notice: (kind) => page.locator(`.notice.${kind}`),
  });
}

/** Chooses files, and waits until something is drawn. */
export async function openFiles(page, files) {
  await page.setInputFiles("input[type=file]", files);
  await page.until(() => !window.pclExtViewer.state().isOpening);
  await untilDrawn(page);
}

export async function untilDrawn(page) {
  await page.until(() => window.pclExtViewer.counts().all > 0);
}

/** Waits until so many streams are there, and voxels of each of them are drawn. */
export async function untilAllDrawn(page, streams) {
  await page.until((count) => {
    const all = window.pclExtViewer.streams();
    return all.length === count && all.every(({ voxels }) => voxels > 0);
  }, streams);
}

export async function untilIndexed(page) {
  await page.until(() => window.pclExtViewer.state().indexedShare === 1);
}

/** Waits until the page says so about the state of a live source. */
export async function untilBadge(page, text) {
  await page.until((wanted) => document.querySelector(".live-badge").textContent === wanted, text);
}

/** Shows a frame of a recording. */
export async function seek(page, moment) {
  await page.evaluate((at) => window.pclExtViewer.seek(at), moment);
}

/** A picture of the page as soon as two in a row are the same, as what was asked for is drawn some time later.
 * @param options of Playwright's screenshot
 */
export async function stillPicture(page, options) {
  // What was asked for is drawn before the second frame of the page begins.
  const twoFrames = () => page.ask(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))));
  const end = Date.now() + patienceMs;
  let before = Buffer.alloc(0);
  while (Date.now() < end) {
    await twoFrames();
    const picture = await page.screenshot(options);
    if (picture.equals(before)) return picture;
    before = picture;
  }
  throw new Error("the page never comes to rest");
}

/** The voxels of a stream as sorted texts, coordinates in millimetres. */
export async function drawnVoxels(page, stream) {
  const positions = await page.evaluate((index) => window.pclExtViewer.positions(index), stream);
  const voxels = [];
  for (let i = 0; i < positions.length; i += 3) voxels.push(keyOf(positions.slice(i, i + 3)));
  return voxels.sort();
}

export function keyOf([x, y, z]) {
  return [x, y, z].map((value) => Math.round(1000 * value)).join(",");
}
