// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Takes pictures of the page to look at: on a desk and on a phone, light and dark.
// Usage: npm run screenshots [FOLDER]; by default build/screenshots.
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { openFiles, openViewer, phone, seek, startBrowser, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { cellRecording } from "./support/fixtures.mjs";

const folder = process.argv[2] ?? join("build", "screenshots");
const sizes = { desk: { viewport: { width: 1440, height: 900 } }, phone };

async function shootAll(size, colorScheme) {
  const page = await openViewer({ ...sizes[size], colorScheme });
  const set = (values) => page.evaluate((state) => window.pclExtViewer.set(state), values);
  const shoot = async (name) => {
    await page.waitForTimeout(600);
    await page.screenshot({ path: join(folder, `${size}_${colorScheme}_${name}.png`) });
  };
  await shoot("0_welcome");
  await openFiles(page, cellRecording(60, 6));
  await untilIndexed(page);
  await seek(page, 30);
  await shoot("1_raw");
  await set({ removesOutliers: true, noise: "colour" });
  await page.until(() => window.pclExtViewer.counts().kept < window.pclExtViewer.counts().all);
  await shoot("2_noise");
  await set({ threshold: 2, noise: "hide", colourBy: "height" });
  await shoot("3_denoised");
  await set({ colourBy: "stream", removesOutliers: false });
  await set(size === "phone" ? { showsPanel: true } : { showsHelp: true });
  await shoot("4_panel");
  await page.finish();
}

mkdirSync(folder, { recursive: true });
await startBrowser();
for (const size of Object.keys(sizes))
  for (const colorScheme of ["light", "dark"]) await shootAll(size, colorScheme);
await stopBrowser();
