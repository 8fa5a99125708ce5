import { SourceError } from "../recordings/byte_source";
import type { OpenFile } from "../decoding/messages";

/** What the page shows: files of a recording, or a live source. */
export type Source =
  | { kind: "recording"; name: string; files: OpenFile[] }
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
    return { kind: "recording", name, files: [{ name, bytes: bytesOfBase64(element.textContent ?? "") }] };
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
  };
}

/** The source that page or address name; null: the user opens one. */
export async function chooseSource(): Promise<Source | null> {
  const embedded = embeddedRecording();
  if (embedded) return embedded;
  const file = new URLSearchParams(location.search).get("file");
  if (file) {
    let url: URL;
    try {
      url = new URL(file, location.href);
    } catch {
      throw new SourceError(`“${file}” is no address of a file.`);
    }
    return { kind: "recording", name: nameOfUrl(url), files: [{ name: nameOfUrl(url), url: url.href }] };
  }
  return /^https?:$/.test(location.protocol) ? servedSource() : null;
}

/** Number at the end of a name, by which the files of a rosbag2 folder are ordered. */
function numberOf(name: string): number {
  return Number(/_(\d+)\.mcap$/.exec(name)?.[1] ?? -1);
}

/** Files that the user chose or dropped: one recording, also if it is a folder with several files. */
export function sourceOfFiles(files: readonly File[]): Source {
  const mcap = files.filter((file) => file.name.endsWith(".mcap"));
  const chosen = mcap.length > 0 && mcap.length < files.length ? mcap : [...files];
  chosen.sort((a, b) => numberOf(a.name) - numberOf(b.name) || a.name.localeCompare(b.name));
  if (chosen.length > 1 && mcap.length === 0) chosen.length = 1; // files of frames have one stream each
  const name = chosen.length > 1 ? `${chosen[0].name} and ${chosen.length - 1} more` : chosen[0].name;
  return { kind: "recording", name, files: chosen.map((blob) => ({ name: blob.name, blob })) };
}
