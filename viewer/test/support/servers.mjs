// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Servers for the tests: files with ranges, and live frames by WebSocket.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { McapStreamReader } from "@mcap/core";

/** A test that fails leaves its server open, which must not keep the program from its end. */
function letProgramEnd(server) {
  server.unref();
  server.on("connection", (socket) => socket.unref());
}

/** Serves texts and bytes by path; answers ranges unless told otherwise. Counts requests. */
export async function serveFiles(files, { ranges = true } = {}) {
  const requests = [];
  const server = createServer((request, response) => {
    const path = new URL(request.url, "http://x").pathname;
    const body = files[path];
    const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
    requests.push({ path, range: request.headers.range ?? null });
    if (body === undefined) {
      response.writeHead(404).end();
      return;
    }
    const bytes = Buffer.from(body);
    const type = path.endsWith(".html") || path === "/" ? "text/html" : path.endsWith(".json") ? "application/json" : "application/octet-stream";
    if (ranges && range) {
      const first = Number(range[1]);
      const last = Math.min(Number(range[2]), bytes.length - 1);
      response.writeHead(206, { "Content-Type": type, "Content-Range": `bytes ${first}-${last}/${bytes.length}`, ETag: '"1"' });
      response.end(bytes.subarray(first, last + 1));
    } else response.writeHead(200, { "Content-Type": type }).end(bytes);
  });
  letProgramEnd(server);
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    requests,
    close: () => new Promise((resolve) => {
      server.closeAllConnections();
      server.close(resolve);
    }),
  };
}

/** The frames of a recording in the order of the file: { stream, time, bytes }. */
export function framesOf(recording) {
  const reader = new McapStreamReader();
  reader.append(readFileSync(recording));
  const channels = new Map();
  const frames = [];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type !== "Message") continue;
    const names = [...channels.keys()];
    frames.push({ stream: names.indexOf(record.channelId), time: record.logTime, bytes: frameIn(record.data) });
  }
  frames.sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : a.stream - b.stream));
  const streams = [...channels.values()].map((channel, id) => ({
    id, name: channel.topic, metadata: Object.fromEntries(channel.metadata),
  }));
  return { streams, frames };
}

/** The frame in a CompressedPointCloud2, which begins with its magic bytes after its size. */
function frameIn(message) {
  const at = Buffer.from(message).indexOf("PCXI");
  const size = new DataView(message.buffer, message.byteOffset).getUint32(at - 4, true);
  return message.slice(at, at + size);
}

/** Sends the first I-frame of some streams again and again, each time as a later one; returns what ends it. */
export function repeatFirst(server, frames, streams) {
  const first = streams.map((wanted) => frames.find(({ stream }) => stream === wanted));
  let seconds = 10n;
  const timer = setInterval(() => {
    seconds += 1n;
    for (const frame of first) server.send({ ...frame, time: frame.time + seconds * 1_000_000_000n });
  }, 400);
  timer.unref(); // a test that fails does not end it
  return () => clearInterval(timer);
}

function webSocketFrame(opcode, payload) {
  const size = payload.length;
  const header = size < 126 ? Buffer.from([0x80 | opcode, size])
    : size < 65536 ? Buffer.from([0x80 | opcode, 126, size >> 8, size & 255])
    : Buffer.concat([Buffer.from([0x80 | opcode, 127, 0, 0, 0, 0]), Buffer.from([size >>> 24, (size >> 16) & 255, (size >> 8) & 255, size & 255])]);
  return Buffer.concat([header, payload]);
}

/** A live source as `pcl_ext view` is one: page, api/source.json and the socket. */
export async function serveLive(page, streams, port = 0) {
  const sockets = new Set();
  const received = [];
  const server = createServer((request, response) => {
    if (request.url === "/") response.writeHead(200, { "Content-Type": "text/html" }).end(page);
    else if (request.url === "/api/source.json")
      response.writeHead(200, { "Content-Type": "application/json" })
        .end(JSON.stringify({ kind: "live", name: "robot cell", socket: "api/live" }));
    else response.writeHead(404).end();
  });
  server.on("upgrade", (request, socket) => {
    const accept = createHash("sha1")
      .update(request.headers["sec-websocket-key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest("base64");
    socket.write("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
      `Sec-WebSocket-Accept: ${accept}\r\nSec-WebSocket-Protocol: ${request.headers["sec-websocket-protocol"]}\r\n\r\n`);
    socket.on("error", () => undefined);
    socket.on("close", () => sockets.delete(socket));
    socket.on("data", (bytes) => received.push(...textsIn(bytes)));
    socket.write(webSocketFrame(1, Buffer.from(JSON.stringify({ type: "streams", streams }))));
    sockets.add(socket);
  });
  letProgramEnd(server);
  await new Promise((resolve) => server.listen(port, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    port: server.address().port,
    received,
    viewers: () => sockets.size,
    send({ stream, time, bytes }, flags = 0) {
      const header = Buffer.alloc(16);
      header.writeUInt32LE(stream, 0);
      header.writeUInt32LE(flags, 4);
      header.writeBigInt64LE(time, 8);
      for (const socket of sockets) socket.write(webSocketFrame(2, Buffer.concat([header, bytes])));
    },
    sendText(message) {
      for (const socket of sockets) socket.write(webSocketFrame(1, Buffer.from(JSON.stringify(message))));
    },
    close: () => new Promise((resolve) => {
      for (const socket of sockets) socket.destroy();
      server.closeAllConnections();
      server.close(resolve);
    }),
  };
}

/** The texts of the short masked messages of a browser; others end the list. */
function textsIn(bytes) {
  const texts = [];
  for (let at = 0; at + 6 <= bytes.length && (bytes[at] & 15) === 1 && (bytes[at + 1] & 127) < 126; ) {
    const size = bytes[at + 1] & 127;
    const mask = bytes.subarray(at + 2, at + 6);
    texts.push(Buffer.from(bytes.subarray(at + 6, at + 6 + size).map((byte, i) => byte ^ mask[i % 4])).toString());
    at += 6 + size;
  }
  return texts;
}
