// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
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
