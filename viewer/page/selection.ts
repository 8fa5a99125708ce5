// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { formatCount, formatMetres, formatNumber, formatValue } from "./controls/number_format";
import type { VoxelDetails } from "./controls/voxel_details";
import { isOutlier } from "./decoding/packed_voxels";
import { isNoise } from "./scene/drawn_voxels";
import type { MarkedVoxel } from "./scene/selection_marks";
import type { ViewerScene } from "./scene/viewer_scene";
import { fieldOf } from "./state/viewer_state";
import type { ViewerStore } from "./state/viewer_state";
import { shortName } from "./stream_names";
import type { StreamView } from "./stream_views";

type Row = [string, string];

/** A voxel that was picked; its index is that in the present frame of its stream, null if it is not in it. */
interface PickedVoxel extends MarkedVoxel {
  stream: number;
  voxel: number | null;
}

function distanceBetween(a: PickedVoxel, b: PickedVoxel): number {
  return Math.hypot(...a.place.map((value, axis) => b.place[axis] - value));
}

/** The voxel that was picked last, with what is known of it, and the one before, from which the distance is told. */
export class Selection {
  private picked: PickedVoxel[] = []; // one or two
  private isMeasuring = false; // the next click tells a distance
  private pressed: { x: number; y: number } | null = null;

  constructor(
    private readonly store: ViewerStore,
    private readonly scene: ViewerScene,
    private readonly streams: readonly StreamView[],
    private readonly details: VoxelDetails,
  ) {
    const { canvas } = scene;
    canvas.addEventListener("pointerdown", (event) => (this.pressed = { x: event.clientX, y: event.clientY }));
    canvas.addEventListener("click", (event) => {
      const moved = this.pressed ? Math.hypot(event.clientX - this.pressed.x, event.clientY - this.pressed.y) : 0;
      if (moved < 5) this.pick(event.clientX, event.clientY, event.shiftKey || this.isMeasuring);
    });
  }

  clear(): void {
    this.picked = [];
    this.isMeasuring = false;
    this.show();
  }

  /** The next click tells the distance from the voxel that was picked last. */
  toggleMeasuring(): void {
    this.isMeasuring = !this.isMeasuring;
    this.show();
  }

  private pick(clientX: number, clientY: number, measures: boolean): void {
    const found = this.scene.pickAt(clientX, clientY, this.store.get().voxelScale);
    if (!found && measures) return; // the first voxel stays, for another try
    const layer = found ? this.scene.layers[found.layer] : null;
    const voxel = found && layer ? {
      stream: found.layer, voxel: found.voxel, place: layer.placeOf(found.voxel), edge: layer.edge,
      rotation: layer.group.quaternion.clone(),
    } : null;
    this.picked = voxel ? [...(measures ? this.picked.slice(-1) : []), voxel] : [];
    this.isMeasuring = false;
    this.show();
  }

  /** Finds the voxels in frames that are new. */
  follow(): void {
    if (this.picked.length === 0) return;
    for (const one of this.picked) {
      const layer = this.scene.layers[one.stream];
      const count = (layer?.arrays?.positions.length ?? 0) / 3;
      one.voxel = null;
      for (let i = 0; i < count && one.voxel === null; ++i) {
        const there = layer.placeOf(i);
        if (one.place.every((value, axis) => Math.abs(there[axis] - value) < 0.1 * layer.edge)) one.voxel = i;
      }
    }
    this.show();
  }

  private show(): void {
    const [first, second] = this.picked;
    const last = second ?? first;
    const distance = second ? distanceBetween(first, second) : null;
    this.scene.mark(this.picked, distance === null ? "" : formatMetres([distance], last.edge));
    if (!last) {
      this.details.show(null);
      return;
    }
    const rows = this.rowsOf(last);
    if (distance !== null) {
      const steps = first.place.map((value, axis) => last.place[axis] - value);
      rows.push(["From", formatMetres(first.place, first.edge)], ["Distance", formatMetres([distance], last.edge)],
        ["Along x, y, z", formatMetres(steps, last.edge)]);
    }
    this.details.show(rows, this.isMeasuring);
  }

  private rowsOf({ stream, voxel, place, edge }: PickedVoxel): Row[] {
    const { description } = this.streams[stream];
    const rows: Row[] = [["Position", formatMetres(place, edge)], ["Stream", shortName(description.name)]];
    const layer = this.scene.layers[stream];
    if (voxel === null || !layer.arrays) return [...rows, ["Voxel", "not in this frame"]];
    const { arrays, voxels } = layer;
    if (voxels?.hasIntensities) rows.push(["Intensity", formatNumber(arrays.intensities[voxel])]);
    if (arrays.field && voxels?.field === fieldOf(this.store.get().colourBy))
      rows.push([`Field ${voxels?.field}`, formatValue(arrays.field[voxel])]);
    const isCounted = description.metadata.intensity_law === "count";
    if (voxels?.hasPointCounts) rows.push(["Points", formatCount(arrays.pointCounts[voxel])]);
    else if (isCounted) rows.push(["Points", formatNumber(arrays.intensities[voxel])]);
    if (arrays.ages[voxel] > 0) rows.push(["Seen", `${arrays.ages[voxel].toFixed(2)} s ago`]);
    if (isOutlier(arrays, voxel)) rows.push(["Noise", "by the outlier filter"]);
    else if (isNoise(layer, voxel, this.store.get().threshold)) rows.push(["Noise", "below the threshold"]);
    return rows;
  }
}
