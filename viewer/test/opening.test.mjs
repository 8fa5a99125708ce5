// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Every way to open a recording, and what is said of files that are none.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";

import { drawnVoxels, openFiles, openViewer, seek, startBrowser, stopBrowser, untilDrawn, untilIndexed } from "./support/browser.mjs";
import { rewritten } from "./support/changed_recordings.mjs";
import { beginMcap } from "./support/mcap_file.mjs";
import { cellRecording, cloudRecording, frameFile, pagePath, pathInFolder } from "./support/fixtures.mjs";
import { serveFiles } from "./support/servers.mjs";

before(startBrowser);
after(stopBrowser);

const recording = cellRecording();
const page = readFileSync(pagePath);

async function drop(viewer, name, bytes) {
  const text = Buffer.from(bytes).toString("base64");
  await viewer.evaluate(async ([file, base64]) => {
    const body = await (await fetch(`data:application/octet-stream;base64,${base64}`)).blob();
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([body], file));
    for (const type of ["dragenter", "dragover", "drop"])
      document.body.dispatchEvent(new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
  }, [name, text]);
}

test("a recording is opened by drop on a page from a file, and another one after it", async () => {
  const viewer = await openViewer();
  await drop(viewer, "cell.mcap", readFileSync(recording));
  await untilDrawn(viewer);
  assert.equal(await viewer.title(), "cell.mcap – pcl_ext viewer");
  assert.deepEqual((await viewer.ask(() => window.pclExtViewer.streams())).map(({ name }) => name),
    ["/cell_sensor_1", "/cell_sensor_2"]);
  await drop(viewer, "frames.pcxi", readFileSync(frameFile()));
  await viewer.until(() => window.pclExtViewer.streams().length === 1 && window.pclExtViewer.counts().all > 0);
  assert.equal(await viewer.title(), "frames.pcxi – pcl_ext viewer");
  await viewer.finish();
});

test("?file= opens a recording by its address, by ranges", async () => {
  const server = await serveFiles({ "/": page, "/files/cell.mcap": readFileSync(recording) });
  const viewer = await openViewer({ url: `${server.url}?file=files/cell.mcap` });
  await untilDrawn(viewer);
  await viewer.until(() => window.pclExtViewer.streams().every(({ voxels }) => voxels > 0));
  assert.equal((await viewer.ask(() => window.pclExtViewer.streams())).length, 2);
  assert.ok(server.requests.filter(({ path }) => path === "/files/cell.mcap").every(({ range }) => range !== null));
  assert.equal(server.requests.some(({ path }) => path === "/api/source.json"), false);
  await viewer.finish();
  await server.close();
});

test("a server without ranges will do, and a file that is missing is told in words", async () => {
  const server = await serveFiles({ "/": page, "/cell.mcap": readFileSync(recording) }, { ranges: false });
  const viewer = await openViewer({ url: `${server.url}?file=cell.mcap` });
  await untilDrawn(viewer);
  await viewer.finish();
  const other = await openViewer({ url: `${server.url}?file=gone.mcap` });
  await other.notice("error").waitFor();
  assert.match(await other.notice("error").innerText(), /no file .*gone\.mcap \(HTTP 404\)/);
  await other.finish();
  await server.close();
});

test("a served recording of two files is one recording", async () => {
  const whole = cellRecording(40);
  const halves = ["0:30", "30:40"].map((frames, i) => {
    const path = pathInFolder(`part_${i}.mcap`);
    return { frames, path };
  });
  const { pclExt } = await import("./support/fixtures.mjs");
  for (const { frames, path } of halves) pclExt("cut", whole, "-o", path, "--frames", frames, "--overwrite", "-q");
  const source = {
    kind: "recording", name: "bag",
    files: halves.map(({ path }, i) => ({ name: `bag_${i}.mcap`, url: `api/files/${i}`, size: readFileSync(path).length })),
  };
  const server = await serveFiles({
    "/": page, "/api/source.json": JSON.stringify(source),
    "/api/files/0": readFileSync(halves[0].path), "/api/files/1": readFileSync(halves[1].path),
  });
  const viewer = await openViewer({ url: server.url });
  await untilDrawn(viewer);
  await untilIndexed(viewer);
  assert.equal(await viewer.ask(() => window.pclExtViewer.moments()), 40);
  assert.equal((await viewer.ask(() => window.pclExtViewer.streams())).length, 2);
  await viewer.finish();
  await server.close();
});

for (const place of ["<body>", "</body>"])
test(`a page with a recording in it, at ${place}, shows it, from a file`, async () => {
  const embedded = `<script type="application/octet-stream;base64" id="pcl-ext-recording" data-name="mailed.mcap">` +
    `${readFileSync(recording).toString("base64")}</script>`;
  const path = pathInFolder("export.html");
  writeFileSync(path, page.toString().replace(place, () => (place === "<body>" ? place + embedded : embedded + place)));
  const viewer = await openViewer({ url: `file://${path}` });
  await untilDrawn(viewer);
  assert.equal(await viewer.title(), "mailed.mcap – pcl_ext viewer");
  await viewer.finish();
});

test("recordings of other recorders show the same voxels: lz4, zstd, without chunks", async () => {
  const viewer = await openViewer();
  await openFiles(viewer, recording);
  await untilIndexed(viewer);
  await seek(viewer, 5);
  const expected = await drawnVoxels(viewer, 1);
  for (const options of [{ compression: "lz4" }, { compression: "zstd" }, { useChunks: false }]) {
    const path = pathInFolder(`other_${options.compression ?? "plain"}.mcap`);
    writeFileSync(path, await rewritten(recording, options));
    await openFiles(viewer, path);
    await untilIndexed(viewer);
    assert.equal(await viewer.ask(() => window.pclExtViewer.moments()), 20, path);
    await seek(viewer, 5);
    assert.deepEqual(await drawnVoxels(viewer, 1), expected, path);
    assert.deepEqual(await viewer.ask(() => window.pclExtViewer.damage()), []);
  }
  await viewer.finish();
});

test("files that are no recording are told in words, and the page goes on", async () => {
  const draco = pathInFolder("draco.mcap");
  writeFileSync(draco, await rewritten(recording, { changeFormat: "cloudin" }));
  const { writer, bytes: ofRos1 } = await beginMcap();
  const schemaId = await writer.registerSchema({ name: "sensor_msgs/PointCloud2", encoding: "ros1msg", data: new Uint8Array() });
  await writer.registerChannel({ schemaId, topic: "/points", messageEncoding: "ros1", metadata: new Map() });
  await writer.addMessage({ channelId: 0, sequence: 0, logTime: 1n, publishTime: 1n, data: new Uint8Array(8) });
  await writer.end();
  const cases = [
    ["notes.txt", Buffer.from("These are only some notes about clouds. ".repeat(200)), /not a recording/],
    ["empty.mcap", Buffer.alloc(0), /empty/],
    ["cloud.pcd", Buffer.from("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\n"), /not a recording/],
    ["other.mcap", readFileSync(draco), /cell_sensor_1 \(cloudin\).*another\s+format/s],
    ["zeros.pcxi", Buffer.alloc(100_000), /not a recording/],
    ["bag_0.db3", Buffer.from("SQLite format 3\0".padEnd(8192, "\0")), /the storage sqlite3.*pcl_ext cut bag_0\.db3/s],
    ["old.bag", Buffer.from("#ROSBAG V2.0\n".padEnd(8192, " ")), /a bag of ROS 1.*“pcl_ext encode”/s],
    ["bag_0.mcap.zstd", Buffer.from([0x28, 0xb5, 0x2f, 0xfd, ...Buffer.alloc(5000)]), /compressed by file/],
    ["ros1.mcap", ofRos1(), /\/points: not compressed; “pcl_ext encode”/],
  ];
  const viewer = await openViewer();
  for (const [name, bytes, expected] of cases) {
    await viewer.setInputFiles("input[type=file]", { name, mimeType: "application/octet-stream", buffer: bytes });
    await viewer.notice("error").filter({ hasText: name }).waitFor();
    assert.match(await viewer.notice("error").innerText(), expected, name);
    assert.equal(await viewer.getByRole("button", { name: "Open a recording" }).isVisible(), true);
    assert.equal(await viewer.title(), "pcl_ext viewer");
    assert.equal(await viewer.locator(".status").innerText(), "");
  }
  await openFiles(viewer, recording);
  assert.equal(await viewer.notice("error").count(), 0);
  await viewer.finish();
});

test("a wrong file keeps what was open, which goes on, and a right one takes its place", async () => {
  const server = await serveFiles({ "/": page, "/cell.mcap": readFileSync(recording) });
  const viewer = await openViewer({ url: `${server.url}?file=cell.mcap` });
  await untilDrawn(viewer);
  await untilIndexed(viewer);
  await seek(viewer, 5);
  const expected = await drawnVoxels(viewer, 1);
  const otherClouds = pathInFolder("refused.mcap");
  writeFileSync(otherClouds, await rewritten(recording, { changeFormat: "cloudin" }));
  for (const [name, bytes] of [
    ["notes.txt", Buffer.from("Only notes. ".repeat(1000))],
    ["refused.mcap", readFileSync(otherClouds)],
    ["cut.mcap", readFileSync(recording).subarray(0, 60)],
  ]) {
    await viewer.setInputFiles("input[type=file]", { name, mimeType: "application/octet-stream", buffer: bytes });
    await viewer.notice("error").filter({ hasText: name }).waitFor();
    assert.equal(await viewer.title(), "cell.mcap – pcl_ext viewer");
    assert.deepEqual(await drawnVoxels(viewer, 1), expected);
    assert.equal(await viewer.ask(() => window.pclExtViewer.state().moment), 5);
    assert.match(viewer.url(), /file=cell\.mcap/);
    await seek(viewer, 9);
    assert.notDeepEqual(await drawnVoxels(viewer, 1), expected);
    await seek(viewer, 5);
    assert.deepEqual(await drawnVoxels(viewer, 1), expected);
  }
  assert.equal(await viewer.locator(".is-opening").count(), 0);
  await openFiles(viewer, frameFile());
  assert.equal((await viewer.ask(() => window.pclExtViewer.streams())).length, 1);
  assert.equal(await viewer.notice("error").count(), 0);
  assert.doesNotMatch(viewer.url(), /file=/);
  await viewer.finish();
  await server.close();
});

test("a link keeps threshold, colour, time and camera", async () => {
  const server = await serveFiles({ "/": page, "/cell.mcap": readFileSync(recording) });
  const viewer = await openViewer({ url: `${server.url}?file=cell.mcap` });
  await untilDrawn(viewer);
  await untilIndexed(viewer);
  await viewer.evaluate(() => {
    window.pclExtViewer.set({ threshold: 4, colourBy: "height", hiddenStreams: ["cell_sensor_2"] });
    window.pclExtViewer.setCamera([3, 4, 5, 1, 2, 0]);
  });
  await seek(viewer, 7);
  await viewer.until(() => location.hash.includes("threshold=4") && location.hash.includes("time=0.35"));
  const other = await openViewer({ url: viewer.url() });
  await untilDrawn(other);
  const state = await other.ask(() => window.pclExtViewer.state());
  assert.equal(state.threshold, 4);
  assert.equal(state.colourBy, "height");
  assert.equal(state.moment, 7);
  assert.deepEqual(state.hiddenStreams, ["cell_sensor_2"]);
  assert.deepEqual((await other.ask(() => window.pclExtViewer.camera())).map((value) => Number(value.toFixed(6))), [3, 4, 5, 1, 2, 0]);
  // Put into the open page, with a name that has a comma; a camera that is near, far from the origin.
  const camera = [5e5, 5.4e6, 0.1, 5e5, 5.4e6 + 0.0123456, 0.1];
  await other.evaluate((values) => (location.hash = `#hidden=a,b&hidden=c&time=0.1&camera=${values}`), camera);
  await other.until(() => !location.hash.includes("threshold") && location.hash.includes("5400000.012346"));
  assert.deepEqual((await other.ask(() => window.pclExtViewer.state())).hiddenStreams, ["a,b", "c"]);
  assert.equal((await other.ask(() => window.pclExtViewer.state())).moment, 2);
  await other.finish();
  await viewer.finish();
  await server.close();
});

test("what the user does to the time ends what a link says of it, while the recording is read, too", async () => {
  const long = Buffer.concat(Array(60).fill(readFileSync(frameFile())));
  const server = await serveFiles({ "/": page, "/long.pcxi": long });
  const viewer = await openViewer({ url: `${server.url}?file=long.pcxi#time=1000` });
  await untilDrawn(viewer);
  await viewer.keyboard.press("Home");
  await untilIndexed(viewer);
  await viewer.waitForTimeout(300);
  assert.equal(await viewer.ask(() => window.pclExtViewer.state().moment), 0);
  await viewer.finish();
  await server.close();
});

test("a file that is opened while another one is read gets nothing of that", async () => {
  const viewer = await openViewer();
  const texts = [frameFile(), recording].map((path) => readFileSync(path).toString("base64"));
  await viewer.evaluate(async ([frames, cell]) => {
    const fileOf = (text, times, name) =>
      new File(Array(times).fill(Uint8Array.from(atob(text), (c) => c.charCodeAt(0))), name);
    const open = (file) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(file);
      const input = document.querySelector("input[type=file]");
      input.files = dataTransfer.files;
      input.dispatchEvent(new Event("change"));
    };
    open(fileOf(frames, 300, "long.pcxi"));
    await new Promise((resolve) => setTimeout(resolve, 500));
    // Meanwhile the decoder tells of the first file.
    for (const end = performance.now() + 600; performance.now() < end; );
    open(fileOf(cell, 1, "cell.mcap"));
  }, texts);
  // Until then the first file is shown.
  await viewer.until(() => !window.pclExtViewer.state().isOpening);
  await untilDrawn(viewer);
  await untilIndexed(viewer);
  assert.deepEqual((await viewer.ask(() => window.pclExtViewer.streams())).map(({ name }) => name),
    ["/cell_sensor_1", "/cell_sensor_2"]);
  assert.equal(await viewer.ask(() => window.pclExtViewer.moments()), 20);
  await viewer.finish();
});

test("one voxel, and voxels that are thousands of kilometres apart, are in the view", async () => {
  const viewer = await openViewer();
  for (const [path, size] of [
    [recording, 10],
    [cloudRecording("one", ["1 2 3"]), 1],
    [cloudRecording("wide", ["-1e9 -1e9 0", "1e9 1e9 5e8"], "--resolution", 5000), 1e9],
  ]) {
    await openFiles(viewer, [path]);
    const [x, y, z, ...target] = await viewer.ask(() => window.pclExtViewer.camera());
    const distance = Math.hypot(x - target[0], y - target[1], z - target[2]);
    assert.ok(distance > 0.1 * size && distance < 10 * size, `the camera is ${distance} m away`);
  }
  await viewer.finish();
});

test("?file= has names of any characters, escaped, and whole addresses", async () => {
  const server = await serveFiles({
    "/": page, "/files/c%20%231%2541%3F.mcap": readFileSync(recording), "/cell.mcap": readFileSync(recording),
  });
  for (const [file, name] of [
    ["files/c%20%231%2541%3F.mcap", "c #1%41?.mcap"],
    ["files%2Fc+%231%2541%3F.mcap", "c #1%41?.mcap"],
    [encodeURIComponent(`${server.url}cell.mcap?token=a#b`), "cell.mcap"],
    ["cell.mcap?token=a", "cell.mcap"],
  ]) {
    const viewer = await openViewer({ url: `${server.url}?file=${file}` });
    await untilDrawn(viewer);
    assert.equal(await viewer.title(), `${name} – pcl_ext viewer`);
    await viewer.finish();
  }
  await server.close();
});
