// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "outliers/density_blocks.h"
#include "simd/bit_operations.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief What coarse voxels had in previous frames, ranked among those of a frame, for
 * the unit Voxels. */
class HistoryRanks {
public:
  /** \brief Ranks the coarse voxels of a frame.
   * \param[in] blocks to which they have been added
   * \param[in] frame_blocks indices of the blocks that have some
   * \param[in] masks of each block, occupied cells
   * \param[in] count of all of them
   */
  void
  assign(const DensityBlocks& blocks,
         const std::vector<std::uint32_t>& frame_blocks,
         const std::vector<std::uint64_t>& masks,
         std::uint32_t count)
  {
    std::array<std::uint32_t, steps> numbers{};
    for (const std::uint32_t block : frame_blocks)
      for (std::uint64_t mask = masks[block]; mask != 0; mask &= mask - 1)
        ++numbers[stepOf(blocks, block, lowestBit(mask))];
    std::uint32_t up_to_here = 0;
    for (std::size_t i = 0; i < steps; ++i) {
      up_to_here += numbers[i];
      const float rank = static_cast<float>(up_to_here) / static_cast<float>(count);
      factors_[i] = rank * rank * std::sqrt(rank);
    }
  }

  /** \brief Factor of the evidence of a coarse voxel. */
  float
  factor(const DensityBlocks& blocks, std::uint32_t block, unsigned int cell) const
  {
    return factors_[stepOf(blocks, block, cell)];
  }

private:
  static constexpr std::size_t steps = 256;

  static std::size_t
  stepOf(const DensityBlocks& blocks, std::uint32_t block, unsigned int cell)
  {
    // What add() has added is the same for all.
    constexpr int added = DensityBlocks::mean_step * 255;
    return static_cast<std::size_t>(blocks.mean(block, cell) - added) / 64;
  }

  std::array<float, steps> factors_{}; // by step
};

} // namespace pcl_ext::PCL_EXT_ABI
