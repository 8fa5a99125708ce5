// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "decoded_cloud.h"
#include "outlier_filter.h"

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
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
         std::optional<DecodedCloud>& cloud);

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
                std::optional<Changes>& changes);

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
  score(OutlierFilter& outliers);

  std::optional<io::FrameStamp>
  stamp() const;

  io::CodedFrameStatistics
  statistics() const;

private:
  /** \brief Makes voxels of a frame that has its points only, which stay where they are
   * in the cloud that was returned. */
  void
  makeVoxels();

  mutable std::mutex mutex_;
  io::FrameDecoder decoder_;
  // Members so that their memory is reused.
  io::VoxelFrame frame_;
  io::VoxelChanges changes_;
  bool is_of_changes_ = false; // the last frame, which frame_ then lacks
};

} // namespace pcl_ext::python
