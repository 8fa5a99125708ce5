// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/density_blocks.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Constants of the score of a unit. */
struct Score {
  float least_shell; ///< e of VoxelOutlierRemoval
  float offset;      ///< c
  float weight;      ///< of the evidence's logarithm
};

/** \brief The constants for an edge of the coarse voxels, metres. */
inline Score
scoreOf(DensityUnit unit, double edge)
{
  // Faces: the maximum likelihood on sensor 2 of the robot cell with seed 2 at 4 cm;
  // the maximum differs by up to 0.2 at 2 to 6 cm, and by 0.6 at 8 cm. Points: 0.4 to 1
  // below that maximum; the maxima of the six sensors at 4 cm differ from this value by
  // -0.3 to 0.8. Above 4 cm the maximum for Points would remove 1 of 10 voxels of the
  // surfaces at 8 cm and 1 of 3 at 20 cm, as counts of coarse voxels vary more than
  // their local mean. Voxels: within 0.15 of the maxima of the lidar with seed 2 at 2,
  // 4, 10 and 20 cm.
  const auto log_edge = static_cast<float>(std::log(edge / 0.04));
  if (unit == DensityUnit::Faces)
    return {0.02f, 2.4f + 3.0f * log_edge, 0.5f};
  if (unit == DensityUnit::Points)
    return {0.02f, -2.5f - 3.0f * std::min(log_edge, 0.0f), 0.5f};
  // Rays: by gradient descent on half of a snowy drive of SnowyKITTI, at 10 cm.
  if (unit == DensityUnit::Rays)
    return {0.0f, 2.0f, 3.2f};
  return {0.3f, 2.9f - 0.75f * log_edge, 0.5f};
}

/** \brief exp((log-odds - c) / weight) without the history, which is compared without
 * computing logarithms. Not for Rays: see RayHits. */
inline float
evidenceOf(const NeighbourhoodSums& sums, float unit, float least_shell)
{
  const float least = least_shell * unit;
  const auto shell = [&](std::int32_t sum) {
    return (static_cast<float>(sum) + least) / unit;
  };
  const float core = shell(sums.core);
  const float core_squared = core * core;
  return core_squared * core_squared * core_squared * shell(sums.ring) *
         shell(sums.rim);
}

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
