// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Files that the tests read, and the codec that they try. */
import { readFile, readdir } from "node:fs/promises";

import { Codec } from "../dist/index.js";

export const data = new URL("../../../test/data/", import.meta.url);
export const wasm = await readFile(new URL("../dist/codec.wasm", import.meta.url));
const module = await WebAssembly.compile(wasm);

/** A codec of its own for each test. */
export const loadCodec = (options) => Codec.load(module, options);

/** The bytes of a stream of test/data. */
export const stream = async (name) => new Uint8Array(await readFile(new URL(name, data)));

/** The names of the streams in a folder of test/data, without extension. */
export async function streamNames(folder) {
  const names = await readdir(new URL(folder, data));
  return names.filter((name) => name.endsWith(".pcxi")).map((name) => name.slice(0, -5));
}

/** The frames of a stream that is in order. */
export function framesOf(codec, bytes) {
  const frames = [];
  for (let at = 0; at < bytes.length; at += frames.at(-1).length)
    frames.push(bytes.subarray(at, at + codec.frameSize(bytes.subarray(at))));
  return frames;
}
