// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { cloudOf, faultOf, type CompressedCloud, type PointCloud, type Time } from "./messages";
import { RecentClouds } from "./recent_clouds";
import { TopicDecoder, type Decoded } from "./topic_decoder";

/** Each topic takes a memory of its own, which only grows. */
const mostTopics = 32;
/** Of topics that were left out, and of problems that were told. */
const mostNames = 1000;

/** The fourth argument of a converter in Lichtblick; Foxglove has none. */
export interface ConverterContext {
  /** Takes the place of the one with the same id. */
  emitAlert(alert: { severity: "warn" | "info"; message: string; tip?: string }, id: string): void;
}

type Tell = (kind: string, problem: string) => void;

/** Converts the messages of all topics. */
export class Converter {
  /** By topic; the one that was used last is the last. */
  private readonly decoders = new Map<string, TopicDecoder>();
  private readonly recent = new RecentClouds();
  /** Topics that had to make room for others. */
  private readonly leftOut = new Set<string>();
  /** What the console was told: topics with the kinds of their problems. */
  private readonly told = new Set<string>();
  /** Topics that wait for an I-frame. */
  private readonly waiting = new Set<string>();

  /** @param module the codec's, which the topics share */
  constructor(private readonly module: WebAssembly.Module) {}

  /** The cloud. Of a frame that cannot be decoded it is the last one of the topic, with its own time, as applications
   * clear the scene when the user seeks; undefined, which shows nothing, if there is none.
   * @param message what the application read as a CompressedPointCloud2, of which nothing is certain
   */
  convert(message: unknown, topic: string, context?: ConverterContext): PointCloud | undefined {
    const tell: Tell = (kind, problem) => this.tell(topic, kind, problem, context);
    const fault = faultOf(message);
    if (fault) {
      tell(fault.kind, fault.problem);
      return undefined;
    }
    const { points, problem } = this.decode(message as CompressedCloud, topic, tell);
    const last = points ? null : (this.decoders.get(topic)?.last() ?? null);
    const isWaiting = problem?.code === "MissingReference" || problem?.code === "OldFrame";
    if (isWaiting) this.tellWaiting(topic, last, context);
    else if (problem) tell(problem.code, problem.message);
    if (!points) return last ?? undefined;
    this.tellShown(topic, context);
    return cloudOf((message as CompressedCloud).header, points);
  }

  /** Tells that frames depend on others that the application has not given. */
  private tellWaiting(topic: string, last: PointCloud | null, context?: ConverterContext): void {
    addName(this.waiting, topic);
    const shown = last ? `the last cloud is shown, that of ${dateOf(last.timestamp)}` : "there is nothing to show";
    const next = "After a seek or a loss a topic begins again with its next I-frame. Play on, or have I-frames more often.";
    const alert = { severity: "warn", message: `Waiting for an I-frame: ${topic}`, tip: `${topic}: ${shown}. ${next}` } as const;
    if (context?.emitAlert) context.emitAlert(alert, waitingId(topic));
    else this.tell(topic, "Waiting", `waiting for an I-frame; until then ${shown}`);
  }

  /** Takes back that the topic waits, as far as applications let a converter do so. */
  private tellShown(topic: string, context?: ConverterContext): void {
    if (!this.waiting.delete(topic)) return;
    const tip = `${topic}: an I-frame came. Extensions cannot withdraw alerts; this one may be closed.`;
    context?.emitAlert?.({ severity: "info", message: `Shown again: ${topic}`, tip }, waitingId(topic));
  }

  private decode(message: CompressedCloud, topic: string, tell: Tell): Decoded {
    try {
      return this.decoderOf(topic, tell).decode(message);
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      return { points: null, problem: { code: "OutOfMemory", message: "out of memory" } };
    }
  }

  private decoderOf(topic: string, tell: Tell): TopicDecoder {
    const known = this.decoders.get(topic);
    if (known) this.decoders.delete(topic);
    else if (this.decoders.size >= mostTopics) this.leaveOutOldest();
    if (!known && this.leftOut.delete(topic))
      tell("LeftOut", `${mostTopics} topics are kept at most; of this one there is nothing until its next I-frame`);
    const decoder = known ?? new TopicDecoder(this.module, this.recent);
    this.decoders.set(topic, decoder);
    return decoder;
  }

  private leaveOutOldest(): void {
    const [oldest] = this.decoders;
    if (!oldest) return;
    const [topic, decoder] = oldest;
    this.decoders.delete(topic);
    this.recent.forget(decoder);
    addName(this.leftOut, topic);
  }

  /** Tells a problem of a topic: alerts, each time, as Lichtblick clears their list when it opens another recording, and
   * leaves alone one that is there; the console once for each kind. */
  private tell(topic: string, kind: string, problem: string, context?: ConverterContext): void {
    const id = `${topic} ${kind}`;
    const tip = `${topic}: ${problem}`;
    // The list shows the beginning of a message, and all of the tip.
    if (context?.emitAlert) context.emitAlert({ severity: "warn", message: `Clouds missing: ${topic}`, tip }, id);
    else if (!this.told.has(id)) {
      addName(this.told, id);
      console.warn(tip);
    }
  }
}

function waitingId(topic: string): string {
  return `${topic} Waiting`;
}

/** The user sees by it whether a cloud is of the recording that was open before. */
function dateOf({ sec, nsec }: Time): string {
  const date = new Date(1000 * sec + nsec / 1e6);
  return Number.isNaN(date.getTime()) ? `${sec} s` : date.toISOString();
}

/** Adds a name to some, of which the oldest is forgotten if they become too many. */
function addName(names: Set<string>, name: string): void {
  names.add(name);
  const [oldest] = names;
  if (names.size > mostNames && oldest !== undefined) names.delete(oldest);
}
