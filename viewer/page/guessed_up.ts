// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { identity } from "./recordings/transforms";
import { numbersOf } from "./scene/surroundings";
import { isCameraView } from "./scene/up_axis";
import type { UpAxis } from "./scene/up_axis";
import type { VoxelLayer } from "./scene/voxel_layer";
import type { StreamView } from "./stream_views";

/** An up axis, and how it was found, as in “z, from the transforms”. */
export interface GuessedUp {
  up: UpAxis;
  reason: string;
}

const mostPlaces = 20_000;

/** Some places of all voxels, evenly taken. */
function somePlaces(layers: readonly VoxelLayer[]): [number, number, number][] {
  const total = layers.reduce((sum, { voxels }) => sum + (voxels?.count ?? 0), 0);
  const step = Math.max(1, Math.floor(total / mostPlaces));
  return layers.flatMap((layer) => {
    const count = Math.ceil((layer.voxels?.count ?? 0) / step);
    return Array.from({ length: count }, (_, i) => layer.placeOf(i * step));
  });
}

/** Which axis points up: by names and places of coordinates as REP 103 of ROS has them, else by the clouds. */
export function guessUp(streams: readonly StreamView[], layers: readonly VoxelLayer[]): GuessedUp {
  const frames = streams.flatMap(({ shown }) => (shown?.frameId ? [shown] : []));
  const moved = frames.find(({ frameId, placement }) => placement && placement.root !== frameId?.replace(/^\//, ""));
  const frame = moved?.placement?.root ?? frames[0]?.frameId ?? "";
  if (/optical(_frame)?$/.test(frame)) return { up: "-y", reason: `as ${frame} is a camera's` };
  if (moved) return { up: "z", reason: "from the transforms" };
  const hasPose = streams.some(({ description }) => {
    const pose = numbersOf(description.metadata.sensor_pose, 7);
    return pose?.some((value, i) => value !== identity[i]);
  });
  if (hasPose) return { up: "z", reason: "from the sensors' poses" };
  return { up: isCameraView(somePlaces(layers)) ? "-y" : "z", reason: "guessed from the cloud" };
}
