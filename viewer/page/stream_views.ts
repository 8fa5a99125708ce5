// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ShownFrame, StreamDescription } from "./decoding/messages";
import type { Arrivals } from "./sources/arrivals";
import { combined, identity } from "./recordings/transforms";
import type { Pose } from "./recordings/transforms";
import { IntensityAxis } from "./scene/intensity_axis";
import { numbersOf } from "./scene/surroundings";
import type { Bounds } from "./scene/camera_fit";
import type { SensorPose } from "./scene/surroundings";
import { cssColour } from "./scene/colour_maps";
import type { Rgb } from "./scene/colour_maps";
import { fieldOf } from "./state/viewer_state";
import type { ColourBy } from "./state/viewer_state";
import { shortName } from "./stream_names";

/** What the settings that are offered depend on. */
export interface StreamContents {
  intensityRange: ShownFrame["intensityRange"];
  hasColours: boolean;
  hasIntensities: boolean;
  fields: readonly string[];
}

/** A stream as the page knows it. */
export interface StreamView {
  description: StreamDescription;
  colour: Rgb;
  shown: ShownFrame | null;
  /** What its last frame with voxels had: frames that are lost between others change nothing. */
  contents: StreamContents | null;
  /** Of a live stream. */
  arrivals: Arrivals;
}

/** Before anything is known of the intensities. */
export const noAxis = new IntensityAxis(0, 255, 1, false);

/** The axis for the intensities of all streams that are shown. */
export function axisOf(streams: readonly StreamView[], intensities: readonly Float32Array[]): IntensityAxis | null {
  const ranges = streams.flatMap(({ contents }) => (contents?.intensityRange ? [contents.intensityRange] : []));
  if (ranges.length === 0) return null;
  const min = Math.min(...ranges.map((range) => range.min));
  const step = Math.min(...ranges.map((range) => range.step));
  const sorted = Float32Array.from(sampleOf(intensities)).sort();
  const highest = sorted[sorted.length - 1] ?? min;
  const top = Math.max(...ranges.map((range) => range.max));
  // Scales of 16 bits are seldom used up to their ends.
  const max = top - min > 1000 * step ? Math.min(top, Math.max(min + 10 * step, 1.1 * highest)) : top;
  const isCounted = streams.some(({ description }) => description.metadata.intensity_law === "count");
  const isKnown = streams.some(({ description }) => description.metadata.intensity_law !== undefined);
  const isLogarithmic = isCounted || (!isKnown && step === 1 && max <= 255);
  const common = sorted[Math.floor(0.99 * sorted.length)] ?? max;
  const bright = Math.min(max, Math.max(common, min + step));
  return new IntensityAxis(min, max, step || 1, isLogarithmic, bright);
}

/** What the axis of intensities was chosen for, to be compared. */
export function contentsKey(streams: readonly StreamView[]): string {
  return JSON.stringify(streams.map(({ contents, description }) => [contents, description.metadata.intensity_law]));
}

export function contentsOf(shown: ShownFrame, before: StreamContents | null): StreamContents | null {
  const { voxels, intensityRange, fields } = shown;
  return voxels ? { intensityRange, hasColours: voxels.hasColours, hasIntensities: voxels.hasIntensities, fields } : before;
}

/** What voxels are coloured by: what is set, unless no stream has it. */
export function possibleColour(colourBy: ColourBy, streams: readonly StreamView[]): ColourBy {
  const contents = streams.flatMap((stream) => (stream.contents ? [stream.contents] : []));
  const hasField = (name: string): boolean => contents.some(({ fields }) => fields.includes(name));
  const hasIntensities = contents.some((stream) => stream.hasIntensities);
  const hasColours = contents.some((stream) => stream.hasColours);
  const field = fieldOf(colourBy);
  const isThere = colourBy === "intensity" ? hasIntensities
    : colourBy === "recorded" ? hasColours
    : field === null || hasField(field);
  if (contents.length === 0 || isThere) return colourBy;
  // A stream that comes later may have the field, or colours.
  if (colourBy !== "intensity" && contents.length < streams.length) return colourBy;
  if (hasIntensities) return "intensity";
  if (hasField("intensity")) return "field:intensity";
  return hasColours ? "recorded" : "height";
}

/** Some of many values, evenly taken. */
function sampleOf(lists: readonly Float32Array[]): number[] {
  const total = lists.reduce((sum, list) => sum + list.length, 0);
  const every = Math.max(1, Math.floor(total / 50_000));
  return lists.flatMap((list) => [...list.filter((_, i) => i % every === 0)]);
}

export function sensorPoses(streams: readonly StreamView[], isVisible: (stream: number) => boolean): SensorPose[] {
  return streams.flatMap(({ description, shown, colour }, stream) => {
    const pose = numbersOf(description.metadata.sensor_pose, 7) as Pose | null;
    if (!pose || !isVisible(stream)) return [];
    const values = [...combined(shown?.placement?.pose ?? identity, pose)];
    return [{ name: shortName(description.name), colour: cssColour(colour), values }];
  });
}

/** The box that clouds were cropped to, if the recording tells. */
export function cropBoxOf(streams: readonly StreamView[]): Bounds | null {
  for (const { description } of streams) {
    const box = numbersOf(description.metadata.crop_box, 6);
    if (box) return { min: [box[0], box[1], box[2]], max: [box[3], box[4], box[5]] };
  }
  return null;
}

/** Says where streams cannot be drawn in one place; null if they can. */
export function frameRemark(streams: readonly StreamView[]): string | null {
  const frames = new Set(streams.flatMap(({ shown }) => (shown?.frameId ? [shown.placement?.root ?? shown.frameId] : [])));
  if (frames.size < 2) return null;
  const hasTransforms = streams.some(({ shown }) => shown?.placement);
  return `The streams have different coordinate frames (${[...frames].join(", ")}), each of which is drawn ` +
    "around the same origin, as " + (hasTransforms ? "no transform connects them."
      : "the recording does not tell how they lie to each other.");
}

/** What the filter of outliers cannot know. */
export function lawRemark(streams: readonly StreamView[]): string | null {
  const unknown = streams.filter(({ description }) => description.metadata.intensity_law === undefined);
  if (unknown.length === 0) return null;
  return `${unknown.map(({ description }) => shortName(description.name)).join(", ")}: the recording does not tell ` +
    "what its intensities are, so the filter judges only which voxels are occupied, unless frames have a depth model.";
}
