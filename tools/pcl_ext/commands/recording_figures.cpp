// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/recording_figures.h"

#include "console/interruption.h"

namespace pcl_ext {
namespace tools {

namespace {

using io::FrameDescription;
using recording::RecordedFrame;

void
addFrame(const RecordedFrame& frame, StreamFigures& figures)
{
  const FrameDescription& header = frame.description;
  figures.missing += figures.losses.missingBefore(header);
  if (!header.status.ok()) {
    ++figures.unreadable;
    return;
  }
  figures.bytes += frame.bytes.size();
  if (figures.frame_id.empty())
    figures.frame_id = frame.frame_id;
  figures.i_frames += header.is_i_frame ? 1 : 0;
  if (header.has_points) {
    ++figures.frames_in_order;
    figures.points_in_order += header.points;
  }
  else if (header.format == io::StreamFormat::Version1 || header.is_i_frame) {
    ++figures.frames_with_voxels;
    figures.voxels += header.voxels;
  }
  if (!header.is_i_frame)
    return;
  const double resolution = header.grid.resolution;
  if (!figures.hasIFrame()) {
    figures.resolution = resolution;
    figures.format = header.format;
    figures.effort = header.effort;
    figures.intensity_bits = header.intensity_scale.bits;
    figures.colour_bits = header.colour_bits;
    figures.has_point_counts = header.has_point_counts;
    figures.fields = header.fields;
    figures.scan = header.scan;
    figures.is_organised = header.is_organised;
    figures.is_row_by_row = header.is_row_by_row;
  }
  figures.has_one_resolution &= figures.resolution == resolution;
}

} // namespace

std::vector<StreamFigures>
figuresOf(RecordingInput& input, Console& console)
{
  std::vector<StreamFigures> figures;
  const std::vector<recording::RecordedStream>& streams = input.reader().streams();
  for (std::size_t i = 0; i < streams.size(); ++i) {
    figures.emplace_back();
    figures.back().name = input.nameOf(i);
    figures.back().has_times = streams[i].has_times;
  }
  console.startProgress("frames", input.size());
  RecordingInput::Item item;
  RecordedFrame frame;
  while (!isInterrupted() && input.next(item)) {
    console.advance();
    if (!item.is_frame)
      continue;
    StreamFigures& stream = figures[item.stream];
    if (stream.frames++ == 0)
      stream.first_time = item.time;
    stream.last_time = item.time;
    static_cast<void>(input.read(item, frame)); // its description tells if that failed
    addFrame(frame, stream);
  }
  console.endProgress();
  return figures;
}

} // namespace tools
} // namespace pcl_ext
