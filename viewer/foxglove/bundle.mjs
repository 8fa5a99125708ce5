// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Bundles the extension into one file, a zip archive, the same bytes each time: node bundle.mjs OUTPUT
import { build } from "esbuild";
import { zipSync } from "fflate";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = dirname(fileURLToPath(import.meta.url));
const textOf = (name) => readFile(join(folder, name), "utf8");

/** The module as the applications load it, with the codec in it. */
async function bundle() {
  const result = await build({
    entryPoints: [join(folder, "src/extension.ts")],
    bundle: true,
    minify: true,
    write: false,
    format: "cjs",
    platform: "browser",
    target: ["es2022"],
    charset: "utf8",
    legalComments: "none",
    loader: { ".wasm": "binary" },
  });
  return result.outputFiles[0].text;
}

/** What the applications read of package.json. */
async function manifest() {
  const { name, displayName, version, description, publisher, license, keywords, main } =
    JSON.parse(await textOf("package.json"));
  return { name, displayName, version, description, publisher, license, keywords, main };
}

/** Without pictures, and links to files, that are not in the archive. */
const readMe = async () =>
  (await textOf("README.md")).replace(/!\[[^\]]+\]\([^)]+\)\n\n/g, "").replace(/\[([^\]]+)\]\((?!https:)[^)]+\)/g, "$1");

const description = await manifest();
const output = process.argv[2] ?? join(folder, "dist", `pcl_ext-${description.version}.foxe`);
const texts = {
  "CHANGELOG.md": await textOf("CHANGELOG.md"),
  LICENSE: await textOf("../../LICENSE"),
  "README.md": await readMe(),
  "dist/extension.js": await bundle(),
  "package.json": `${JSON.stringify(description, null, 2)}\n`,
};
const files = Object.entries(texts).map(([name, text]) => [name, new TextEncoder().encode(text)]);
// In the archive there are local times, so that this one is the same in all time zones.
const archive = zipSync(Object.fromEntries(files), { level: 9, mtime: new Date(2020, 0, 1) });
await mkdir(dirname(output), { recursive: true });
await writeFile(output, archive);
console.log(`${output}: ${Math.round(archive.length / 1000)} kB, extension.js ${Math.round(texts["dist/extension.js"].length / 1000)} kB`);
