// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** Bundled as bytes. */
declare module "@pcl_ext/codec/wasm" {
  const bytes: Uint8Array<ArrayBuffer>;
  export default bytes;
}
