// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "array_decoder.h"

#include <pcl_ext/compression/cloud_encoder.h>

#include "voxels/point_voxels.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <utility>

namespace pcl_ext::python {

io::CompressionStatus
ArrayDecoder::decode(const std::uint8_t* bytes,
                     std::size_t size,
                     const Denoising& denoising,
                     std::optional<DecodedCloud>& cloud)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  cloud.reset();
  is_of_changes_ = false;
  io::CompressionStatus status = decoder_.decode(bytes, size, frame_);
  if (!status.ok())
    return status;
  try {
    std::optional<std::chrono::nanoseconds> time;
    if (decoder_.stamp() && decoder_.stamp()->stamp != 0)
      time = io::timeOfStamp(decoder_.stamp()->stamp);
    denoising.apply(frame_, time);
    cloud.emplace(frame_);
    status = io::statusOfVoxels(frame_); // which filters make
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<io::CompressionStatus>();
  }
  return status;
}

io::CompressionStatus
ArrayDecoder::decodeChanges(const std::uint8_t* bytes,
                            std::size_t size,
                            std::optional<Changes>& changes)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  changes.reset();
  frame_.clearVoxels();
  io::CompressionStatus status = decoder_.decode(bytes, size, changes_);
  is_of_changes_ = status.ok();
  if (!status.ok())
    return status;
  try {
    changes.emplace(Changes{DecodedCloud(changes_.gone),
                            DecodedCloud(changes_.came),
                            changes_.is_from_nothing});
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<io::CompressionStatus>();
  }
  return status;
}

ArrayDecoder::Scores
ArrayDecoder::score(OutlierFilter& outliers)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (is_of_changes_)
    decoder_.latestVoxels(frame_);
  makeVoxels();
  const std::vector<float> log_odds = outliers.score(frame_);
  if (!frame_.has_point_counts || log_odds.size() != frame_.size())
    return {log_odds, 1, log_odds.size()};
  Scores scores{
      std::vector<float>(frame_.cloudSize(), std::numeric_limits<float>::quiet_NaN()),
      frame_.cloudHeight(),
      frame_.cloudWidth()};
  std::size_t point = 0;
  for (std::size_t voxel = 0; voxel < frame_.size(); ++voxel)
    for (std::uint32_t i = 0; i < frame_.point_counts[voxel]; ++i)
      scores.log_odds[frame_.cloudIndex(point++)] = log_odds[voxel];
  return scores;
}

void
ArrayDecoder::makeVoxels()
{
  if (!frame_.points.areThere() || !frame_.keys.empty())
    return;
  // Points outside the grid have no voxel, and a single row would close their gaps.
  const std::uint32_t width = frame_.points.width;
  io::FrameField places;
  places.numbers.assign(frame_.points.indices.begin(), frame_.points.indices.end());
  frame_.fields.push_back(std::move(places));
  io::setVoxels(frame_);
  frame_.points.width = width;
  for (std::size_t i = 0; i < frame_.points.indices.size(); ++i)
    frame_.points.indices[i] =
        static_cast<std::uint32_t>(frame_.fields.back().numbers[i]);
  frame_.fields.pop_back();
}

std::optional<io::FrameStamp>
ArrayDecoder::stamp() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return decoder_.stamp();
}

io::CodedFrameStatistics
ArrayDecoder::statistics() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return decoder_.statistics();
}

} // namespace pcl_ext::python
