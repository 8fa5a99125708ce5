// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import type { FrameIndex } from "./frame_index";

/** The part of time that is drawn, seconds. */
export interface TimeSpan {
  from: number;
  to: number;
}

export interface PlotColours {
  bytes: string;
  voxels: string;
  iFrame: string;
  lost: string;
}

interface Column {
  bytes: number;
  voxels: number;
  frames: number;
  isIFrame: boolean;
  isLost: boolean;
}

/** Largest values of a plot, for its labels. */
export interface PlotScale {
  bytesPerSecond: number;
  voxels: number;
}

const marksHeight = 9; // pixels for I-frames and losses

/** What happens in each of some pixels' time. */
function columnsOf(index: FrameIndex, span: TimeSpan, count: number): Column[] {
  const columns = Array.from({ length: count }, () => ({
    bytes: 0, voxels: 0, frames: 0, isIFrame: false, isLost: false,
  }));
  const length = Math.max(span.to - span.from, 1e-9);
  for (const frames of index.streams) {
    for (let i = 0; i < frames.times.length; ++i) {
      const at = Math.round(((frames.times[i] - span.from) / length) * (count - 1));
      if (at < 0 || at >= count) continue;
      const column = columns[at];
      column.bytes += frames.bytes[i];
      column.voxels += frames.voxels[i];
      ++column.frames;
      column.isIFrame ||= frames.isIFrame[i];
      column.isLost ||= frames.isLost[i];
    }
  }
  return columns;
}

function largest(values: number[]): number {
  return values.reduce((a, b) => Math.max(a, b), 0);
}

/** Draws bytes a second as an area, voxels as a line, I-frames as ticks and losses in red. */
export function drawPlot(
  context: CanvasRenderingContext2D,
  width: number,
  height: number,
  index: FrameIndex,
  span: TimeSpan,
  colours: PlotColours,
): PlotScale {
  context.clearRect(0, 0, width, height);
  const interval = index.interval();
  const length = Math.max(span.to - span.from, interval);
  // Columns are not narrower than a frame's time, or most of them would be empty.
  const count = Math.max(2, Math.min(Math.floor(width / 2), Math.round(length / interval) + 1));
  const columns = columnsOf(index, span, count);
  // All that is known of a single frame's time is that it lasts.
  if (span.to <= span.from) columns.fill(columns[0]);
  const secondsOfColumn = count > 1 ? length / (count - 1) : length;
  const rates = columns.map((column) => column.bytes / secondsOfColumn);
  const streams = Math.max(1, index.streams.length);
  const voxels = columns.map((column) => (column.frames ? (column.voxels / column.frames) * streams : 0));
  const scale = { bytesPerSecond: largest(rates), voxels: largest(voxels) };
  const plotHeight = height - marksHeight - 3;
  const x = (i: number): number => (i / (count - 1)) * width;
  const y = (share: number): number => 2 + plotHeight * (1 - share);

  context.beginPath();
  context.moveTo(0, y(0));
  rates.forEach((rate, i) => context.lineTo(x(i), y((0.92 * rate) / (scale.bytesPerSecond || 1))));
  context.lineTo(width, y(0));
  context.closePath();
  context.fillStyle = colours.bytes;
  context.fill();

  context.beginPath();
  let isDrawing = false;
  voxels.forEach((value, i) => {
    if (value === 0) return;
    const at = y((0.92 * value) / (scale.voxels || 1));
    if (isDrawing) context.lineTo(x(i), at);
    else context.moveTo(x(i), at);
    isDrawing = true;
  });
  context.strokeStyle = colours.voxels;
  context.lineWidth = 1.5;
  context.stroke();

  columns.forEach((column, i) => {
    const wide = Math.max(2, width / (count - 1));
    if (column.isLost) {
      context.fillStyle = colours.lost;
      context.fillRect(x(i) - wide / 2, height - marksHeight, wide, marksHeight);
    }
    if (column.isIFrame && (i === 0 || span.to > span.from)) {
      context.fillStyle = colours.iFrame;
      context.fillRect(Math.min(width - 2, Math.max(0, x(i) - 1)), height - marksHeight, 2, marksHeight);
    }
  });
  return scale;
}
