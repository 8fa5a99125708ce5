// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// An MCAP file that a test writes.
import { McapWriter } from "@mcap/core";

/** Begins a file.
 * @param options of McapWriter
 * @returns the writer, and what it has written
 */
export async function beginMcap(options = {}) {
  const parts = [];
  let size = 0n;
  const writer = new McapWriter({
    writable: {
      write: async (bytes) => {
        parts.push(Buffer.from(bytes));
        size += BigInt(bytes.length);
      },
      position: () => size,
    },
    ...options,
  });
  await writer.start({ profile: "ros2", library: "test" });
  return { writer, bytes: () => Buffer.concat(parts) };
}
