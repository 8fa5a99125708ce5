// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { SourceError } from "../recordings/byte_source";
import type { OpenFile } from "../decoding/messages";

/** What the page shows: files of a recording, or a live source. */
export type Source =
  | { kind: "recording"; name: string; files: OpenFile[]; leftOut: string[] }
  | { kind: "live"; name: string; socket: string };

interface ServedSource {
  kind?: unknown;
  name?: unknown;
  socket?: unknown;
  files?: { name?: unknown; url?: unknown }[];
}

export const embeddedId = "pcl-ext-recording";

export function bytesOfBase64(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text.replace(/\s+/g, ""));
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** A recording that lies in the page itself, as “pcl_ext view --export” writes it. */
function embeddedRecording(): Source | null {
  const element = document.getElementById(embeddedId);
  if (!element) return null;
  const name = element.dataset.name ?? "recording";
  try {
    return { kind: "recording", name, files: [{ name, bytes: bytesOfBase64(element.textContent ?? "") }], leftOut: [] };
  } catch {
    throw new SourceError("The recording in this page is damaged. Save the page again, or open the recording itself.");
  }
}

function nameOfUrl(url: URL): string {
  const last = url.pathname.split("/").filter(Boolean).pop() ?? url.href;
  try {
    return decodeURIComponent(last);
  } catch {
    return last;
  }
}

async function servedSource(): Promise<Source | null> {
  let served: ServedSource;
  try {
    const response = await fetch(new URL("api/source.json", location.href));
    if (!response.ok) return null;
    served = (await response.json()) as ServedSource;
  } catch {
    return null;
  }
  const name = typeof served.name === "string" ? served.name : "recording";
  if (served.kind === "live" && typeof served.socket === "string")
    return { kind: "live", name, socket: new URL(served.socket, location.href).href.replace(/^http/, "ws") };
  if (served.kind !== "recording" || !Array.isArray(served.files) || served.files.length === 0) return null;
  return {
    kind: "recording",
    name,
    files: served.files.map((file) => ({
      name: String(file.name),
      url: new URL(String(file.url), location.href).href,
    })),
    leftOut: [],
  };
}

function isWholeAddress(file: string): boolean {
  return /^([a-z][a-z\d+.-]*:)*\/\//i.test(file);
}

/** The path that the page's address names, as it is written there: what is escaped is a part of a name. */
function writtenPath(): string {
  const written = /[?&]file=([^&]*)/.exec(location.search)?.[1] ?? "";
  return written.replaceAll(/%2f/gi, "/").replaceAll("+", "%20");
}

/** The source that page or address name; null: the user opens one. */
export async function chooseSource(): Promise<Source | null> {
  const embedded = embeddedRecording();
  if (embedded) return embedded;
  const file = new URLSearchParams(location.search).get("file");
  if (file) {
    let url: URL;
    try {
      url = new URL(isWholeAddress(file) ? file : writtenPath(), location.href);
    } catch {
      throw new SourceError(`“${file}” is no address of a file.`);
    }
    return { kind: "recording", name: nameOfUrl(url), files: [{ name: nameOfUrl(url), url: url.href }], leftOut: [] };
  }
  return /^https?:$/.test(location.protocol) ? servedSource() : null;
}

/** Number at the end of a name, by which the files of a rosbag2 folder are ordered. */
function numberOf(name: string): number {
  return Number(/_(\d+)\.mcap$/.exec(name)?.[1] ?? -1);
}

/** Names of which no two are the same, as those of files from different folders may be. */
function distinctNames(names: readonly string[]): string[] {
  const taken = new Set<string>();
  return names.map((name) => {
    let result = name;
    for (let use = 2; taken.has(result); ++use) result = name.replace(/(\.[^.]*)?$/, (ending) => ` (${use})${ending}`);
    taken.add(result);
    return result;
  });
}

/** What belongs to a folder of recordings, but is none. */
function isBeside(file: File): boolean {
  return /^\.|\.(ya?ml|md|txt|json|sha\d*|md5)$/i.test(file.name);
}

/** Files that the user chose or dropped: a recording in .mcap files, or files of frames, each with a stream. */
export function sourceOfFiles(files: readonly File[]): Source {
  const mcap = files.filter((file) => /\.mcap$/i.test(file.name));
  const others = files.filter((file) => !mcap.includes(file));
  const frames = others.filter((file) => !isBeside(file));
  const chosen = mcap.length > 0 ? mcap : frames.length > 0 ? frames : others;
  chosen.sort((a, b) => numberOf(a.name) - numberOf(b.name) || a.name.localeCompare(b.name));
  const names = distinctNames(chosen.map((file) => file.name));
  return {
    kind: "recording",
    name: names.length > 1 ? `${names[0]} and ${names.length - 1} more` : names[0],
    files: chosen.map((blob, i) => ({ name: names[i], blob })),
    leftOut: mcap.length > 0 ? frames.map((file) => file.name) : [],
  };
}
