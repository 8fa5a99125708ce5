// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ExtensionContext } from "@foxglove/extension";
import wasm from "@pcl_ext/codec/wasm";

import { Converter, type ConverterContext } from "./converter";

/** The message's names in ROS 2 and ROS 1. */
const schemaNames = [
  "point_cloud_interfaces/msg/CompressedPointCloud2",
  "point_cloud_interfaces/CompressedPointCloud2",
];

/** Called by the application when it loads the extension. The codec is compiled at once: Lichtblick does not wait for
 * promises, and converts the messages of a paused recording only once. */
export function activate(context: ExtensionContext): void {
  const converter = new Converter(new WebAssembly.Module(wasm));
  for (const fromSchemaName of schemaNames)
    context.registerMessageConverter({
      type: "schema",
      fromSchemaName,
      toSchemaName: "foxglove.PointCloud",
      converter: (message: unknown, event, _variables?: unknown, converterContext?: ConverterContext) =>
        converter.convert(message, event.topic, converterContext),
    });
}
