// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Bundles the page into one HTML file: node bundle.mjs OUTPUT
import { build } from "esbuild";
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const viewer = dirname(fileURLToPath(import.meta.url));
const output = process.argv[2] ?? join(viewer, "dist", "viewer.html");

async function bundle(entry, define = {}) {
  const result = await build({
    entryPoints: [join(viewer, "page", entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: ["es2022"],
    charset: "utf8",
    legalComments: "none",
    define,
  });
  return result.outputFiles[0].text;
}

async function styleSheet() {
  const folder = join(viewer, "page", "style");
  const names = (await readdir(folder)).filter((name) => name.endsWith(".css")).sort();
  const sheets = await Promise.all(names.map((name) => readFile(join(folder, name), "utf8")));
  const { outputFiles } = await build({
    stdin: { contents: sheets.join("\n"), loader: "css" },
    minify: true,
    write: false,
    // What is not supported everywhere has a fallback in the sheets themselves.
    target: ["es2022"],
  });
  return outputFiles[0].text;
}

/** Nothing in a script element may look like its end. */
function inScript(code) {
  return code.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
}

/** The licences of what the page contains, for its source text. */
async function licences() {
  const texts = [];
  for (const name of ["three", "@mcap/core", "@foxglove/crc", "heap-js", "fzstd", "lz4js"]) {
    const folder = join(viewer, "node_modules", name);
    const { version, license, author, homepage } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
    const holder = typeof author === "string" ? author : (author?.name ?? "");
    const text = file ? await readFile(join(folder, file), "utf8") : `${license} licence, ${holder}, ${homepage}`;
    texts.push(`${name} ${version}\n\n${text.trim()}`);
  }
  return texts.join("\n\n====\n\n").replaceAll("--", "- -");
}

const wasm = await readFile(createRequire(import.meta.url).resolve("@pcl_ext/codec/wasm"));
const worker = await bundle("decoding/worker.ts");
const script = await bundle("main.ts", { WORKER_CODE: JSON.stringify(worker) });
const parts = {
  "/*LICENCES*/": await licences(),
  "/*STYLE*/": await styleSheet(),
  "/*WASM*/": wasm.toString("base64"),
  "/*SCRIPT*/": inScript(script),
};
let html = await readFile(join(viewer, "page", "index.html"), "utf8");
for (const [place, text] of Object.entries(parts)) html = html.replace(place, () => text);
await mkdir(dirname(output), { recursive: true });
await writeFile(output, html);
const kB = (text) => `${Math.round(text.length / 1000)} kB`;
console.log(`${output}: ${kB(html)}: script ${kB(script)} (of it the decoder's ${kB(worker)}), wasm ${kB(parts["/*WASM*/"])}`);
