// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

/** \brief Mean of some colours. */
class ColourMean {
public:
  /** \param[in] colour channels of 0 to 255 */
  void
  add(const VoxelColour& colour)
  {
    ++count_;
    r_ += colour.r;
    g_ += colour.g;
    b_ += colour.b;
  }

  /** \brief The mean, rounded; nothing without a colour. */
  std::optional<VoxelColour>
  mean() const
  {
    if (count_ == 0)
      return std::nullopt;
    const auto rounded = [this](std::uint64_t sum) {
      return static_cast<std::uint8_t>((2 * sum + count_) / (2 * count_));
    };
    return VoxelColour{rounded(r_), rounded(g_), rounded(b_)};
  }

  bool
  operator==(const ColourMean& other) const
  {
    return count_ == other.count_ && r_ == other.r_ && g_ == other.g_ && b_ == other.b_;
  }

private:
  std::uint64_t count_ = 0;
  std::uint64_t r_ = 0; // sums
  std::uint64_t g_ = 0;
  std::uint64_t b_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::detail
