// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";

import type { PackedVoxels } from "../decoding/messages";
import type { Pose } from "../recordings/transforms";
import { colourMaps, texelsOf } from "./colour_maps";
import type { ColourMapName, Rgb } from "./colour_maps";
import { boundsOf, pick } from "./drawn_voxels";
import type { DrawingRule, PickedVoxel } from "./drawn_voxels";
import { placeClippingPlanes } from "./camera_fit";
import type { Bounds } from "./camera_fit";
import { DepthShading } from "./depth_shading";
import type { IntensityAxis } from "./intensity_axis";
import { PastFrames } from "./past_frames";
import { SceneCamera, fieldOfView } from "./scene_camera";
import type { ViewDirection } from "./scene_camera";
import { SelectionMarks } from "./selection_marks";
import type { MarkedVoxel } from "./selection_marks";
import { Surroundings } from "./surroundings";
import type { SceneColours, SensorPose } from "./surroundings";
import { scaleSprites } from "./text_sprite";
import { Up } from "./up_axis";
import type { UpAxis } from "./up_axis";
import { VoxelLayer } from "./voxel_layer";
import { fieldOf, noCut } from "../state/viewer_state";
import type { ViewerState } from "../state/viewer_state";

const leastPickedPixels = 4;
const colourModes = ["intensity", "height", "stream", "age", "recorded", "field"];

/** The scene with its camera: draws when something has changed, and only then. */
export class ViewerScene {
  readonly layers: VoxelLayer[] = [];
  readonly past = new PastFrames((layer) => this.scene.remove(layer.group));
  readonly surroundings = new Surroundings();
  readonly camera: SceneCamera;
  private up = new Up("z");
  bounds: Bounds | null = null; // of most voxels
  private readonly renderer: THREE.WebGLRenderer;
  private readonly shading: DepthShading;
  private readonly scene = new THREE.Scene();
  private readonly marks = new SelectionMarks();
  private readonly maps = new Map<ColourMapName, THREE.DataTexture>();
  private needsDrawing = true;
  private lastPicture: WebGLSync | null = null; // signalled when it is finished
  /** Number of times that it was drawn. */
  pictures = 0;
  private cut = noCut;
  /** Of most voxels, between which heights are coloured. */
  heightRange: [number, number] = [0, 1];
  private colours: SceneColours | null = null;
  private poses: SensorPose[] = [];
  private readonly uniforms = {
    threshold: { value: 0 },
    hidesNoise: { value: true },
    noiseColour: { value: new THREE.Vector3() },
    colourBy: { value: 0 },
    intensityAxis: { value: new THREE.Vector4(0, 255, 1, 1) },
    up: { value: new THREE.Vector3(0, 0, 1) },
    trailSeconds: { value: 2 },
    colourMap: { value: null as THREE.Texture | null },
    viewport: { value: new THREE.Vector2(1, 1) },
  };

  /** Throws if the browser has no WebGL 2. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly onDrawn: () => void,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, powerPreference: "high-performance" });
    // Colours are computed as they appear on the screen.
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    THREE.ColorManagement.enabled = false;
    this.shading = new DepthShading(this.renderer);
    this.camera = new SceneCamera(canvas, () => this.requestDrawing());
    this.scene.add(this.marks.group);
    this.surroundings.addTo(this.scene);
    for (const name of Object.keys(colourMaps) as ColourMapName[]) {
      const texture = new THREE.DataTexture(texelsOf(name), 256, 1);
      texture.magFilter = texture.minFilter = THREE.LinearFilter;
      texture.needsUpdate = true;
      this.maps.set(name, texture);
    }
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement as Element);
    this.renderer.setAnimationLoop(() => this.drawIfNeeded());
  }

  /** Says which axis of the coordinates points up. True if another one did before. */
  setUp(name: UpAxis): boolean {
    if (name === this.up.name) return false;
    this.up = new Up(name);
    this.uniforms.up.value.copy(this.up.vector);
    this.camera.setUp(this.up);
    this.setHeights();
    this.setGrid();
    this.setSensors(this.poses);
    return true;
  }

  private setHeights(): void {
    if (this.bounds) this.heightRange = this.up.heights(this.bounds);
  }

  requestDrawing(): void {
    this.needsDrawing = true;
  }

  private resize(): void {
    const parent = this.canvas.parentElement as HTMLElement;
    const width = Math.max(1, parent.clientWidth);
    const height = Math.max(1, parent.clientHeight);
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    const { x, y } = this.renderer.getDrawingBufferSize(this.uniforms.viewport.value);
    this.shading.setSize(x, y, this.renderer.getPixelRatio());
    this.camera.setAspect(width / height);
    if (this.camera.fitted) this.fit(this.camera.fitted);
    this.draw();
  }

  private drawIfNeeded(): void {
    this.camera.update();
    if (this.needsDrawing && !this.isGpuBusy()) this.draw();
  }

  /** True while the last picture is not finished: one more would stop the page until it is. */
  private isGpuBusy(): boolean {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    return this.lastPicture !== null && gl.getSyncParameter(this.lastPicture, gl.SYNC_STATUS) === gl.UNSIGNALED;
  }

  private draw(): void {
    this.needsDrawing = false;
    ++this.pictures;
    scaleSprites(this.scene, this.canvas.clientHeight || 1, fieldOfView);
    const { perspective, target } = this.camera;
    placeClippingPlanes(perspective, target, this.bounds, this.allBounds());
    const { cutBelow, cutAbove } = this.cut;
    for (const { layer } of this.layersOfStreams()) {
      layer.chooseDetail(perspective, this.uniforms.viewport.value.y);
      layer.setHeights(this.up.vector, [cutBelow, cutAbove], this.heightRange);
    }
    this.shading.draw(this.scene, perspective);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (this.lastPicture) gl.deleteSync(this.lastPicture);
    this.lastPicture = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.onDrawn();
  }

  /** Has a layer for each stream, with its colour. */
  setStreams(colours: readonly Rgb[]): void {
    if (colours.length < this.layers.length) this.past.clear();
    while (this.layers.length > colours.length) {
      const layer = this.layers.pop() as VoxelLayer;
      this.scene.remove(layer.group);
      layer.dispose();
    }
    while (this.layers.length < colours.length) this.layers.push(this.addLayer(null));
    this.layersOfStreams().forEach(({ stream, layer }) => layer.setColour(colours[stream]));
    this.requestDrawing();
  }

  private addLayer(unused: VoxelLayer | null): VoxelLayer {
    const layer = unused ?? new VoxelLayer(this.uniforms);
    this.scene.add(layer.group);
    return layer;
  }

  /** Those of the frames that are shown, and those of the frames before. */
  private layersOfStreams(): { stream: number; layer: VoxelLayer }[] {
    return [...this.layers.map((layer, stream) => ({ stream, layer })), ...this.past.layers];
  }

  /** Returns the buffer that is no longer needed. The frame before stays for the decay time. */
  show(stream: number, voxels: PackedVoxels | null, frame: { resolution: number; time: number; pose?: Pose },
    { voxelScale, decaySeconds }: ViewerState): ArrayBuffer | null {
    const last = this.layers[stream];
    let before: ArrayBuffer | null = null;
    this.past.trim(stream, frame.time, decaySeconds);
    if (voxels && last.count > 0 && last.time < frame.time && last.time >= frame.time - decaySeconds) {
      before = last.release();
      this.layers[stream] = this.addLayer(this.past.keep(stream, last.time, last));
      this.layers[stream].takeColour(last);
    }
    const layer = this.layers[stream];
    before = layer.show(voxels, frame.resolution, frame.pose) ?? before;
    layer.time = frame.time;
    layer.setScale(voxelScale);
    this.requestDrawing();
    return before;
  }

  apply(state: ViewerState, isVisible: (stream: number) => boolean, axis: IntensityAxis,
    fieldAxis: IntensityAxis | null): void {
    const uniforms = this.uniforms;
    uniforms.threshold.value = state.threshold;
    uniforms.hidesNoise.value = state.noise === "hide";
    this.cut = { cutBelow: state.cutBelow, cutAbove: state.cutAbove };
    const field = fieldOf(state.colourBy);
    uniforms.colourBy.value = colourModes.indexOf(field === null ? state.colourBy : "field");
    uniforms.intensityAxis.value.set(axis.min, axis.bright, axis.step, axis.isLogarithmic ? 1 : 0);
    const map = state.colourBy === "height" || state.colourBy === "age" ? state.colourBy : "intensity";
    uniforms.colourMap.value = this.maps.get(map) ?? null;
    if (state.decaySeconds === 0) this.past.clear();
    this.layersOfStreams().forEach(({ stream, layer }) => {
      layer.group.visible = isVisible(stream);
      layer.setShape(state.shape);
      layer.setScale(state.voxelScale);
      layer.setField(field, fieldAxis);
    });
    this.surroundings.grid.visible = state.showsGrid;
    this.surroundings.axes.visible = state.showsAxes;
    this.surroundings.sensors.visible = state.showsSensors;
    this.surroundings.cropBox.visible = state.showsCropBox;
    this.requestDrawing();
  }

  setColours(colours: SceneColours): void {
    this.colours = colours;
    this.scene.background = new THREE.Color(colours.background);
    const noise = new THREE.Color(colours.noise);
    this.uniforms.noiseColour.value.set(noise.r, noise.g, noise.b);
    this.marks.setColours(colours);
    this.surroundings.setAxes(1, colours);
    this.setGrid();
    this.setSensors(this.poses);
  }

  setSensors(poses: SensorPose[]): void {
    this.poses = poses;
    if (this.colours) this.surroundings.setSensors(poses, this.up, this.colours, this.isNarrow);
    this.requestDrawing();
  }

  setCropBox(box: Bounds | null): void {
    if (this.colours) this.surroundings.setCropBox(box, this.colours);
  }

  /** A box around all voxels that are drawn. */
  private allBounds(): Bounds | null {
    const box = new THREE.Box3();
    for (const { layer } of this.layersOfStreams()) if (layer.group.visible) box.union(layer.box);
    return box.isEmpty() ? null : { min: box.min.toArray(), max: box.max.toArray() };
  }

  /** Measures what is drawn, for heights, grid and camera. False if nothing is drawn. */
  measure(threshold: number): boolean {
    const bounds = boundsOf(this.layers, threshold);
    if (!bounds) return false;
    this.bounds = bounds;
    this.setHeights();
    this.setGrid();
    return true;
  }

  private get isNarrow(): boolean {
    return this.canvas.clientWidth < 600;
  }

  private setGrid(): void {
    if (this.bounds && this.colours)
      this.surroundings.setGrid(this.bounds, this.largestEdge(), this.up, this.colours, this.isNarrow);
  }

  private largestEdge(): number {
    return this.layers.reduce((largest, layer) => Math.max(largest, layer.group.visible ? layer.edge : 0), 0);
  }

  /** A box of some voxels at least, as the camera cannot be fitted to the centre of a single one. */
  private boundsOfCubes({ min, max }: Bounds): Bounds {
    const edge = this.largestEdge();
    const margins = min.map((low, axis) => Math.max(edge / 2, (5 * edge - (max[axis] - low)) / 2));
    return {
      min: [min[0] - margins[0], min[1] - margins[1], min[2] - margins[2]],
      max: [max[0] + margins[0], max[1] + margins[1], max[2] + margins[2]],
    };
  }

  /** Places the camera so that what was measured is in view. */
  fit(direction: ViewDirection | "keep"): void {
    if (!this.bounds) return;
    const { clientWidth, clientHeight } = this.canvas;
    const view = { width: clientWidth || 1, height: clientHeight || 1, covered: this.isNarrow ? 46 : 26 };
    const box = this.surroundings.withSensors(this.boundsOfCubes(this.bounds));
    this.camera.fit(direction, box, this.surroundings.labels(), view);
  }

  /** For another source the camera is placed anew, as soon as there are voxels. */
  forgetView(): void {
    this.camera.forget();
    this.bounds = null;
  }

  /** Fits the voxels into the view, unless the user has chosen one. */
  fitUnlessPlaced(): void {
    if (!this.camera.isPlacedByUser) this.fit("oblique");
  }

  pickAt(clientX: number, clientY: number, scale: number): PickedVoxel | null {
    const { origin, direction } = this.camera.rayThrough(clientX, clientY);
    const ofPixel = (2 * Math.tan((fieldOfView * Math.PI) / 360)) / this.canvas.clientHeight;
    return pick(this.layers, origin, direction, scale, leastPickedPixels * ofPixel / 2, this.rule());
  }

  /** The rule by which voxels are drawn now. */
  rule(): DrawingRule {
    const { threshold, hidesNoise } = this.uniforms;
    return { threshold: threshold.value, hidesNoise: hidesNoise.value, up: this.up, ...this.cut };
  }

  /** Marks voxels, and the distance between two of them. */
  mark(voxels: readonly MarkedVoxel[], text: string): void {
    this.marks.show(voxels, text);
    this.requestDrawing();
  }

  /** The picture as it is on the screen. */
  picture(): Promise<Blob | null> {
    this.draw();
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }
}
