// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Whatever order messages come in, a cloud that is shown is that of its message, or the last one with its own time. */
import assert from "node:assert/strict";
import { test } from "node:test";

import { pathInFolder, pclExt } from "../../test/support/fixtures.mjs";
import { isSame, messageOf, ros1Name, ros2Name, startApplication } from "./application.mjs";
import { cellStreams, codec, randomNumbers, streamOf } from "./recordings.mjs";

const [first, second] = cellStreams("cell", 2, 60, "--i-frame-rate", 12).map(streamOf);

/** Which frames of a stream are to be shown, in words: those that the last one leads to, I-frames, and repeated ones. */
class Expectation {
  #last = -1;
  #recent = [];

  constructor(stream) {
    this.stream = stream;
  }

  /** The frame that was decoded last, which is kept while others are not shown; -1: none. */
  get last() {
    return this.#last;
  }

  isShown(i) {
    if (this.#recent.includes(i)) return true;
    if (!this.stream.isIFrame[i] && this.#last !== i - 1) return false;
    this.#last = i;
    this.#recent = [i, ...this.#recent].slice(0, 8);
    return true;
  }
}

/** Checks what an application shows of a frame: its cloud, or the last one with the time and frame_id that that one had. */
function check(application, topic, expectation, i) {
  const { frames, voxels } = expectation.stream;
  const cloud = application.convert(topic, messageOf(frames[i], { sec: i, nsec: 7, frameId: `frame_${i}` }));
  const isShown = expectation.isShown(i);
  const shown = isShown ? i : expectation.last;
  assert.equal(cloud !== undefined, shown >= 0, `frame ${i} of ${topic}`);
  if (shown < 0) return isShown;
  assert.deepEqual([cloud.timestamp, cloud.frame_id], [{ sec: shown, nsec: 7 }, `frame_${shown}`]);
  assert.ok(isSame(cloud, voxels[shown]), `frame ${i} of ${topic}`);
  return isShown;
}

test("the recording has frames of both kinds", () => {
  assert.equal(first.frames.length, 60);
  assert.deepEqual(first.isIFrame.flatMap((is, i) => (is ? [i] : [])), [0, 12, 24, 36, 48]);
});

for (const schemaName of [ros2Name, ros1Name])
  test(`forward, as ${schemaName}`, () => {
    const application = startApplication();
    for (const [i, frame] of first.frames.entries()) {
      const cloud = application.convert("/points", messageOf(frame, { sec: i, nsec: 5, frameId: "lidar" }), schemaName);
      assert.deepEqual([cloud.timestamp, cloud.frame_id], [{ sec: i, nsec: 5 }, "lidar"]);
      assert.ok(isSame(cloud, first.voxels[i]));
    }
    assert.deepEqual(application.alerts, []);
  });

test("200 random seeks: the last cloud until the next I-frame, which is told once, then all", () => {
  const application = startApplication();
  const expectation = new Expectation(first);
  const random = randomNumbers(1);
  let shown = 0;
  let hidden = 0;
  let isWaiting = false;
  const expected = []; // severities of the alerts
  for (let seek = 0; seek < 200; ++seek) {
    const begin = random(first.frames.length);
    const end = Math.min(first.frames.length, begin + 1 + random(20));
    for (let i = begin; i < end; ++i) {
      const isShown = check(application, "/points", expectation, i);
      isShown ? ++shown : ++hidden;
      // One alert for each gap, which takes the place of that of the gap before, and one when the gap is over.
      if (isShown === isWaiting) expected.push(isShown ? "info" : "warn");
      isWaiting = !isShown;
      assert.equal(application.alerts.length, expected.length, `frame ${i} after seek ${seek}`);
    }
  }
  assert.ok(shown > 500 && hidden > 500, `${shown} shown, ${hidden} not`);
  assert.deepEqual(application.alerts.map(({ severity }) => severity), expected);
  assert.equal(new Set(application.alerts.map(({ id }) => id)).size, 1);
  assert.match(application.alerts.find(({ severity }) => severity === "warn").message, /^Waiting for an I-frame: \/points$/);
});

test("a seek into a recording of which nothing was shown is told, too", () => {
  const application = startApplication();
  assert.equal(application.convert("/points", messageOf(first.frames[30])), undefined);
  assert.equal(application.convert("/points", messageOf(first.frames[31])), undefined);
  assert.deepEqual(application.alerts.map(({ message }) => message), ["Waiting for an I-frame: /points"]);
  assert.match(application.alerts[0].tip, /^\/points: there is nothing to show/);
});

test("the time of the last cloud is told, whatever it is", () => {
  const application = startApplication();
  const times = [[1700000000, 500000000, /that of 2023-11-14T22:13:20\.500Z\./], [0, 0, /that of 1970-01-01T/], [1e300, 0, /that of 1e\+300 s\./]];
  for (const [i, [sec, nsec, expected]] of times.entries()) {
    assert.ok(application.convert("/points", messageOf(first.frames[12 * i], { sec, nsec })));
    application.clearAlerts();
    assert.equal(application.convert("/points", messageOf(first.frames[30])).timestamp.sec, sec);
    assert.match(application.alerts[0].tip, expected);
  }
});

test("where applications have no alerts, the console is told once of each topic", (t) => {
  const warn = t.mock.method(console, "warn", () => undefined);
  const { converters } = startApplication();
  for (const i of [0, 30, 48, 5, 12, 40]) {
    const message = messageOf(first.frames[i]);
    assert.ok(converters[0].converter(message, { topic: "/points", message }));
  }
  assert.equal(warn.mock.calls.length, 1);
  assert.match(warn.mock.calls[0].arguments[0], /^\/points: waiting for an I-frame; until then the last cloud is shown/);
});

test("several panels convert the same messages, one after the other", () => {
  const application = startApplication();
  const expectation = new Expectation(first);
  for (let begin = 0; begin < first.frames.length; begin += 5)
    for (let panel = 0; panel < 3; ++panel)
      for (let i = begin; i < begin + 5; ++i) assert.ok(check(application, "/points", expectation, i));
});

test("a repeated message has the header that it came with", () => {
  const application = startApplication();
  application.convert("/points", messageOf(first.frames[0]));
  const again = application.convert("/points", messageOf(first.frames[0], { sec: 9, frameId: "odom" }));
  assert.deepEqual([again.timestamp.sec, again.frame_id], [9, "odom"]);
});

test("a cloud whose bytes a panel transferred is decoded again, or not shown, but is not empty", () => {
  const application = startApplication();
  const { frames, voxels } = first;
  const transfer = ({ data }) => structuredClone(data, { transfer: [data.buffer] });
  for (const i of [0, 1, 2]) transfer(application.convert("/points", messageOf(frames[i])));
  assert.equal(application.convert("/points", messageOf(frames[2])), undefined);
  for (const i of [0, 1, 2, 3]) assert.ok(isSame(application.convert("/points", messageOf(frames[i])), voxels[i]));
  assert.deepEqual(application.alerts.map(({ severity }) => severity), ["warn", "info"]);
});

test("a consumer that reads ahead while another one plays", () => {
  const application = startApplication();
  const expectation = new Expectation(first);
  const random = randomNumbers(2);
  const places = [0, 30];
  for (let step = 0; step < 200; ++step) {
    const consumer = random(2);
    for (let count = 1 + random(6); count > 0; --count)
      check(application, "/points", expectation, places[consumer]++ % first.frames.length);
  }
});

test("two topics do not disturb each other", () => {
  const application = startApplication();
  const expectations = [new Expectation(first), new Expectation(second)];
  const random = randomNumbers(3);
  const next = [0, 0];
  while (next.some((i) => i < 60)) {
    const topic = random(2);
    if (next[topic] < 60) assert.ok(check(application, `/points_${topic}`, expectations[topic], next[topic]++));
  }
});

/** Shows frames of several streams on one topic; counts those that are shown and those that are not. */
function showMixed(streams, order) {
  const application = startApplication();
  const counts = { shown: 0, hidden: 0 };
  for (const [stream, i] of order) {
    const cloud = application.convertNew("/points", messageOf(streams[stream].frames[i]));
    ++counts[cloud ? "shown" : "hidden"];
    if (cloud) assert.ok(isSame(cloud, streams[stream].voxels[i]), `frame ${i} of stream ${stream}`);
  }
  return counts;
}

test("two recordings with the same numbers, in turn on one topic", () => {
  const streams = [first, second];
  const numbersOf = ({ frames }) => frames.map((frame) => codec.describeFrame(frame).description.frameNumber);
  assert.deepEqual(numbersOf(first), numbersOf(second));
  const turns = Array.from({ length: 120 }, (_, k) => [k % 2, k >> 1]);
  // The second one's I-frames come last, so that it goes on from them; of the first one there are I-frames alone.
  assert.deepEqual(showMixed(streams, turns), { shown: 65, hidden: 55 });
  const random = randomNumbers(4);
  const { shown, hidden } = showMixed(streams, Array.from({ length: 400 }, () => [random(2), random(60)]));
  assert.ok(shown > 30 && hidden > 300, `${shown} shown, ${hidden} not`);
});

test("two recordings with the same I-frame that differ afterwards", () => {
  const clouds = pathInFolder("clouds");
  pclExt("decode", cellStreams("parts", 1, 6)[0], "-o", clouds, "--pcd", "binary", "-q");
  const encode = (name, ...numbers) => {
    const path = pathInFolder(`${name}.pcxi`);
    const files = numbers.map((i) => `${clouds}/${String(i).padStart(6, "0")}.pcd`);
    pclExt("encode", ...files, "-o", path, "-r", 0.04, "--no-header", "-q");
    return streamOf(path);
  };
  const streams = [encode("original", 0, 1, 2, 3, 4, 5), encode("changed", 0, 2, 1, 3, 4, 5)];
  assert.deepEqual(streams[0].frames[0], streams[1].frames[0]);
  assert.equal(streams[0].frames.length, 6);
  for (let from = 1; from < 5; ++from) {
    const order = [...Array(from + 1).keys()].map((i) => [0, i]);
    for (let i = from + 1; i < 6; ++i) order.push([1, i]);
    assert.deepEqual(showMixed(streams, order), { shown: from + 1, hidden: 5 - from });
  }
});

test("of the published layout, whose P-frames name no reference, I-frames alone", () => {
  const application = startApplication();
  const [path] = cellStreams("published", 1, 20, "--format", "published", "--i-frame-rate", 5);
  const { frames, isIFrame, voxels } = streamOf(path);
  for (const [i, frame] of frames.entries()) {
    const cloud = application.convertNew("/points", messageOf(frame, { format: "pcl_ext/published" }));
    assert.equal(cloud !== undefined, isIFrame[i]);
    if (cloud) assert.ok(isSame(cloud, voxels[i]));
  }
  assert.ok(isIFrame.includes(true) && isIFrame.includes(false));
  assert.deepEqual(application.alerts.map(({ severity }) => severity), ["warn"]);
});
