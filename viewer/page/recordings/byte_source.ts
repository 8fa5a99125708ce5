// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Bytes that can be read in any order: a file, a part of the page, or a file of a server. */
export interface ByteSource {
  readonly name: string;
  readonly size: number;
  /** Fewer bytes than asked for only at the end. */
  read(offset: number, length: number): Promise<Uint8Array>;
}

/** A source that cannot be read, with what to do about it. */
export class SourceError extends Error {}

export class MemoryBytes implements ByteSource {
  constructor(
    readonly name: string,
    private readonly bytes: Uint8Array,
  ) {}

  get size(): number {
    return this.bytes.length;
  }

  async read(offset: number, length: number): Promise<Uint8Array> {
    return this.bytes.subarray(offset, offset + length);
  }
}

export class BlobBytes implements ByteSource {
  constructor(
    readonly name: string,
    private readonly blob: Blob,
  ) {}

  get size(): number {
    return this.blob.size;
  }

  async read(offset: number, length: number): Promise<Uint8Array> {
    try {
      return new Uint8Array(await this.blob.slice(offset, offset + length).arrayBuffer());
    } catch {
      throw new SourceError(
        `“${this.name}” cannot be read any more. Was it moved or changed? Open it again.`,
      );
    }
  }
}

/** A file of a server that answers requests for ranges. */
class RangedBytes implements ByteSource {
  constructor(
    readonly name: string,
    private readonly url: string,
    readonly size: number,
    private readonly version: string | null,
  ) {}

  async read(offset: number, length: number): Promise<Uint8Array> {
    const last = Math.min(offset + length, this.size) - 1;
    if (last < offset) return new Uint8Array(0);
    const response = await fetchOrExplain(this.url, { Range: `bytes=${offset}-${last}` });
    if (response.status !== 206 || response.headers.get("ETag") !== this.version)
      throw new SourceError(
        `“${this.name}” has changed on the server, or is gone (HTTP ${response.status}). Reload the page.`,
      );
    return new Uint8Array(await response.arrayBuffer());
  }
}

async function fetchOrExplain(url: string, headers: Record<string, string>): Promise<Response> {
  try {
    return await fetch(url, { headers });
  } catch {
    throw new SourceError(
      new URL(url).protocol === "file:"
        ? `Browsers do not let a page read other files by their address (${url}). Use the button Open.`
        : `${url} cannot be reached. Is the server running, and does it allow requests from this page (CORS)?`,
    );
  }
}

/** Opens a file of a server: by ranges, or as a whole where the server knows none. */
export async function openUrl(url: string, name: string): Promise<ByteSource> {
  const response = await fetchOrExplain(url, { Range: "bytes=0-0" });
  const total = /\/(\d+)$/.exec(response.headers.get("Content-Range") ?? "");
  if (response.status === 206 && total) {
    await response.arrayBuffer();
    return new RangedBytes(name, url, Number(total[1]), response.headers.get("ETag"));
  }
  if (response.status === 416) return new MemoryBytes(name, new Uint8Array(0));
  if (!response.ok)
    throw new SourceError(`The server has no file ${url} (HTTP ${response.status}).`);
  return new MemoryBytes(name, new Uint8Array(await response.arrayBuffer()));
}

/** Reads a source from its beginning on in large blocks, so that many small reads are few requests. */
export class BlockReader {
  private block = new Uint8Array(0);
  private blockOffset = 0;

  constructor(
    private readonly source: ByteSource,
    private readonly blockSize = 1 << 20,
  ) {}

  get size(): number {
    return this.source.size;
  }

  /** Bytes at a place; fewer at the end. Valid until the next call. */
  async bytesAt(offset: number, length: number): Promise<Uint8Array> {
    const begin = offset - this.blockOffset;
    if (begin < 0 || begin + length > this.block.length) {
      this.block = await this.source.read(offset, Math.max(length, this.blockSize)) as Uint8Array<ArrayBuffer>;
      this.blockOffset = offset;
      return this.block.subarray(0, length);
    }
    return this.block.subarray(begin, begin + length);
  }
}
