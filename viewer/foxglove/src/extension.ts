import type { ExtensionContext } from "@foxglove/extension";
import { Codec } from "@pcl_ext/codec";
import wasm from "@pcl_ext/codec/wasm";

import type { CompressedCloud, PointCloud } from "./messages";
import { TopicDecoder } from "./topic_decoder";

/** The message's names in ROS 2 and ROS 1. */
const schemaNames = [
  "point_cloud_interfaces/msg/CompressedPointCloud2",
  "point_cloud_interfaces/CompressedPointCloud2",
];

/** The fourth argument of a converter in Lichtblick; Foxglove has none. */
interface ConverterContext {
  emitAlert(alert: { severity: "warn"; message: string }, id: string): void;
}

/** Converts the messages of all topics. */
class Converter {
  private readonly decoders = new Map<string, TopicDecoder>();
  private readonly told = new Set<string>();

  constructor(private readonly codec: Codec) {}

  /** The cloud; undefined, which shows nothing, if there is none. */
  convert(message: CompressedCloud, topic: string, context?: ConverterContext): PointCloud | undefined {
    const { header, format, compressed_data: frame } = message;
    if (!/^pcl_ext(\/|$)/.test(format)) {
      this.tell(topic, "Format", `format ‘${format}’ is not of pcl_ext`, context);
      return undefined;
    }
    const { points, status } = this.decoderOf(topic).decode(frame);
    if (points) return { timestamp: header.stamp, frame_id: header.frame_id, ...points };
    // After a seek there is nothing to tell.
    if (status.code !== "MissingReference" && status.code !== "OldFrame")
      this.tell(topic, status.code, status.message, context);
    return undefined;
  }

  private decoderOf(topic: string): TopicDecoder {
    let decoder = this.decoders.get(topic);
    if (!decoder) this.decoders.set(topic, (decoder = new TopicDecoder(this.codec)));
    return decoder;
  }

  /** Tells a kind of problem of a topic once. */
  private tell(topic: string, kind: string, problem: string, context?: ConverterContext): void {
    const id = `${topic} ${kind}`;
    if (this.told.has(id)) return;
    this.told.add(id);
    const message = `${topic}: ${problem}`;
    if (context?.emitAlert) context.emitAlert({ severity: "warn", message }, id);
    else console.warn(message);
  }
}

/** Called by the application when it loads the extension. The codec is compiled at once: Lichtblick does not wait for
 * promises, and converts the messages of a paused recording only once. */
export function activate(context: ExtensionContext): void {
  const converter = new Converter(Codec.loadNow(wasm));
  for (const fromSchemaName of schemaNames)
    context.registerMessageConverter({
      type: "schema",
      fromSchemaName,
      toSchemaName: "foxglove.PointCloud",
      converter: (message: CompressedCloud, event, _variables?: unknown, converterContext?: ConverterContext) =>
        converter.convert(message, event.topic, converterContext),
    });
}
