// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Colours by fields of points and of voxels: what is offered, drawn and told.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { openFiles, openViewer, seek, startBrowser, stillPicture, stopBrowser, untilDrawn, untilIndexed } from "./support/browser.mjs";
import { cellRecording, cubeRecording, pagePath, pathInFolder, pclExt } from "./support/fixtures.mjs";
import { framesOf, serveLive } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

/** x, y, z, label, score, normal of points in a row of voxels of 1 m, the second of which has three. */
const clouds = [
  [[0.5, 0.5, 0.5, 10, "nan", "0 1"], [1.3, 0.5, 0.5, 30, 1, "1 2"], [1.6, 0.5, 0.5, 20, 2, "1 2"],
    [1.7, 0.5, 0.5, 20, 6, "4 2"], [2.5, 0.5, 0.5, 30, 1600000000.25, "3 -1"]],
  [[0.5, 0.5, 0.5, 10, -2, "0 1"], [1.3, 0.5, 0.5, 20, -1, "1 2"], [2.5, 0.5, 0.5, 12, 2, "3 -1"]],
];

function encode(name, ...options) {
  const paths = clouds.map((points, i) => {
    const path = pathInFolder(`${name.replace(/\..*/, "")}_${i}.pcd`);
    writeFileSync(path, ["VERSION .7", "FIELDS x y z label score normal", "SIZE 4 4 4 4 8 4", "TYPE F F F I F F",
      "COUNT 1 1 1 1 1 2", `WIDTH ${points.length}`, "HEIGHT 1", `POINTS ${points.length}`, "DATA ascii",
      ...points.map((point) => point.join(" ")), ""].join("\n"));
    return path;
  });
  pclExt("encode", ...paths, "-o", pathInFolder(name), "-r", 1, "--fields", "all", "-q", ...options);
  return pathInFolder(name);
}

const recording = encode("points.mcap", "--keep-points");

async function openRecording(path) {
  const page = await openViewer();
  await openFiles(page, path);
  await untilIndexed(page);
  return page;
}

const colourBy = (page) => page.getByRole("combobox", { name: "Colour by" });
const legend = async (page) => (await page.locator(".legend .ticks").innerText()).split("\n");
const values = (page, stream = 0) => page.evaluate((i) => window.pclExtViewer.fieldValues(i), stream);

/** Chooses a field, and waits until it is drawn. */
async function choose(page, name) {
  await colourBy(page).selectOption({ label: `Field ${name}` });
  await seek(page, 0);
}

/** Which of some colours (0 to 255) many pixels of the picture have. */
async function drawn(page, colours) {
  await page.evaluate(() => window.pclExtViewer.fit("top"));
  const picture = (await stillPicture(page, { clip: await page.locator("canvas.scene").boundingBox() })).toString("base64");
  return page.evaluate(async ({ base64, wanted }) => {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    return wanted.map((colour) => {
      let pixels = 0;
      for (let i = 0; i < data.length; i += 4)
        if (colour.every((value, channel) => Math.abs(data[i + channel] - value) <= 3)) ++pixels;
      return pixels > 500;
    });
  }, { base64: picture, wanted: colours });
}

/** Colours of the legend at shares of 0, 1/16 to 1. */
const legendColours = (page) => page.ask(() =>
  [...getComputedStyle(document.querySelector(".legend-bar")).backgroundImage.matchAll(/rgb\((\d+), (\d+), (\d+)\)/g)]
    .map((stop) => stop.slice(1).map(Number)));

const grey = [160, 160, 160];

for (const [what, path] of [["points", recording], ["voxels", encode("voxels.pcxi")]])
  test(`fields of ${what} are offered, and colour the voxels by their values`, async () => {
    const page = await openRecording(path);
    const offered = await colourBy(page).locator("option:not([hidden])").allInnerTexts();
    assert.deepEqual(offered.slice(-4), ["Field label", "Field score", "Field normal_0", "Field normal_1"]);
    for (const [field, expected, ticks] of [
      ["label", [10, 20, 30], ["10", "20", "30"]],
      ["normal_0", [0, 2, 3], ["0", "2", "3"]],
      ["normal_1", [1, 2, -1], ["-1", "1", "2"]],
      ["score", [NaN, 3, 1600000000.25], ["3", "800,000,002", "1,600,000,000"]],
    ]) {
      await choose(page, field);
      assert.deepEqual(await values(page), expected, field);
      assert.deepEqual(await legend(page), ticks);
    }
    const colours = await legendColours(page);
    assert.deepEqual(await drawn(page, [grey, colours[0], colours[8], colours[16]]), [true, true, false, true]);
    await choose(page, "label");
    assert.deepEqual(await drawn(page, [grey, colours[0], colours[8], colours[16]]), [false, true, true, true]);
    await seek(page, 1);
    assert.deepEqual(await values(page), [10, 20, 12]);
    assert.deepEqual(await legend(page), ["10", "15", "20"]);
    assert.deepEqual(await drawn(page, [colours[0], colours[8], colours[16]]), [true, false, true]);
    await page.finish();
  });

test("a click tells the value exactly, and other colours leave the field out", async () => {
  const page = await openRecording(recording);
  await choose(page, "score");
  await page.evaluate(() => window.pclExtViewer.fit("top"));
  const box = await page.locator("canvas.scene").boundingBox();
  const details = page.getByLabel("Selected voxel");
  const told = new Set();
  for (let i = 0; i < 400 && told.size < 3; ++i) {
    await page.mouse.click(box.x + box.width * (0.2 + 0.03 * (i % 20)), box.y + box.height * (0.2 + 0.03 * Math.floor(i / 20)));
    if (await details.isVisible()) told.add(/Field score\n(.*)/.exec(await details.innerText())[1]);
  }
  assert.deepEqual([...told].sort(), ["1600000000.25", "3", "NaN"]);
  await page.keyboard.press("2");
  await page.until(() => window.pclExtViewer.fieldValues(0) === null);
  await page.finish();
});

test("a link has the field; streams without it are grey, and recordings without it have another colour", async () => {
  const page = await openViewer({ url: `${new URL(`file://${pagePath}`).href}#colour=field:label` });
  const other = cubeRecording(5).path;
  await openFiles(page, [encode("linked.pcxi"), other]);
  await page.until(() => window.pclExtViewer.streams().length === 2 && window.pclExtViewer.streams().every(({ voxels }) => voxels > 0));
  assert.equal(await colourBy(page).inputValue(), "field:label");
  const found = [await values(page, 0), await values(page, 1)];
  assert.deepEqual(found.sort(), [[10, 20, 30], null]);
  await page.getByLabel("linked").uncheck();
  assert.deepEqual(await legend(page), ["no values"]);
  assert.deepEqual(await drawn(page, [grey]), [true]);
  await openFiles(page, other);
  await page.until(() => window.pclExtViewer.state().colourBy !== "field:label");
  assert.equal(await colourBy(page).locator("option", { hasText: "Field" }).count(), 0);
  await page.finish();
});

test("after a recording with colours alone one without them has the colours of its intensities", async () => {
  const cloud = pathInFolder("coloured.pcd");
  writeFileSync(cloud, ["VERSION .7", "FIELDS x y z rgb", "SIZE 4 4 4 4", "TYPE F F F U", "COUNT 1 1 1 1", "WIDTH 1",
    "HEIGHT 1", "POINTS 1", "DATA ascii", `1 2 3 ${0x00ff00}`, ""].join("\n"));
  pclExt("encode", cloud, "-o", pathInFolder("coloured.mcap"), "-q");
  const page = await openRecording(pathInFolder("coloured.mcap"));
  await page.until(() => window.pclExtViewer.state().colourBy === "recorded");
  await openFiles(page, cellRecording());
  await page.until(() => window.pclExtViewer.state().colourBy === "intensity");
  await page.finish();
});

test("a live source has its fields, too", async () => {
  const { streams, frames } = framesOf(recording);
  const source = await serveLive(readFileSync(pagePath), streams);
  const page = await openViewer({ url: source.url });
  await page.until(() => window.pclExtViewer.streams().length === 1);
  source.send(frames[0]);
  await untilDrawn(page);
  await colourBy(page).selectOption("field:label");
  source.send(frames[1]);
  await page.until(() => window.pclExtViewer.fieldValues(0)?.[2] === 12);
  assert.deepEqual(await legend(page), ["10", "15", "20"]);
  await page.finish();
  await source.close();
});

test("an exported PLY file has the field that is drawn, and no intensity where there is none", async () => {
  const page = await openRecording(encode("exported.pcxi"));
  const exported = async () => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "PLY" }).click()]);
    const bytes = readFileSync(await download.path());
    const begin = bytes.indexOf("end_header\n") + 11;
    return { properties: bytes.toString("latin1", 0, begin).match(/(?<=^property )[a-z]+ .*$/gm), body: bytes.subarray(begin) };
  };
  const bare = ["float x", "float y", "float z", "ushort stream"];
  await colourBy(page).selectOption("height");
  await page.until(() => window.pclExtViewer.fieldValues(0) === null);
  const { properties, body } = await exported();
  assert.deepEqual(properties, bare);
  assert.equal(body.length, 3 * 14);
  await choose(page, "normal_1");
  const coloured = await exported();
  assert.deepEqual(coloured.properties, [...bare, "double normal_1"]);
  assert.deepEqual([0, 1, 2].map((i) => coloured.body.readDoubleLE(22 * i + 14)), [1, 2, -1]);
  await page.finish();
});
