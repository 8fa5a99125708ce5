declare module "lz4js" {
  /** Decompresses a block from `source` into `target`; returns the end of what was written. */
  export function decompressBlock(
    source: Uint8Array,
    target: Uint8Array,
    sourceOffset: number,
    sourceLength: number,
    targetOffset: number,
  ): number;
}
