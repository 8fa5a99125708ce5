// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Makes the README's pictures of the viewer: doc/viewer.webp, which moves, and doc/viewer_page.webp.
// Usage: node viewer/pictures.mjs, with the groups `viewer` and `browser` of tools/packages.txt,
// after viewer/build.sh; PCL_EXT_PROGRAM as for the tests.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { openFiles, openViewer, seek, startBrowser, stopBrowser, untilIndexed } from "./test/support/browser.mjs";
import { cellRecording } from "./test/support/fixtures.mjs";

const doc = resolve(dirname(fileURLToPath(import.meta.url)), "../doc");
const frames = 50;
const sensors = 6;
const frameMs = 100;
const swing = 0.3; // radians, of the camera around what it looks at
const phases = [
  { removesOutliers: false },
  { removesOutliers: true, noise: "colour" },
  { removesOutliers: true, noise: "hide" },
];

async function openCell(viewport) {
  const page = await openViewer({ viewport });
  await openFiles(page, cellRecording(frames, sensors));
  await untilIndexed(page);
  return page;
}

/** The camera [x, y, z, target x, y, z], turned about the vertical through its target. */
function turned([x, y, z, tx, ty, tz, ...rest], angle, share) {
  const [dx, dy] = [x - tx, y - ty];
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const place = [tx + share * (cos * dx - sin * dy), ty + share * (sin * dx + cos * dy), tz + share * (z - tz)];
  return [...place, tx, ty, tz, ...rest];
}

async function movingPicture(folder) {
  const page = await openCell({ width: 1130, height: 640 });
  const camera = await page.evaluate(() => window.pclExtViewer.camera());
  const clip = await page.locator("canvas").first().boundingBox();
  const pictures = [];
  for (let i = 0; i < frames; ++i) {
    await page.evaluate((changes) => window.pclExtViewer.set(changes), phases[Math.floor((phases.length * i) / frames)]);
    const angle = -swing * Math.cos((2 * Math.PI * i) / frames);
    await page.evaluate((values) => window.pclExtViewer.setCamera(values), turned(camera, angle, 0.9));
    await seek(page, i);
    const path = join(folder, `${String(i).padStart(3, "0")}.png`);
    await page.screenshot({ path, clip });
    pictures.push(path);
  }
  await page.finish();
  const options = ["-loop", "0", "-lossy", "-q", "40", "-m", "6", "-d", String(frameMs)];
  execFileSync("img2webp", [...options, ...pictures, "-o", join(doc, "viewer.webp")]);
}

async function pictureOfThePage(folder) {
  const page = await openCell({ width: 1280, height: 800 });
  await page.evaluate((changes) => window.pclExtViewer.set(changes), { removesOutliers: true, noise: "colour" });
  await seek(page, frames / 2);
  const path = join(folder, "page.png");
  writeFileSync(path, await page.screenshot());
  await page.finish();
  execFileSync("cwebp", ["-quiet", "-q", "75", path, "-o", join(doc, "viewer_page.webp")]);
}

const folder = mkdtempSync(join(tmpdir(), "pcl_ext_pictures_"));
try {
  await startBrowser();
  await movingPicture(folder);
  await pictureOfThePage(folder);
} finally {
  await stopBrowser();
  rmSync(folder, { recursive: true, force: true });
}
process.exit(0);
