// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Phones, keyboards, contrast, browsers without what the page needs.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { openFiles, openViewer, phone, seek, startBrowser, stillPicture, stopBrowser, untilIndexed } from "./support/browser.mjs";
import { contrastProblems } from "./support/contrast.mjs";
import { cellRecording } from "./support/fixtures.mjs";

before(startBrowser);
after(stopBrowser);

test("on a phone nothing is wider than the screen, and all controls can be reached", async () => {
  const page = await openViewer(phone);
  await openFiles(page, cellRecording());
  const width = await page.ask(() => document.scrollingElement.scrollWidth);
  assert.equal(width, 390);
  await page.getByRole("button", { name: "Settings" }).tap();
  for (const name of ["Colour by", "Voxel size"]) {
    const control = page.getByRole(name === "Colour by" ? "combobox" : "slider", { name });
    await control.scrollIntoViewIfNeeded();
    const box = await control.boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= 390 && box.y + box.height <= 844, name);
  }
  await page.getByLabel("Outlier filter").tap();
  assert.equal(await page.ask(() => window.pclExtViewer.state().removesOutliers), true);
  await page.getByRole("button", { name: "Settings" }).tap();
  for (const name of ["Play", "Step forward", "Last frame"]) {
    const box = await page.getByRole("button", { name, exact: true }).boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= 390 && box.y + box.height <= 844, name);
    assert.ok(box.width >= 32 && box.height >= 32, name);
  }
  await page.finish();
});

for (const [where, options] of [["a desk", { viewport: { width: 1440, height: 900 } }], ["a phone", phone]])
  test(`on ${where} the panel names the settings that lie below its edge, until they are reached`, async () => {
    const page = await openViewer(options);
    await openFiles(page, cellRecording(20, 6));
    if (where === "a phone") await page.getByRole("button", { name: "Settings" }).tap();
    const more = page.getByRole("button", { name: "More below" });
    await more.waitFor();
    assert.match(await more.innerText(), /Keep/i);
    const box = await more.boundingBox();
    const panel = await page.locator(".panel").boundingBox();
    assert.ok(Math.abs(box.y + box.height - panel.y - panel.height) < 1, "at the panel's edge");
    await more.click();
    await page.until(() => document.querySelector(".panel").scrollTop > 0);
    // Clicks by Playwright would wait for a button that goes while the panel scrolls.
    await page.waitForFunction(() => {
      const button = document.querySelector(".more-below.is-needed");
      button?.click();
      return button === null;
    }, undefined, { polling: 500 });
    assert.equal(await more.count(), 0);
    const last = await page.getByRole("button", { name: "Copy link" }).boundingBox();
    assert.ok(last.y + last.height <= panel.y + panel.height);
    await page.finish();
  });

test("the panel scrolls to them at once for those who prefer reduced motion", async () => {
  const page = await openViewer({ viewport: { width: 1440, height: 900 } });
  await openFiles(page, cellRecording(20, 6));
  await page.getByRole("button", { name: "More below" }).waitFor();
  for (const reducedMotion of ["no-preference", "reduce"]) {
    await page.emulateMedia({ reducedMotion });
    const way = await page.ask(() => {
      const panel = document.querySelector(".panel");
      panel.scrollTo({ top: 0, behavior: "instant" });
      document.querySelector(".more-below").click();
      return panel.scrollTop;
    });
    assert.equal(way > 0, reducedMotion === "reduce");
  }
  await page.finish();
});

test("where all settings are in sight the panel has no such sign", async () => {
  const page = await openViewer({ viewport: { width: 1440, height: 1200 } });
  await openFiles(page, cellRecording());
  await stillPicture(page); // as the panel grows with what the recording has
  assert.equal(await page.getByRole("button", { name: "More below" }).count(), 0);
  await page.finish();
});

test("all of it works by keyboard, with the focus visible", async () => {
  const page = await openViewer();
  await openFiles(page, cellRecording());
  await untilIndexed(page);
  const state = () => page.ask(() => window.pclExtViewer.state());
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  assert.equal((await state()).moment, 2);
  await page.keyboard.press("End");
  assert.equal((await state()).moment, 19);
  await page.keyboard.press("Space");
  assert.equal((await state()).isPlaying, true);
  await page.keyboard.press("Space");
  for (let i = 0; i < 3; ++i) await page.keyboard.press("]");
  assert.equal((await state()).threshold, 3);
  await page.keyboard.press("2");
  assert.equal((await state()).colourBy, "height");
  const before = await page.ask(() => window.pclExtViewer.camera());
  await page.keyboard.press("a");
  assert.notDeepEqual(await page.ask(() => window.pclExtViewer.camera()), before);
  await page.keyboard.press("?");
  assert.equal(await page.getByRole("dialog").isVisible(), true);
  await page.keyboard.press("Escape");
  assert.equal(await page.getByRole("dialog").isVisible(), false);

  const reached = new Set();
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("Tab");
    const focused = await page.ask(() => {
      const element = document.activeElement;
      const shown = element.closest(".segments")
        ? element.nextElementSibling : element; // radio buttons lie under their labels
      const style = getComputedStyle(shown);
      return {
        name: element.getAttribute("aria-label") ?? element.labels?.[0]?.innerText ?? element.innerText,
        hasOutline: element === document.body || (style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2),
      };
    });
    assert.ok(focused.hasOutline, `${focused.name} has the focus, but does not show it`);
    reached.add(focused.name?.trim());
  }
  for (const name of ["Intensity threshold", "Time", "Colour by", "Outlier filter", "cell_sensor_2", "Play", "PLY", "Open", "Keys and help"])
    assert.ok([...reached].some((text) => text?.includes(name)), `${name} cannot be reached by Tab: ${[...reached]}`);

  await page.getByRole("slider", { name: "Intensity threshold" }).focus();
  await page.keyboard.press("ArrowLeft");
  assert.equal((await state()).threshold, 2);
  await page.finish();
});

test("the threshold that is typed is told as it holds, within the scale", async () => {
  const page = await openViewer();
  await openFiles(page, cellRecording());
  const number = page.getByLabel("Intensity threshold as a number");
  const slider = page.getByRole("slider", { name: "Intensity threshold" });
  const highest = await slider.getAttribute("aria-valuemax");
  for (const [typed, told] of [["5", "5"], ["1000000", highest], ["2000000", highest], ["", highest], ["-3", "0"]]) {
    await number.fill(typed);
    await number.press("Enter");
    assert.equal(await number.inputValue(), told, typed);
    assert.equal(await page.ask(() => window.pclExtViewer.state().threshold), Number(told), typed);
  }
  await page.finish();
});

test("texts and controls have the contrast of WCAG AA, light and dark", async () => {
  const page = await openViewer();
  const expectContrast = async () => {
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await page.until((wanted) => document.documentElement.dataset.theme === wanted, colorScheme);
      assert.deepEqual(await page.evaluate(contrastProblems), [], colorScheme);
    }
  };
  await expectContrast();
  await openFiles(page, cellRecording());
  await page.evaluate(() => window.pclExtViewer.set({ removesOutliers: true, noise: "colour" }));
  await expectContrast();
  await page.keyboard.press("?");
  await expectContrast();
  await page.finish();
});

test("the theme can be switched, whatever the system prefers", async () => {
  const page = await openViewer({ colorScheme: "light" });
  const theme = () => page.ask(() => document.documentElement.dataset.theme);
  assert.equal(await theme(), "light");
  await page.getByRole("button", { name: "Light or dark" }).click();
  assert.equal(await theme(), "dark");
  await page.finish();
});

test("without WebGL or WebAssembly the page says so", async () => {
  for (const [missing, expected] of [
    ["WebAssembly", /does not run WebAssembly/],
    ["webgl", /draws no 3D graphics/],
  ]) {
    const page = await openViewer();
    await page.addInitScript((what) => {
      if (what === "WebAssembly") delete window.WebAssembly;
      else HTMLCanvasElement.prototype.getContext = () => null;
    }, missing);
    await page.reload();
    await page.getByRole("alert").waitFor();
    assert.match(await page.getByRole("alert").innerText(), expected);
    await page.finish();
  }
});

test("where workers are refused the page decodes by itself", async () => {
  const page = await openViewer();
  await page.addInitScript(() => {
    window.Worker = class {
      constructor() {
        throw new Error("refused");
      }
    };
  });
  await page.reload();
  await page.until(() => window.pclExtViewer !== undefined);
  await openFiles(page, cellRecording());
  await untilIndexed(page);
  await seek(page, 9);
  assert.ok((await page.ask(() => window.pclExtViewer.counts())).all > 10_000);
  await page.finish();
});
