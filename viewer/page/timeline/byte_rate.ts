// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { formatBytes, formatBytesPerSecond } from "../controls/number_format";
import { lastNotAbove } from "./frame_index";
import type { FrameIndex } from "./frame_index";

const seconds = 1;

/** A rate in words; a single frame has none, but a size. */
export function rateText(index: FrameIndex, bytesPerSecond: number): string {
  if (index.moments.length > 1) return formatBytesPerSecond(bytesPerSecond);
  return formatBytes(bytesPerSecond * index.interval());
}

/** Bytes a second of all streams around a moment of a recording. */
export function bytesPerSecondAt(index: FrameIndex, moment: number): number {
  const first = index.moments[0] ?? 0;
  const last = index.duration + index.interval();
  const centre = index.moments[moment] ?? 0;
  const from = Math.max(first, Math.min(centre - seconds / 2, last - seconds));
  const to = Math.min(last, from + seconds);
  let bytes = 0;
  for (const frames of index.streams) {
    const end = lastNotAbove(frames.times, to - 1e-9);
    for (let i = lastNotAbove(frames.times, from - 1e-9) + 1; i <= end; ++i) bytes += frames.bytes[i];
  }
  return to > from ? bytes / (to - from) : 0;
}
