// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Many topics and large clouds: what they take is bounded, and one does not disturb another. */
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";

import { cubeRecording } from "../../test/support/fixtures.mjs";
import { isSame, messageOf, startApplication } from "./application.mjs";
import { cellStreams, streamOf } from "./recordings.mjs";

setFlagsFromString("--expose-gc");
const collectGarbage = runInNewContext("gc");
const { frames, isIFrame, voxels } = streamOf(cellStreams("memory", 1, 12, "--i-frame-rate", 6)[0]);

/** Those of the objects that are still there. */
async function alive(references) {
  await new Promise((resolve) => setTimeout(resolve)); // a WeakRef holds what was read until then
  collectGarbage();
  return references.map((reference) => reference.deref()).filter((object) => object !== undefined);
}

/** Watches the memories of codecs until the test ends.
 * @param mostBytes of each
 */
function watchMemories(t, mostBytes = 2 ** 30) {
  const { Memory } = WebAssembly;
  const references = [];
  WebAssembly.Memory = function ({ initial, maximum }) {
    const memory = new Memory({ initial, maximum: Math.min(maximum, mostBytes / 65536) });
    references.push(new WeakRef(memory));
    return memory;
  };
  t.after(() => (WebAssembly.Memory = Memory));
  return references;
}

const cubeFrame = (width) => new Uint8Array(readFileSync(cubeRecording(width).path));
const large = cubeFrame(80); // takes 17 MiB, a frame of the stream 6 MiB

/** Shows a stream and before each of its frames a large one on other topics; returns how many of these are shown. */
function showBeside(application, topics) {
  let shown = 0;
  for (const [i, frame] of frames.entries()) {
    for (const topic of topics) if (application.convert(topic, messageOf(large))) ++shown;
    assert.ok(isSame(application.convert("/small", messageOf(frame)), voxels[i]), `frame ${i}`);
  }
  return shown;
}

test("each topic has a memory of its own", (t) => {
  watchMemories(t, 2 ** 25);
  const application = startApplication();
  const topics = ["/a", "/b", "/c", "/d", "/e"]; // two of them need more than one has
  assert.equal(showBeside(application, topics), topics.length * frames.length);
  assert.deepEqual(application.alerts, []);
});

test("a topic whose clouds need more memory than there is does not disturb others, and is told", (t) => {
  watchMemories(t, 2 ** 23);
  const application = startApplication();
  assert.equal(showBeside(application, ["/a", "/b"]), 0);
  const alerts = application.alerts.map(({ tip }) => tip);
  assert.equal(alerts.length, 2);
  for (const [i, topic] of ["/a", "/b"].entries()) assert.ok(alerts[i].startsWith(`${topic}: out of memory`), alerts[i]);
});

test("without memory for another topic it shows nothing and is told, the others go on", (t) => {
  const application = startApplication();
  assert.ok(application.convert("/points", messageOf(frames[0])));
  const { Memory } = WebAssembly;
  t.after(() => (WebAssembly.Memory = Memory));
  WebAssembly.Memory = function () {
    throw new RangeError("could not allocate memory");
  };
  assert.equal(application.convert("/other", messageOf(frames[0])), undefined);
  assert.ok(application.convert("/points", messageOf(frames[1])));
  assert.deepEqual(application.alerts.map(({ tip }) => tip), ["/other: out of memory"]);
});

test("of 100 topics the last 32 are kept, the others begin again with their next I-frame", async (t) => {
  const memories = watchMemories(t);
  const application = startApplication();
  const show = (topic, i) => application.convertNew(`/${topic}`, messageOf(frames[i]));
  for (let topic = 0; topic < 100; ++topic) {
    assert.ok(show(topic, 0));
    assert.ok(isSame(show(0, topic % 6), voxels[topic % 6])); // used again, so that it is kept
  }
  assert.equal(memories.length, 100);
  assert.equal((await alive(memories)).length, 32);
  assert.deepEqual(application.alerts, []); // another recording may have other topics
  for (let topic = 69; topic < 100; ++topic) assert.ok(isSame(show(topic, 1), voxels[1]), `topic ${topic}`);
  assert.equal(isIFrame.indexOf(true, 1), 6);
  assert.deepEqual([1, 5, 6, 7].map((i) => show(68, i) !== undefined), [false, false, true, true]);
  assert.deepEqual(application.alerts.map(({ message }) => message),
    ["Clouds missing: /68", "Waiting for an I-frame: /68", "Shown again: /68"]);
  assert.match(application.alerts[0].tip, /^\/68: 32 topics are kept at most/);
});

test("the clouds that are kept have 256 MiB at most, and those of topics with small ones stay", async () => {
  const application = startApplication();
  const small = application.convert("/small", messageOf(frames[0]));
  const larger = cubeFrame(120);
  const clouds = [];
  for (let i = 0; i < 6; ++i)
    for (const topic of ["/a", "/b", "/c", "/d", "/e", "/f"]) {
      const different = new Uint8Array(larger.length + i + 1); // so that each is decoded
      different.set(larger);
      clouds.push(new WeakRef(application.convert(topic, messageOf(different)).data));
    }
  assert.ok(clouds.length * clouds.at(-1).deref().length > 1.1 * 2 ** 28);
  const kept = (await alive(clouds)).reduce((sum, { length }) => sum + length, 0);
  assert.ok(kept > 2 ** 27 && kept <= 2 ** 28, `${kept} bytes`);
  assert.equal(application.convert("/small", messageOf(frames[0])).data, small.data);
});
