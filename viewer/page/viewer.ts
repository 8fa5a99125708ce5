// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { ControlPanel } from "./controls/control_panel";
import { createHelp } from "./controls/help_overlay";
import { listenToKeys } from "./keyboard";
import { LiveBanner } from "./controls/live_banner";
import { Notices } from "./controls/notices";
import { followTheme, isDark, sceneColours } from "./controls/theme";
import { VoxelDetails } from "./controls/voxel_details";
import { DecodingService } from "./decoding/decoding_service";
import type { FromWorker } from "./decoding/messages";
import { exportPicture, exportPly } from "./export/exports";
import { LiveView } from "./live_view";
import { layOutPage } from "./page_layout";
import type { PageLayout } from "./page_layout";
import { ViewerScene } from "./scene/viewer_scene";
import type { Damage } from "./recordings/frame_places";
import { AskedSources } from "./sources/asked_sources";
import { acceptDrops } from "./sources/dropped_files";
import { chooseSource, sourceOfFiles } from "./sources/source_choice";
import type { Source } from "./sources/source_choice";
import { forgetLinkedFile, keepLinkUpToDate, readLink, unlinkedState } from "./state/page_link";
import type { LinkedView } from "./state/page_link";
import { createStore, fieldOf, noCut, trailSeconds } from "./state/viewer_state";
import { publishHook } from "./test_hook";
import { FrameIndex } from "./timeline/frame_index";
import { Playback } from "./timeline/playback";
import { TimelineView } from "./timeline/timeline_view";
import type { TimelineActions } from "./timeline/timeline_view";
import { StreamsOnScreen } from "./streams_on_screen";

function placeOf({ file, offset, message }: Damage): string {
  return `${file}, byte ${offset}: ${message}`;
}

/** The page: connects its parts. */
export class Viewer {
  readonly store = createStore();
  readonly index = new FrameIndex();
  readonly notices = new Notices();
  readonly screen: StreamsOnScreen;
  readonly scene: ViewerScene;
  readonly playback: Playback;
  private readonly panel: ControlPanel;
  readonly timeline: TimelineView;
  private readonly details: VoxelDetails;
  private readonly layout: PageLayout;
  readonly decoding: DecodingService;
  private readonly linkedView: LinkedView;
  private readonly updateLink: () => void;
  private readonly asked = new AskedSources();
  private shown = -1; // number of the source
  readonly banner = new LiveBanner();
  private live: LiveView | null = null;
  private damage: string[] = [];
  private remarks: string[] = [];
  private isTimeChosen = false; // by the user; until then a recording is at its first frame or at that of the link
  private request = 0;
  private shownFrames = ""; // that were asked for last
  private waiting: (() => void)[] = []; // for the frames that were asked for last

  constructor(workerCode: string, wasm: ArrayBuffer) {
    const link = readLink(location.hash);
    this.linkedView = link.view;
    this.store.set(link.state);
    this.playback = new Playback(this.store, this.index, (moment) => this.requestFrames(moment));
    this.timeline = new TimelineView(this.store, this.index, this.timeActions());
    this.panel = new ControlPanel(this.store, {
      fit: (direction) => this.fit(direction),
      exportPly: () => exportPly(this),
      exportPicture: () => void exportPicture(this),
      copyLink: () => this.copyLink(),
    });
    this.details = new VoxelDetails(() => this.screen.selection.clear(), () => this.screen.selection.toggleMeasuring());
    this.layout = layOutPage(this.store,
      { open: () => this.layout.fileInput.click(), toggleTheme: () => this.toggleTheme() },
      { panel: this.panel.root, timeline: this.timeline.root, help: createHelp(this.store),
        overlays: [this.banner.root, this.notices.root, this.details.root] });
    this.scene = new ViewerScene(this.layout.canvas, () => this.updateLink?.());
    this.updateLink = keepLinkUpToDate(this.store, () => this.currentView());
    this.screen = new StreamsOnScreen(this.store, this.scene, this.index, this.panel, this.details, this.notices,
      this.layout.status, (buffer) => this.recycle(buffer));
    this.decoding = new DecodingService(workerCode, wasm, (message) => this.receive(message));
    followTheme(this.store, () => {
      this.scene.setColours(sceneColours());
      this.timeline.requestDraw();
      this.panel.threshold.draw();
    });
    this.listen();
  }

  start(): void {
    publishHook(this);
    chooseSource().then(
      (source) => source && this.open(source, false),
      (error: Error) => this.fail(error.message),
    );
  }

  private listen(): void {
    acceptDrops((files) => this.openFiles(files),
      (message) => this.notices.show("drop", "warning", "What was dropped cannot be opened", [message]));
    this.layout.fileInput.addEventListener("change", () => {
      const files = [...(this.layout.fileInput.files ?? [])];
      this.layout.fileInput.value = "";
      if (files.length > 0) this.openFiles(files);
    });
    listenToKeys(this.store, {
      ...this.timeActions(),
      fit: () => this.fit("keep"),
      moveCamera: (turn, tilt, zoom) => this.scene.camera.move(turn, tilt, zoom),
      changeThreshold: (by) => this.screen.changeThreshold(by),
      toggleTheme: () => this.toggleTheme(),
      open: () => this.layout.fileInput.click(),
      exportPly: () => exportPly(this),
      exportPicture: () => void exportPicture(this),
      deselect: () => this.screen.selection.clear(),
    });
    addEventListener("hashchange", () => this.followLink());
    this.layout.canvas.addEventListener("webglcontextlost", () =>
      this.notices.show("webgl", "error", "The graphics card has stopped",
        ["The browser tries to start it again. If nothing appears, reload the page."]));
    this.layout.canvas.addEventListener("webglcontextrestored", () => {
      this.notices.withdraw("webgl");
      this.scene.requestDrawing();
    });
    this.store.subscribe((changed) => {
      if (changed.has("removesOutliers") || changed.has("colourBy")) this.applyDecodingSettings();
      this.updateLink?.();
    });
  }

  /** What the user does to the time: from then on no link changes it. */
  private timeActions(): TimelineActions {
    const chosen = (act: () => void): void => {
      this.isTimeChosen = true;
      act();
    };
    return {
      togglePlay: () => chosen(() => this.togglePlay()),
      step: (by) => chosen(() => this.playback.step(by)),
      seek: (moment) => chosen(() => this.playback.seek(moment)),
    };
  }

  /** Plays and pauses a recording, and freezes the picture of a live source. */
  private togglePlay(): void {
    if (this.store.get().source === "live") this.live?.toggleFrozen();
    else this.playback.togglePlay();
  }

  private applyDecodingSettings(): void {
    const { removesOutliers, colourBy, moment, source } = this.store.get();
    const settings = { removesOutliers, trailSeconds: colourBy === "age" ? trailSeconds : 0, field: fieldOf(colourBy) };
    if (!this.screen.setDecodingSettings(settings)) return;
    this.decoding?.post({ type: "settings", settings });
    if (source === "recording") this.playback.seek(moment);
  }

  /** Shows what a link says that was put into the page's address. */
  private followLink(): void {
    const { state, view } = readLink(location.hash);
    this.store.set({ ...unlinkedState(), ...state });
    if (view.camera) this.scene.camera.setValues(view.camera);
    if (view.time === null) return;
    // Until its time is indexed, the frame of the link is the last one that is known.
    this.linkedView.time = view.time;
    this.isTimeChosen = false;
    this.playback.seek(this.index.momentAt(view.time));
  }

  private openFiles(files: readonly File[]): void {
    this.open(sourceOfFiles(files), true);
  }

  /** What is shown stays until the source has frames. */
  private open(source: Source, isChosen: boolean): void {
    const number = this.asked.add({ source, isChosen });
    this.notices.withdraw("failed");
    if (this.store.get().source === "none") this.store.set({ source: "opening", name: source.name });
    this.store.set({ isOpening: true });
    if (source.kind === "recording") this.decoding.post({ type: "open", source: number, files: source.files });
    else this.decoding.post({ type: "openLive", source: number });
  }

  /** The source has nothing to show. */
  private refuse({ source: number, message, damage }: FromWorker & { type: "refused" }): void {
    const { name } = this.asked.take(number).source;
    this.store.set({ isOpening: !this.asked.isEmpty });
    const title = message.includes(name) ? "This cannot be shown" : `“${name}” cannot be shown`;
    this.notices.show("failed", "error", title, [message]);
    if (this.store.get().source !== "opening") return;
    if (damage.length > 0) this.notices.show("damage", "warning", "The recording is damaged", damage.map(placeOf));
    if (this.asked.isEmpty) this.store.set({ source: "none", name: "" });
  }

  private begin(number: number): void {
    const { source, isChosen } = this.asked.take(number);
    if (isChosen) forgetLinkedFile();
    if (number > 0) {
      // They were another recording's.
      this.linkedView.time = null;
      this.store.set(noCut);
    }
    this.shown = number;
    this.isTimeChosen = false;
    this.live?.close();
    this.live = null;
    this.index.clear();
    this.scene.forgetView();
    this.notices.clear();
    this.damage = [];
    this.remarks = [];
    this.screen.clear();
    ++this.request;
    this.store.set({
      source: "opening", name: source.name, isOpening: !this.asked.isEmpty, moment: 0, isPlaying: false, isFrozen: false, isConnected: false, hasEnded: false,
      indexedShare: 0, showsPanel: false,
    });
    this.timeline.requestDraw();
    if (source.kind === "live") this.live = new LiveView(source.socket, this);
    else if (source.leftOut.length > 0)
      this.remark(`Files of frames and .mcap files are different recordings. Left out: ${source.leftOut.join(", ")}.`);
  }

  private fail(message: string): void {
    const { name, source } = this.store.get();
    const what = name && !message.includes(name) ? `“${name}”` : null;
    const isPart = this.index.moments.length > 0;
    const title = isPart ? `The rest of ${what ?? "it"} cannot be read` : `${what ?? "This"} cannot be shown`;
    this.notices.show("failed", "error", title, [message]);
    this.store.set({ isPlaying: false });
    if (isPart) this.store.set({ indexedShare: 1 });
    if (isPart || source === "live") return;
    this.screen.clear();
    this.store.set({ source: "none", name: "", isOpening: false });
  }

  private remark(message: string): void {
    this.remarks.push(message);
    this.notices.show("remark", "info", "Not all of it is shown", this.remarks);
  }

  private recycle(buffer: ArrayBuffer): void {
    this.decoding.post({ type: "recycle", buffer }, [buffer]);
  }

  private receive(message: FromWorker): void {
    switch (message.type) {
      case "loaded":
        break;
      case "opened":
        this.begin(message.source);
        break;
      case "refused":
        this.refuse(message);
        break;
      case "failed":
        this.fail(message.message);
        break;
      case "streams":
        this.screen.setStreams(message.streams);
        this.live?.forgetHeld(message.streams.flatMap(({ isGone }, stream) => (isGone ? [stream] : [])));
        break;
      case "frames":
        this.receiveFrames(message);
        break;
      case "placesChanged":
        this.screen.placeAnew();
        if (this.store.get().source === "recording") this.playback.refresh();
        break;
      case "damage":
        this.damage.push(placeOf(message.damage));
        this.notices.show("damage", "warning", "The recording is damaged; the rest of it is shown", this.damage);
        break;
      case "remark":
        this.remark(message.message);
        break;
      case "undecodable":
        this.index.markLost(message.stream, message.number);
        this.timeline.requestDraw();
        if (message.failure === "TooLarge")
          this.remark(`${message.name}, frame ${message.number + 1} is too large for the memory of this page (${message.problem}). ` +
            "The recording is not damaged: pcl_ext decode reads it, and larger voxels (pcl_ext encode -r) are shown.");
        else {
          this.damage.push(`${message.name}, frame ${message.number + 1}: ${message.problem}`);
          this.notices.show("damage", "warning", "The recording is damaged; the rest of it is shown", this.damage);
        }
        break;
      case "progress":
        this.store.set({ indexedShare: message.share });
        break;
      case "indexed":
        this.store.set({ indexedShare: 1 });
        if (!message.isWhole && this.damage.length === 0)
          this.notices.show("unfinished", "warning", "The file is not complete", ["Its end is missing; all frames before it are shown."]);
        break;
      case "shown":
        this.screen.show(message.frames, message.request === this.request, this.linkedView.time === null || this.isTimeChosen);
        if (message.request === this.request) {
          this.playback.shown();
          for (const resolve of this.waiting.splice(0)) resolve();
          this.showLinkedView();
          this.timeline.requestDraw();
        }
        break;
      case "clockBegan":
        this.index.clear();
        this.screen.beginAxis();
        break;
      case "liveShown":
        this.live?.show(message);
        break;
    }
  }

  private receiveFrames(message: FromWorker & { type: "frames" }): void {
    this.index.startTime = message.startTime;
    this.index.hasTimes = message.hasTimes;
    this.index.add(message.batch);
    if (this.store.get().source === "live") {
      this.live?.updateIndex();
      return;
    }
    this.index.update();
    this.timeline.requestDraw();
    const isFirst = this.store.get().source === "opening";
    if (isFirst) this.store.set({ source: "recording" });
    // Until its time is indexed, the frame of the link is the last one that is known.
    const first = this.index.momentAt(this.linkedView.time ?? -Infinity);
    const isElsewhere = first !== this.store.get().moment || this.framesOf(first) !== this.shownFrames;
    if (isFirst || (!this.isTimeChosen && isElsewhere)) this.playback.seek(first);
    else if (this.framesOf(this.store.get().moment) !== this.shownFrames) this.playback.refresh();
  }

  /** Which frames belong to a moment, to be compared. */
  private framesOf(moment: number): string {
    return this.index.streams.map((_, stream) => this.index.frameAt(stream, moment)).join();
  }

  private requestFrames(moment: number): void {
    this.shownFrames = this.framesOf(moment);
    const frames = this.index.streams.flatMap((_, stream) => {
      const number = this.index.frameAt(stream, moment);
      return number >= 0 ? [{ stream, number }] : [];
    });
    this.decoding.post({ type: "show", source: this.shown, request: ++this.request, frames });
  }

  /** Once, the camera and the time of the link that the page was opened with. */
  private showLinkedView(): void {
    if (!this.linkedView.camera) return;
    this.scene.camera.setValues(this.linkedView.camera);
    this.linkedView.camera = null;
  }

  private currentView(): LinkedView {
    const { source, moment, indexedShare } = this.store.get();
    // What a link says is kept until it is shown, as the page may be loaded again before.
    const isComing = this.linkedView.time !== null && !this.isTimeChosen && source !== "live" && indexedShare < 1;
    return {
      camera: this.linkedView.camera ?? (this.scene.bounds ? this.scene.camera.values() : null),
      time: isComing ? this.linkedView.time : source === "recording" ? (this.index.moments[moment] ?? null) : null,
    };
  }

  /** Resolves when the frames of a moment are drawn. */
  seekAndWait(moment: number): Promise<void> {
    this.isTimeChosen = true;
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.playback.seek(moment);
    });
  }

  damageFound(): string[] {
    return [...this.damage];
  }

  fit(direction: "oblique" | "top" | "front" | "side" | "keep"): void {
    this.screen.measure();
    this.scene.fit(direction);
  }

  private toggleTheme(): void {
    this.store.set({ theme: isDark(this.store) ? "light" : "dark" });
  }

  private copyLink(): void {
    this.updateLink();
    setTimeout(() => {
      const done = navigator.clipboard?.writeText(location.href) ?? Promise.reject(new Error("no clipboard"));
      done.then(
        () => this.notices.show("link", "info", "The link is copied", ["It opens this view with the same camera and settings."]),
        () => this.notices.show("link", "info", "The address of this page is the link", [location.href]),
      );
    }, 500);
  }
}
