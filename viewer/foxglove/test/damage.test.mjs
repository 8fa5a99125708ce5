// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Damaged and foreign messages show nothing, and nothing else is wrong for them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { runInNewContext } from "node:vm";

import { isSame, messageOf, startApplication } from "./application.mjs";
import { cellStreams, randomNumbers, streamOf } from "./recordings.mjs";

const { frames, isIFrame, voxels } = streamOf(cellStreams("damaged", 1, 12, "--i-frame-rate", 6)[0]);

/** Shows all frames, some of them changed; returns which are shown, all of which must be those of the recording. */
function shownWith(changes) {
  const application = startApplication();
  const shown = frames.flatMap((frame, i) => {
    const cloud = application.convertNew("/points", messageOf(changes.get(i) ?? frame));
    if (cloud) assert.ok(isSame(cloud, voxels[i]), `frame ${i}`);
    return cloud ? [i] : [];
  });
  return { shown, alerts: application.alerts };
}

test("after a lost or damaged frame there is no new cloud until the next I-frame", () => {
  const random = randomNumbers(5);
  const changesOf = {
    flipped: (frame) => frame.map((byte, i) => (i === at(frame) ? byte ^ (1 << random(8)) : byte)),
    cut: (frame) => frame.slice(0, at(frame)),
    overwritten: (frame) => frame.slice().fill(0, at(frame)),
    empty: () => new Uint8Array(0),
  };
  const at = (frame) => random(frame.length);
  for (const [name, change] of Object.entries(changesOf))
    for (const damaged of [0, 2, 5, 6, 9])
      for (let round = 0; round < (name === "empty" ? 1 : 8); ++round) {
        const changed = change(frames[damaged]);
        if (Buffer.compare(changed, frames[damaged]) === 0) continue; // zeros over zeros
        const { shown, alerts } = shownWith(new Map([[damaged, changed]]));
        const next = isIFrame.indexOf(true, damaged + 1);
        const expected = [...frames.keys()].filter((i) => i < damaged || (next > 0 && i >= next));
        assert.deepEqual(shown, expected, `${name}, frame ${damaged}`);
        assert.ok(alerts.every(({ message, tip }) => message.endsWith(": /points") && tip.startsWith("/points: ")));
        assert.equal(alerts[0].severity, "warn");
      }
});

test("an intact copy of a damaged frame lets the stream go on", () => {
  const application = startApplication();
  for (const [i, frame] of frames.entries()) {
    const damaged = frame.slice();
    damaged[damaged.length >> 1] ^= 1;
    assert.equal(application.convertNew("/points", messageOf(damaged)), undefined);
    assert.ok(isSame(application.convert("/points", messageOf(frame)), voxels[i]));
  }
  assert.equal(new Set(application.alerts.map(({ id }) => id)).size, 1); // each takes the place of the one before
  for (const { message, tip } of application.alerts) {
    assert.equal(message, "Clouds missing: /points");
    assert.match(tip, /^\/points: .*checksum/);
  }
});

test("what is wrong is told again when another recording is open, whose list of alerts is empty", () => {
  const application = startApplication();
  const show = () => {
    application.clearAlerts();
    for (const frame of [frames[0], frames[1].slice(0, 40), frames[3], frames[4]]) application.convert("/points", messageOf(frame));
    application.convert("/draco", messageOf(frames[0], { format: "draco" }));
    return application.alerts.map(({ message, tip }) => [message, tip]);
  };
  const first = show();
  assert.deepEqual(first.map(([message]) => message),
    ["Clouds missing: /points", "Waiting for an I-frame: /points", "Clouds missing: /draco"]);
  assert.deepEqual(show().filter(([message]) => !message.startsWith("Shown again")), first);
});

test("clouds in other formats are left to others, and named once", () => {
  const application = startApplication();
  for (const format of ["draco", "draco", "pcl_extra", ""])
    assert.equal(application.convert(`/${format}`, messageOf(frames[0], { format })), undefined);
  assert.deepEqual(application.alerts.map(({ tip }) => tip.split(":")[0]), ["/draco", "/pcl_extra", "/"]);
  assert.ok(application.convert("/points", messageOf(frames[0], { format: "pcl_ext" })));
});

test("a message that is no CompressedPointCloud2 shows nothing, is told once, and disturbs no other topic", () => {
  const intact = messageOf(frames[0]);
  const detached = frames[0].slice();
  structuredClone(detached, { transfer: [detached.buffer] });
  const bytes = [undefined, null, "frame", [...frames[0]], frames[0].slice().buffer, new DataView(frames[0].slice().buffer),
    new Uint16Array(10), detached, new Uint8Array(0)];
  const malformed = [undefined, null, 5, {}, ...bytes.map((data) => ({ ...intact, compressed_data: data })),
    { ...intact, format: undefined }, { ...intact, header: undefined }, { ...intact, header: {} },
    { ...intact, header: { stamp: intact.header.stamp } }, { ...intact, header: { stamp: null, frame_id: "map" } }];
  const application = startApplication();
  assert.ok(application.convert("/intact", intact));
  for (const [i, message] of malformed.entries()) {
    for (let time = 0; time < 2; ++time) assert.equal(application.convert(`/${i}`, message), undefined, `message ${i}`);
    const next = application.convert("/intact", messageOf(frames[1 + (i % 5)]));
    assert.ok(isSame(next, voxels[1 + (i % 5)]), `after message ${i}`);
  }
  assert.deepEqual(application.alerts.map(({ tip }) => tip.split(":")[0]), malformed.map((_, i) => `/${i}`));
  for (const { tip } of application.alerts) assert.match(tip, /: a message has no (format|header|bytes)/);
});

test("bytes of other realms are bytes", () => {
  const data = runInNewContext("Uint8Array.from(bytes)", { bytes: [...frames[0]] });
  assert.ok(!(data instanceof Uint8Array));
  assert.ok(isSame(startApplication().convert("/points", messageOf(data)), voxels[0]));
});

test("of a message with several frames the first one is shown, as in the nodes, and the others are told", () => {
  const application = startApplication();
  assert.ok(application.convert("/points", messageOf(frames[0])));
  const both = Uint8Array.from([...frames[1], ...frames[2]]);
  for (let time = 0; time < 2; ++time) assert.ok(isSame(application.convert("/points", messageOf(both)), voxels[1]));
  assert.equal(application.convertNew("/points", messageOf(frames[3])), undefined);
  assert.ok(isSame(application.convert("/points", messageOf(frames[2])), voxels[2]));
  const tips = application.alerts.map(({ tip }) => tip);
  assert.equal(tips.length, 3);
  assert.equal(tips[0], "/points: a message has bytes beside its first frame, which are not shown");
  assert.match(tips[1], /^\/points: the last cloud is shown, that of /);
  assert.match(tips[2], /^\/points: an I-frame came/);
});

test("where the application takes no alerts they go to the console", (t) => {
  const warn = t.mock.method(console, "warn", () => undefined);
  const { converters } = startApplication();
  const message = messageOf(frames[0], { format: "draco" });
  assert.equal(converters[0].converter(message, { topic: "/points", message }), undefined);
  assert.equal(warn.mock.calls.length, 1);
});
