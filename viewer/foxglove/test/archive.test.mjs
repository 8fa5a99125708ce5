// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The archive that is installed, and the extension in a page of a browser. */
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { strFromU8 } from "fflate";
import { chromium } from "playwright-core";

import { pathInFolder } from "../../test/support/fixtures.mjs";
import { archivePath, inArchive, messageOf, ros1Name, ros2Name, startApplication } from "./application.mjs";
import { cellStreams, streamOf } from "./recordings.mjs";

test("it has what the applications read", () => {
  assert.deepEqual(Object.keys(inArchive), ["CHANGELOG.md", "LICENSE", "README.md", "dist/extension.js", "package.json"]);
  const { name, publisher, version, main } = JSON.parse(strFromU8(inArchive["package.json"]));
  assert.deepEqual([name, publisher, main], ["@pcl_ext/foxglove", "pcl_ext", "./dist/extension.js"]);
  assert.ok(strFromU8(inArchive["CHANGELOG.md"]).includes(`## ${version}`));
  assert.doesNotMatch(strFromU8(inArchive["README.md"]), /\]\(\.|!\[|^!/m); // files that are not in it
});

test("it has the same bytes when it is built again, also in another time zone", () => {
  const again = pathInFolder("again.foxe");
  const bundle = fileURLToPath(new URL("../bundle.mjs", import.meta.url));
  execFileSync(process.execPath, [bundle, again], { env: { ...process.env, TZ: "Asia/Kathmandu" } });
  assert.equal(Buffer.compare(readFileSync(again), readFileSync(archivePath)), 0);
});

test("it registers converters for the message's names in ROS 2 and ROS 1 before activate() returns", () => {
  const registered = startApplication().converters.map(({ converter, ...names }) => names);
  const toSchemaName = "foxglove.PointCloud";
  assert.deepEqual(registered, [ros2Name, ros1Name].map((fromSchemaName) => ({ type: "schema", fromSchemaName, toSchemaName })));
});

test("it compiles and converts at once in the main thread of a page", async (t) => {
  const { frames } = streamOf(cellStreams("browser", 1, 5)[0]);
  const application = startApplication();
  const hash = createHash("sha256");
  for (const frame of frames) hash.update(application.convert("/points", messageOf(frame)).data);
  const executablePath = process.env.PCL_EXT_CHROMIUM ?? "/usr/bin/chromium";
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  t.after(() => browser.close());
  const page = await browser.newPage();
  const found = await page.evaluate(
    async ({ source, frames }) => {
      const module = { exports: {} };
      new Function("module", "require", source)(module, () => undefined);
      const converters = [];
      module.exports.activate({ registerMessageConverter: (one) => converters.push(one) });
      const parts = frames.map((bytes) => {
        const message = {
          header: { stamp: { sec: 1, nsec: 0 }, frame_id: "map" },
          compressed_data: Uint8Array.from(bytes),
          format: "pcl_ext/version1",
        };
        return converters[0].converter(message, { topic: "/points", message }).data;
      });
      return Array.from(new Uint8Array(await new Blob(parts).arrayBuffer()));
    },
    { source: strFromU8(inArchive["dist/extension.js"]), frames: frames.map((frame) => [...frame]) },
  );
  assert.equal(createHash("sha256").update(Uint8Array.from(found)).digest("hex"), hash.digest("hex"));
});
