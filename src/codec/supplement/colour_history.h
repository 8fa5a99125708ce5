// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "voxels/ascending_keys.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief A colour with a fraction: red, green and blue in sixteenths. */
using FineColour = std::array<std::uint16_t, 3>;

/** \brief What encoder and decoder remember of the colours since the last I-frame: a
 * running mean for each voxel of the last frames (doc/bitstream_supplement.md,
 * "Colours"). */
class ColourHistory {
public:
  /** \brief The past of one voxel. */
  struct Record {
    FineColour mean{};
    std::uint16_t absent = 0; ///< frames since the last one that had the voxel
  };

  const std::vector<std::uint64_t>&
  keys() const
  {
    return keys_;
  }

  const std::vector<Record>&
  records() const
  {
    return records_;
  }

  /** \brief Removes all records, as at an I-frame. */
  void
  clear() noexcept
  {
    keys_.clear();
    records_.clear();
  }

  /** \brief Makes the next state; learn() replaces the current one by it.
   * \param[in] frame with a colour for each voxel
   * \param[in] is_i_frame without what was before
   */
  void
  prepare(const VoxelFrame& frame, bool is_i_frame);

  /** \brief Replaces the state by the one that was prepared. */
  void
  learn() noexcept
  {
    keys_.swap(next_keys_);
    records_.swap(next_records_);
  }

  /** \brief Releases the memory that is not needed. */
  void
  releaseMemory()
  {
    next_keys_ = std::vector<std::uint64_t>();
    next_records_ = std::vector<Record>();
  }

private:
  std::vector<std::uint64_t> keys_; // ascending
  std::vector<Record> records_;
  std::vector<std::uint64_t> next_keys_;
  std::vector<Record> next_records_;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
