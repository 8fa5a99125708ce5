/** Bundled as bytes. */
declare module "@pcl_ext/codec/wasm" {
  const bytes: Uint8Array<ArrayBuffer>;
  export default bytes;
}
