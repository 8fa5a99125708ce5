import { faultOf, type CompressedCloud, type PointCloud } from "./messages";
import { RecentClouds } from "./recent_clouds";
import { TopicDecoder, type Decoded } from "./topic_decoder";

/** Each topic takes a memory of its own, which only grows. */
const mostTopics = 32;
const mostTold = 1000;

/** The fourth argument of a converter in Lichtblick; Foxglove has none. */
export interface ConverterContext {
  emitAlert(alert: { severity: "warn"; message: string }, id: string): void;
}

/** Converts the messages of all topics. */
export class Converter {
  /** By topic; the one that was used last is the last. */
  private readonly decoders = new Map<string, TopicDecoder>();
  private readonly recent = new RecentClouds();
  private readonly told = new Set<string>();

  /** @param module the codec's, which the topics share */
  constructor(private readonly module: WebAssembly.Module) {}

  /** The cloud; undefined, which shows nothing, if there is none.
   * @param message what the application read as a CompressedPointCloud2, of which nothing is certain
   */
  convert(message: unknown, topic: string, context?: ConverterContext): PointCloud | undefined {
    const tell = (kind: string, problem: string) => this.tell(`${topic} ${kind}`, `${topic}: ${problem}`, context);
    const fault = faultOf(message);
    if (fault) {
      tell(fault.kind, fault.problem);
      return undefined;
    }
    const { header, compressed_data: bytes } = message as CompressedCloud;
    const { points, problem } = this.decode(bytes, topic, context);
    // After a seek there is nothing to tell.
    if (problem && problem.code !== "MissingReference" && problem.code !== "OldFrame") tell(problem.code, problem.message);
    return points ? { timestamp: header.stamp, frame_id: header.frame_id, ...points } : undefined;
  }

  private decode(bytes: Uint8Array, topic: string, context?: ConverterContext): Decoded {
    try {
      return this.decoderOf(topic, context).decode(bytes);
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      return { points: null, problem: { code: "OutOfMemory", message: "out of memory" } };
    }
  }

  private decoderOf(topic: string, context?: ConverterContext): TopicDecoder {
    const known = this.decoders.get(topic);
    if (known) this.decoders.delete(topic);
    else if (this.decoders.size >= mostTopics) this.dropOldestTopic(context);
    const decoder = known ?? new TopicDecoder(this.module, this.recent);
    this.decoders.set(topic, decoder);
    return decoder;
  }

  private dropOldestTopic(context?: ConverterContext): void {
    const [oldest] = this.decoders;
    if (!oldest) return;
    const [topic, decoder] = oldest;
    this.decoders.delete(topic);
    this.recent.forget(decoder);
    this.tell("topics", `more than ${mostTopics} topics: of one that was left out there is nothing until its next I-frame`, context);
  }

  /** Tells a problem once. */
  private tell(id: string, message: string, context?: ConverterContext): void {
    if (this.told.has(id)) return;
    this.told.add(id);
    const [oldest] = this.told;
    if (this.told.size > mostTold && oldest !== undefined) this.told.delete(oldest);
    if (context?.emitAlert) context.emitAlert({ severity: "warn", message }, id);
    else console.warn(message);
  }
}
