// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { ControlPanel } from "./controls/control_panel";
import type { Notices } from "./controls/notices";
import { formatBytesPerSecond, formatCount, formatCounted, formatSeconds, formatSilence } from "./controls/number_format";
import type { VoxelDetails } from "./controls/voxel_details";
import type { DecodingSettings, ShownFrame, StreamDescription } from "./decoding/messages";
import { guessUp } from "./guessed_up";
import type { GuessedUp } from "./guessed_up";
import { bytesPerSecondAt, rateText } from "./timeline/byte_rate";
import { countDrawn, countKept } from "./scene/drawn_voxels";
import type { Pose } from "./recordings/transforms";
import { fieldAxisOf } from "./scene/field_axis";
import type { IntensityAxis } from "./scene/intensity_axis";
import { streamColours } from "./scene/stream_colours";
import type { ViewerScene } from "./scene/viewer_scene";
import { Selection } from "./selection";
import { Arrivals } from "./sources/arrivals";
import { AwakeClock } from "./sources/awake_clock";
import { fieldOf } from "./state/viewer_state";
import type { ViewerState, ViewerStore } from "./state/viewer_state";
import * as views from "./stream_views";
import type { StreamView } from "./stream_views";
import { shortName } from "./stream_names";
import type { FrameIndex } from "./timeline/frame_index";
import { element } from "./controls/dom";

/** After this time no stream is waited for, to place the camera. */
const msToBegin = 3000;

/** Figures are told after this time at the earliest, and take a tenth of all time at most. */
const msToFigures = 50;

/** What numbers of voxels depend on. */
const figureKeys = ["threshold", "hiddenStreams", "noise", "removesOutliers", "cutAbove", "cutBelow"] as const;

/** Why nothing of a stream is drawn or not all of it, or that it is old; null if all is well.
 * @param wasTried frames of a recording were read since it was opened
 * @param begin seconds from the start to the stream's first frame; undefined: it has none
 */
function noteOf(
  { shown, description, arrivals }: StreamView, state: ViewerState, wasTried: boolean, begin: number | undefined, now: number,
): string | null {
  const { source, hasEnded, isFrozen, indexedShare } = state;
  if (description.isGone) return "The source no longer has this stream";
  const silence = source === "live" && shown && !hasEnded ? arrivals.silence(now) : null;
  if (silence !== null) return `No frames for ${formatSilence(silence)}`;
  if (shown?.problem) return `Not shown: ${shown.problem}`;
  if (shown) return shown.placement?.problem ?? shown.warning;
  if (source !== "live" && wasTried && begin !== undefined) return `Begins at ${formatSeconds(begin)}`;
  if (source !== "live") return wasTried && indexedShare === 1 ? "No frame could be read" : null;
  return isFrozen && arrivals.age(now) !== null ? "Shown when the picture goes on" : "No frame has come yet";
}

/** What is drawn of each stream, with the figures that are told of it. */
export class StreamsOnScreen {
  readonly streams: StreamView[] = [];
  axis: IntensityAxis | null = null;
  private fieldAxis: IntensityAxis | null = null;
  private axisKey = ""; // the contents that the axis is for
  private guessedUp: GuessedUp = { up: "z", reason: "" };
  private hasFitted = false;
  private firstShown: number | null = null; // performance.now()
  private wasTried = false; // frames were read, if there were any
  private settings: DecodingSettings = { removesOutliers: false, trailSeconds: 0, field: null };
  private lastFilterRemark: string | null = null;
  private isWaiting = false;
  private msOfFigures = 0;
  private followed: { stream: number; pose: Pose } | null = null;
  readonly selection: Selection;
  private readonly rate = element("b");
  readonly clock = new AwakeClock();

  constructor(
    private readonly store: ViewerStore,
    private readonly scene: ViewerScene,
    private readonly index: FrameIndex,
    private readonly panel: ControlPanel,
    details: VoxelDetails,
    private readonly notices: Notices,
    private readonly status: HTMLElement,
    private readonly recycle: (buffer: ArrayBuffer) => void,
  ) {
    store.subscribe((changed) => {
      if (changed.has("hiddenStreams") || changed.has("colourBy")) this.chooseFieldAxis();
      const isDrawing = [...changed].some((key) => key !== "moment" && key !== "isPlaying" && key !== "indexedShare");
      if (isDrawing) this.apply();
      if (changed.has("hiddenStreams")) this.showSensors();
      if (changed.has("hiddenStreams") || changed.has("followsSensor")) this.follow(false);
      if (changed.has("up") && this.applyUp()) this.scene.fit("oblique");
      if (changed.has("indexedShare")) this.requestFigures();
      if (figureKeys.some((key) => changed.has(key))) this.updateFigures();
    });
    this.selection = new Selection(store, scene, this.streams, details);
  }

  clear(): void {
    for (let i = 0; i < this.scene.layers.length; ++i) this.showVoxels(i, null);
    this.streams.length = 0;
    this.scene.setStreams([]);
    this.hasFitted = false;
    this.firstShown = null;
    this.wasTried = false;
    this.beginAxis();
    this.selection.clear();
    this.lastFilterRemark = null;
    this.panel.streams.setStreams([], []);
    this.panel.threshold.clear();
    this.status.replaceChildren();
  }

  /** The axis of intensities is chosen for the next frames, as those of another source. */
  beginAxis(): void {
    this.axis = null;
  }

  setStreams(descriptions: readonly StreamDescription[]): void {
    if (descriptions.length > this.streams.length) {
      this.hasFitted = false;
      this.firstShown = null;
    }
    const names = descriptions.map(({ name }) => shortName(name));
    const colours = streamColours(names);
    descriptions.forEach((description, i) => {
      const { shown, contents, arrivals } =
        this.streams[i] ?? { shown: null, contents: null, arrivals: new Arrivals(this.clock) };
      this.streams[i] = { description, colour: colours[i], shown, contents, arrivals };
    });
    this.scene.setStreams(colours);
    if (!this.store.get().isFrozen) this.removeGone();
    this.panel.streams.setStreams(names, colours);
    this.scene.setCropBox(views.cropBoxOf(this.streams));
    this.showSensors();
    this.apply();
    this.requestFigures();
  }

  /** Shows nothing of streams that the source has no more. */
  removeGone(): void {
    this.streams.forEach(({ description }, i) => description.isGone && this.hide(i));
  }

  private hide(stream: number): void {
    this.streams[stream].shown = null;
    this.showVoxels(stream, null);
  }

  private showSensors(): void {
    this.scene.setSensors(views.sensorPoses(this.streams, (stream) => this.isVisible(stream)));
  }

  isVisible(stream: number): boolean {
    const name = this.streams[stream]?.description.name;
    return name !== undefined && !this.store.get().hiddenStreams.includes(shortName(name));
  }

  /** True if they have changed. */
  setDecodingSettings(settings: DecodingSettings): boolean {
    const isSame = settings.removesOutliers === this.settings.removesOutliers &&
      settings.trailSeconds === this.settings.trailSeconds && settings.field === this.settings.field;
    this.settings = settings;
    this.lastFilterRemark = null;
    return !isSame;
  }

  private showVoxels(stream: number, frame: ShownFrame | null): void {
    const { resolution = 0, time = -Infinity, placement } = frame ?? {};
    const before = this.scene.show(stream, frame?.voxels ?? null, { resolution, time, pose: placement?.pose }, this.store.get());
    if (before) this.recycle(before);
  }

  /** Takes decoded frames; those that are no longer wanted are given back.
   * @param movesCamera with the sensor that is followed
   */
  show(frames: readonly ShownFrame[], isWanted: boolean, movesCamera = true): void {
    if (!isWanted) {
      for (const { voxels } of frames) if (voxels) this.recycle(voxels.buffer);
      return;
    }
    for (const frame of frames) {
      const stream = this.streams[frame.stream];
      if (!stream) continue;
      stream.shown = frame;
      stream.contents = views.contentsOf(frame, stream.contents);
      this.showVoxels(frame.stream, frame);
      if (frame.problem && this.store.get().source === "recording") this.index.markLost(frame.stream, frame.number);
      if (frame.filterProblem) this.lastFilterRemark = frame.filterProblem;
    }
    const { source, moment } = this.store.get();
    // Streams that begin later.
    if (source === "recording")
      this.streams.forEach(({ shown }, i) => shown && this.index.frameAt(i, moment) < 0 && this.hide(i));
    this.wasTried = true;
    if (frames.length === 0) return;
    if (!this.axis || !this.hasFitted || this.axisKey !== views.contentsKey(this.streams)) this.chooseAxis();
    this.chooseFieldAxis();
    this.apply();
    this.tellFrames();
    if (this.streams.some(({ description, shown }) => description.metadata.sensor_pose && shown?.placement)) this.showSensors();
    if (!this.hasFitted && frames.some((frame) => frame.voxels)) this.fitOnce();
    this.follow(movesCamera);
    this.selection.follow();
    this.requestFigures();
  }

  /** Remembers where the first stream that moves is, if it is followed. */
  private follow(movesCamera: boolean): void {
    const stream = this.streams.findIndex(({ shown }, i) => this.isVisible(i) && shown?.placement?.isMoving);
    this.panel.setMoving(stream >= 0);
    const pose = this.store.get().followsSensor ? this.streams[stream]?.shown?.placement?.pose : undefined;
    const before = this.followed?.stream === stream ? this.followed.pose : undefined;
    this.followed = pose ? { stream, pose } : null;
    if (pose && before && movesCamera)
      this.scene.camera.carry([pose[0] - before[0], pose[1] - before[1], pose[2] - before[2]]);
  }

  /** True if another axis points up than before. */
  private applyUp(): boolean {
    const { up } = this.store.get();
    if (!this.scene.setUp(up === "auto" ? this.guessedUp.up : up)) return false;
    this.measure();
    return true;
  }

  /** The view of all that the first frames have, which come one after the other. */
  private fitOnce(): void {
    if (!this.measure()) return; // empty frames
    this.guessedUp = guessUp(this.streams, this.scene.layers);
    this.panel.setGuessedUp(this.guessedUp);
    this.applyUp();
    this.scene.fitUnlessPlaced();
    this.firstShown ??= performance.now();
    const isOver = performance.now() - this.firstShown > msToBegin;
    this.hasFitted = isOver || this.streams.every(({ shown }) => shown !== null);
  }

  /** The view is fitted again to the next frames, which may be drawn elsewhere. */
  placeAnew(): void {
    this.hasFitted = false;
    this.firstShown = null;
  }

  /** Says which streams do not lie in one frame of coordinates. */
  private tellFrames(): void {
    const remark = views.frameRemark(this.streams);
    if (remark) this.notices.show("frames", "info", "Different coordinates", [remark]);
    else this.notices.withdraw("frames");
  }

  /** False if nothing is drawn. */
  measure(): boolean {
    const { noise, threshold } = this.store.get();
    if (!this.scene.measure(noise === "hide" ? threshold : -Infinity)) return false;
    this.panel.setHeights(this.scene.heightRange);
    return true;
  }

  private chooseAxis(): void {
    const drawn = this.scene.layers.flatMap(({ arrays }) => (arrays ? [arrays.intensities] : []));
    this.axisKey = views.contentsKey(this.streams);
    this.axis = views.axisOf(this.streams, drawn);
    if (this.axis) this.panel.setAxis(this.axis);
    const contents = this.streams.flatMap((stream) => (stream.contents ? [stream.contents] : []));
    const hasIntensities = contents.some((stream) => stream.hasIntensities);
    const hasColours = contents.some((stream) => stream.hasColours);
    this.panel.setContents({
      hasColours,
      hasIntensities,
      hasSensors: this.streams.some(({ description }) => description.metadata.sensor_pose),
      hasCropBox: views.cropBoxOf(this.streams) !== null,
      fields: [...new Set(contents.flatMap(({ fields }) => fields))],
    });
    this.store.set({ colourBy: views.possibleColour(this.store.get().colourBy, this.streams) });
  }

  /** The axis of the field that voxels are coloured by follows the values that are shown. */
  private chooseFieldAxis(): void {
    const field = fieldOf(this.store.get().colourBy);
    const shown = this.scene.layers.flatMap(({ voxels, arrays }, i) =>
      this.isVisible(i) && arrays?.field && voxels?.field === field ? [arrays.field] : []);
    this.fieldAxis = fieldAxisOf(shown);
    this.panel.setFieldAxis(this.fieldAxis);
  }

  private apply(): void {
    this.scene.apply(this.store.get(), (stream) => this.isVisible(stream), this.axis ?? views.noAxis, this.fieldAxis);
  }

  changeThreshold(by: number): void {
    if (!this.axis) return;
    const { min, max, step } = this.axis;
    const size = this.axis.isLogarithmic ? step : Math.max(step, (max - min) / 100);
    this.store.set({ threshold: this.axis.rounded(this.store.get().threshold + by * size) });
  }

  private requestFigures(): void {
    if (this.isWaiting) return;
    this.isWaiting = true;
    setTimeout(() => {
      this.isWaiting = false;
      const begin = performance.now();
      this.updateFigures();
      this.msOfFigures = performance.now() - begin;
    }, Math.max(msToFigures, 10 * this.msOfFigures));
  }

  /** Voxels drawn and all voxels, of the streams that are on. */
  counts(): { kept: number; drawn: number; all: number } {
    const { threshold } = this.store.get();
    const rule = this.scene.rule();
    let kept = 0;
    let drawn = 0;
    let all = 0;
    this.scene.layers.forEach((layer, i) => {
      if (!this.isVisible(i)) return;
      kept += countKept(layer, threshold);
      drawn += countDrawn(layer, rule);
      all += layer.voxels?.count ?? 0;
    });
    return { kept, drawn, all };
  }

  updateFigures(): void {
    const { moment, source, removesOutliers, indexedShare, isFrozen } = this.store.get();
    const rule = this.scene.rule();
    const { kept, drawn, all } = this.counts();
    const histogram = this.panel.threshold;
    histogram.clear();
    this.scene.layers.forEach((layer, i) => {
      const isDrawn = this.isVisible(i);
      if (isDrawn && layer.arrays && layer.voxels) histogram.add(layer.arrays.intensities, layer.voxels.count);
      this.panel.streams.setCount(i, layer.voxels ? countDrawn(layer, rule) : null);
    });
    histogram.draw();
    const isLate = isFrozen && this.streams.some(({ shown }) => shown?.voxels && shown.voxels.isJudged !== removesOutliers);
    const remark = isLate ? "The picture is paused: the outlier filter follows when it goes on."
      : removesOutliers ? (this.lastFilterRemark ?? views.lawRemark(this.streams)) : null;
    this.panel.setRemoved(kept, all, remark);
    if (this.streams.length === 0) return;
    const lost = this.streams.filter(({ shown }, i) => shown?.problem && this.isVisible(i)).length;
    const decodeMs = this.streams.reduce((sum, { shown }) => sum + (shown?.decodeMs ?? 0), 0);
    const parts: [string, string][] = [
      [`${formatCount(drawn)} of ${formatCount(all)}`, all === 1 ? "voxel" : "voxels"],
      ...(source === "recording" ? [["frame", `${formatCount(moment + 1)} of ${formatCount(this.index.moments.length)}`] as [string, string]] : []),
      ["", "compressed"],
      [`${decodeMs.toFixed(1)} ms`, "to decode"],
    ];
    this.status.replaceChildren(...parts.map(([value, name]) =>
      value === "frame"
        ? element("span", { class: "figure" }, "frame ", element("b", {}, name))
        : element("span", { class: "figure" }, name === "compressed" ? this.rate : element("b", {}, value), ` ${name}`)));
    this.updateFreshness();
    if (source === "recording" && indexedShare < 1)
      this.status.append(element("span", { class: "figure" }, element("b", {}, `${Math.round(100 * indexedShare)} %`), " read"));
    const nothing = this.nothingDrawn(drawn, kept, all);
    if (nothing) this.status.append(element("span", { class: "figure lost" }, nothing));
    const lostText = `${lost} of ${formatCounted(this.streams.length, "stream")} lost`;
    if (lost > 0) this.status.append(element("span", { class: "figure lost" }, lostText));
  }

  /** Ages, rate and remarks, which change while no frames come, too. */
  updateFreshness(): void {
    const state = this.store.get();
    const now = performance.now();
    const isLive = state.source === "live";
    this.streams.forEach((stream, i) => {
      const first = this.index.streams[i]?.times[0];
      const begin = first === undefined ? first : first - (this.index.moments[0] ?? 0);
      this.panel.streams.setNote(i, noteOf(stream, state, this.wasTried, begin, now));
      this.panel.streams.setAge(i, isLive ? stream.arrivals.age(now) : null);
    });
    this.rate.textContent = isLive
      ? formatBytesPerSecond(this.streams.reduce((sum, { arrivals }) => sum + arrivals.bytesPerSecond(now), 0))
      : rateText(this.index, bytesPerSecondAt(this.index, state.moment));
  }

  /** Why nothing is drawn, where that is by what the user has set. */
  private nothingDrawn(drawn: number, kept: number, all: number): string | null {
    if (drawn > 0) return null;
    if (kept > 0) return "all voxels are cut off, by their heights";
    if (all > 0) return "all voxels are noise, by threshold or outlier filter";
    return this.streams.every((_, i) => !this.isVisible(i)) ? "all streams are off" : null;
  }
}
