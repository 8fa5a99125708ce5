// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "decoded_cloud.h"
#include "outlier_filter.h"
#include "voxels/point_voxels.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ext::python {

/** \brief Decodes the frames of one stream.
 *
 * Any thread may call it, and not with the GIL held, as a call may wait for another
 * thread.
 */
class ArrayDecoder {
public:
  explicit ArrayDecoder(const io::DecoderLimits& limits) : decoder_(limits)
  {
    decoder_.setDecodesVoxels(false);
  }

  /** \brief Decodes the first frame in memory.
   * \param[in] bytes must not change meanwhile
   * \param[in] size number of bytes
   * \param[in] denoising what to remove
   * \param[out] cloud the points; none unless the status is Ok
   */
  io::CompressionStatus
  decode(const std::uint8_t* bytes,
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

  /** \brief What a frame changed, as clouds. */
  struct Changes {
    DecodedCloud gone;
    DecodedCloud came;
    bool is_from_nothing;
  };

  /** \brief Decodes the first frame in memory to what it changed.
   * \param[in] bytes must not change meanwhile
   * \param[in] size number of bytes
   * \param[out] changes none unless the status is Ok
   */
  io::CompressionStatus
  decodeChanges(const std::uint8_t* bytes,
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

  /** \brief Log-odds of the points of a cloud. */
  struct Scores {
    std::vector<float> log_odds; ///< NaN where there is no point, or no voxel for it
    std::size_t rows = 1;
    std::size_t columns = 0;
  };

  /** \brief Scores of the last frame, for which the filter's history is used and
   * continued; empty if there is none.
   * \throws std::bad_alloc
   */
  Scores
  score(OutlierFilter& outliers)
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

  std::optional<io::FrameStamp>
  stamp() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return decoder_.stamp();
  }

  io::CodedFrameStatistics
  statistics() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return decoder_.statistics();
  }

private:
  /** \brief Makes voxels of a frame that has its points only, which stay where they are
   * in the cloud that was returned. */
  void
  makeVoxels()
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

  mutable std::mutex mutex_;
  io::FrameDecoder decoder_;
  // Members so that their memory is reused.
  io::VoxelFrame frame_;
  io::VoxelChanges changes_;
  bool is_of_changes_ = false; // the last frame, which frame_ then lacks
};

} // namespace pcl_ext::python
