// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/recording_figures.h"

#include "console/interruption.h"

#include <algorithm>

namespace pcl_ext::tools {

namespace {

using io::FrameDescription;
using recording::RecordedFrame;

/** \brief Adds what an I-frame has. */
void
addContent(const FrameDescription& header, StreamFigures& figures)
{
  // One of a cloud without points has what its encoder would have without a scan.
  const bool has_points = header.points > 0 || header.voxels > 0;
  if (!has_points && figures.has_points)
    return;
  if (has_points && !figures.has_points) {
    figures.has_points = true;
    figures.intensity_bits = 0;
    figures.colour_bits = 0;
    figures.has_point_counts = false;
    figures.fields.clear();
  }
  if (header.has_points && figures.orders.empty()) {
    figures.scan = header.scan;
    figures.is_organised = header.is_organised;
    figures.is_row_by_row = header.is_row_by_row;
  }
  if (has_points)
    figures.orders.add(header);
  figures.intensity_bits =
      std::max(figures.intensity_bits, header.intensity_scale.bits);
  figures.colour_bits = std::max(figures.colour_bits, header.colour_bits);
  figures.has_point_counts |= header.has_point_counts;
  for (const io::FieldDescription& field : header.fields)
    if (std::none_of(figures.fields.begin(),
                     figures.fields.end(),
                     [&field](const auto& other) { return other.name == field.name; }))
      figures.fields.push_back(field);
}

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
  }
  figures.has_one_resolution &= figures.resolution == resolution;
  addContent(header, figures);
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

} // namespace pcl_ext::tools
