// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** The names of a cloud's fields, each of which is there once. */
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { crc32 } from "@foxglove/crc";

import { pathInFolder, pclExt } from "../../test/support/fixtures.mjs";
import { fieldsOf, messageOf, startApplication } from "./application.mjs";

/** The frame of one point with fields, [name, type, values...], by the name of its files. */
function frameOf(name, fields, ...options) {
  const all = [..."xyz"].map((axis) => [axis, "F4", 0.5]).concat(fields);
  const line = (key, of) => `${key} ${all.map(of).join(" ")}`;
  const [cloud, frame] = [".pcd", ".pcxi"].map((extension) => pathInFolder(name + extension));
  const head = ["VERSION .7", line("FIELDS", ([field]) => field), line("SIZE", ([, type]) => type[1]),
    line("TYPE", ([, type]) => type[0]), line("COUNT", ([, , ...values]) => values.length), "WIDTH 1", "HEIGHT 1",
    "POINTS 1", "DATA ascii"];
  writeFileSync(cloud, [...head, all.flatMap(([, , ...values]) => values).join(" "), ""].join("\n"));
  pclExt("encode", cloud, "-o", frame, "-r", 0.1, "--fields", "all", "-q", ...options);
  return readFileSync(frame);
}

/** An I-frame with another name of a field, of the same length, as another writer may have made it. */
function renamed(frame, from, to) {
  const at = frame.indexOf(from, 0, "latin1");
  assert.ok(at > 9 && frame.indexOf(from, at + 1, "latin1") < 0);
  const changed = Buffer.from(frame);
  changed.write(to, at, "latin1");
  changed.writeUInt32LE(crc32(Buffer.concat([Buffer.alloc(4), changed.subarray(9)])), 5);
  return changed;
}

/** The names of the shown fields, and the value of each. */
function shown(frame) {
  const application = startApplication();
  const cloud = application.convert("/points", messageOf(new Uint8Array(frame)));
  assert.deepEqual(application.alerts, []);
  assert.equal(Object.keys(fieldsOf(cloud)).length, cloud.fields.length);
  return Object.fromEntries(Object.entries(fieldsOf(cloud)).map(([name, [value]]) => [name, value]));
}

test("of the names of colours, parts and numbers of points each is there once", () => {
  const fields = [["normal", "F4", 1, 2, 3], ["normal_1", "I1", 77], ["red", "F4", 0.25], ["alpha", "F8", -1.5],
    ["point_count", "U2", 999], ["rgb", "U4", (10 << 16) | (20 << 8) | 30]];
  const { x, y, z, red, green, blue, ...others } = shown(frameOf("names", fields, "--law", "none", "--keep-points"));
  assert.ok([x, y, z].every((coordinate) => Math.abs(coordinate - 0.5) < 0.051));
  assert.ok([red, green, blue].every((value, i) => Math.abs(value - 10 * (i + 1)) < 5), `${red} ${green} ${blue}`);
  assert.deepEqual(others, { alpha: 255, point_count: 1, normal_0: 1, normal_1: 2, normal_2: 3, normal_1_: 77, red_: 0.25,
    alpha_: -1.5, point_count_: 999 });
});

test("names of further fields that repeat those of coordinates or each other", () => {
  const fields = [["Q", "U1", 7], ["first", "U1", 1], ["other", "U2", 1000], ["again", "I1", -3]];
  let frame = frameOf("repeated", fields, "--law", "none");
  for (const [from, to] of [["\x01Q", "\x01x"], ["other", "first"], ["again", "first"]]) frame = renamed(frame, from, to);
  const { x, y, z, ...others } = shown(frame);
  assert.ok(Math.abs(x - 0.5) < 0.051);
  assert.deepEqual(others, { x_: 7, first: 1, first_: 1000, first__: -3 });
});

test("a field takes the place of an intensity of its name, a second one does not", () => {
  const fields = [["intensity", "U2", 60000], ["somewhere", "I1", -3]];
  const frame = renamed(frameOf("intensity", fields, "--law", "count"), "somewhere", "intensity");
  const { x, y, z, ...others } = shown(frame);
  assert.deepEqual(others, { intensity: 60000, intensity_: -3 });
});
