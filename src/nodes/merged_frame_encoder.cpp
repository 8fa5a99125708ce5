// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_frame_encoder.h"

#include <algorithm>
#include <chrono>

namespace pcl_ext {
namespace nodes {

namespace {

io::EncoderSettings
encoderSettings(double resolution, const io::StreamSettings& stream)
{
  io::EncoderSettings settings;
  settings.resolution = resolution;
  settings.effort = stream.effort;
  settings.i_frame_rate = stream.i_frame_rate;
  settings.aggregation = io::Aggregation::Sum;
  constexpr unsigned int all_bits = 8;
  settings.colour_bits = all_bits;
  return settings;
}

} // namespace

MergedFrameEncoder::MergedFrameEncoder(double resolution,
                                       const io::StreamSettings& stream)
: encoder_(encoderSettings(resolution, stream), IntensityUnit::Native)
{}

io::CompressionStatus
MergedFrameEncoder::encode(const io::VoxelFrame& merged,
                           Time stamp,
                           const std::string& frame_id,
                           std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  coordinates_.clear();
  intensities_.clear();
  colours_.clear();
  io::forEachPreciseCentre(merged, [&](auto x, auto y, auto z, float intensity) {
    for (const auto coordinate : {x, y, z})
      coordinates_.push_back(static_cast<double>(coordinate));
    intensities_.push_back(intensity);
  });
  if (merged.colour_bits > 0)
    for (std::size_t i = 0; i < merged.size(); ++i) {
      const io::VoxelColour colour = merged.fullColour(i);
      constexpr unsigned int red = 16;
      constexpr unsigned int green = 8;
      colours_.push_back((std::uint32_t{colour.r} << red) |
                         (std::uint32_t{colour.g} << green) | colour.b);
    }
  io::PointView points;
  points.count = intensities_.size();
  points.double_coordinates = coordinates_.data();
  points.coordinate_stride = 3 * sizeof(double);
  points.intensities = intensities_.data();
  points.intensity_stride = sizeof(float);
  if (merged.colour_bits > 0) {
    points.colours = colours_.data();
    points.colour_stride = sizeof(std::uint32_t);
  }
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(stamp).count();
  io::CloudInfo info;
  info.stamp = io::FrameStamp{
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, microseconds)), frame_id};
  return encoder_.encode(points, info, bytes);
}

} // namespace nodes
} // namespace pcl_ext
