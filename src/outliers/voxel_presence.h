// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "outliers/block_neighbours.h"
#include "outliers/direction_depths.h"
#include "outliers/frame_ticks.h"
#include "outliers/hit_shares.h"
#include "outliers/seen_depths.h"
#include "outliers/surface_support.h"
#include "outliers/tracked_voxels.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Decides which tracked voxels are shown (doc/temporal_filter.md, "Rules"). */
class VoxelPresence {
public:
  /** \param[in] frames strength of the filter
   * \param[in] holds whether a voxel may stay where nothing within one voxel is
   * measured */
  VoxelPresence(unsigned int frames, bool holds);

  /** \brief Takes the next frame, before its voxels are counted.
   * \param[in] sensor_position metres, if it is known; finite
   * \param[in] rays that end where the frame has no points, metres; kept until all its
   * voxels are counted
   * \param[in] ticks since the frame before
   */
  void
  beginFrame(const io::VoxelFrame& frame,
             const std::optional<std::array<double, 3>>& sensor_position,
             const DirectionDepths& rays,
             unsigned int ticks);

  /** \brief Takes what is tracked, and begins to count the frame's voxels.
   * \param[in] depth of the grid */
  void
  beginVoxels(const TrackedVoxels& tracked, unsigned int depth);

  /** \brief Counts the voxels of a block that are shown by the last frame, for what is
   * usual.
   * \param[in] hits cells that the frame has
   * \param[in] tracked cells of the block
   * \param[in] voxels of these */
  void
  countShown(std::uint64_t block,
             std::uint64_t shown,
             std::uint64_t hits,
             std::uint64_t tracked,
             const TrackedVoxel* voxels)
  {
    const unsigned int number = bitCount(shown);
    for (; until_sample_ < number; until_sample_ += HitShares::sample_step) {
      std::uint64_t left = shown;
      for (std::size_t i = 0; i < until_sample_; ++i)
        left &= left - 1;
      const std::uint64_t bit = left & (0 - left);
      hit_shares_.add(distanceOf(block << io::block_key_bits | lowestBit(left)),
                      voxels[bitCount(tracked & (bit - 1))].empty_ticks > 0,
                      (hits & bit) != 0);
    }
    until_sample_ -= number;
  }

  /** \brief Of the cells of a block that the frame has and that are not shown, those next
   * to what is shown, and of the shown ones that it has not those next to what it has.
   * \param[in] tracked as in beginVoxels(), or nothing since forgetVoxels()
   * \param[in] shown,hits cells of the block that are shown, and that the frame has */
  std::uint64_t
  nextTo(const TrackedVoxels& tracked,
         std::uint64_t block,
         std::uint64_t shown,
         std::uint64_t hits) const
  {
    const std::uint64_t new_hits = hits & ~shown;
    const std::uint64_t missed = shown & ~hits;
    return (new_hits == 0 ? 0 : around_.nextTo(tracked.shown, shown, block, new_hits)) |
           (missed == 0 ? 0 : surfaces_.occupied(0).nextTo(hits, block, missed));
  }

  /** \brief Takes a voxel that the frame has.
   * \param[in] tracked as above
   * \param[in] is_next_to_shown whether it is not shown, and something next to it is
   * \return whether it becomes shown */
  bool
  countHit(const TrackedVoxels& tracked,
           std::uint64_t key,
           bool is_next_to_shown,
           TrackedVoxel& voxel) const
  {
    voxel.empty_ticks = 0;
    voxel.occupancy = static_cast<std::uint16_t>(
        voxel.occupancy + (((certain - voxel.occupancy) * rate_) >> 16));
    if (voxel.is_shown)
      return false;
    judgeHidden(tracked, key, is_next_to_shown, voxel);
    return voxel.is_shown;
  }

  /** \brief Takes a shown voxel that the frame has not.
   * \param[in] is_next_to_hit whether the frame has one of the 26 around it
   * \param[in] holds whether it may stay where nothing near is measured, in this frame
   * \return whether it has not ended, and nothing near is measured
   */
  bool
  countMiss(std::uint64_t key,
            bool is_next_to_hit,
            bool holds,
            TrackedVoxel& voxel) const;

  /** \brief The occupancy of a voxel that the frame has not and that is not shown, if
   * fades is 1, or as it is. By arithmetic, as branches would be mispredicted. */
  std::uint32_t
  fade(std::uint32_t occupancy, std::uint64_t fades) const
  {
    return occupancy -
           (occupancy * (rate_ & (0 - static_cast<std::uint32_t>(fades))) >> 16);
  }

  /** \brief 1 if a voxel that is neither shown nor hit is not tracked any more, else 0. */
  std::uint32_t
  isForgotten(std::uint32_t occupancy) const
  {
    return (occupancy - least_occupancy_) >> 31;
  }

  /** \brief Shows nothing; what is usual stays. */
  void
  forgetVoxels()
  {
    around_ = BlocksAround();
  }

  /** \brief Releases memory that the next frame does not need. */
  void
  releaseMemory()
  {
    around_ = BlocksAround();
    surfaces_.releaseMemory();
    depths_ = SeenDepths();
  }

  /** \brief That have learned from the frame. */
  const SurfaceSupport&
  surfaces() const
  {
    return surfaces_;
  }

  const HitShares&
  hitShares() const
  {
    return hit_shares_;
  }

  /** \brief For how many frames at most what has nothing near is held. */
  std::size_t
  framesHeld() const;

private:
  static constexpr std::uint32_t certain = 0xffff; // of a voxel that each frame has

  /** \brief When a voxel is shown by its occupancy and hidden. */
  struct Persistence;

  void
  look(const io::VoxelFrame& frame,
       const std::optional<std::array<double, 3>>& sensor_position);

  void
  judgeHidden(const TrackedVoxels& tracked,
              std::uint64_t key,
              bool is_next_to_shown,
              TrackedVoxel& voxel) const;

  bool
  isAmongSeldomVoxels(const TrackedVoxels& tracked, std::uint64_t key) const;

  bool
  hasEnded(const TrackedVoxel& voxel, const Persistence& persistence) const;

  bool
  isOfNoisySurface(std::uint64_t key) const;

  const Persistence&
  persistenceOf(std::uint64_t key) const;

  /** \brief Square of the distance from the sensor, in voxels; 0 without one. */
  std::uint64_t
  distanceOf(std::uint64_t key) const
  {
    return has_depths_ ? depths_.squaredDistance(key) : 0;
  }

  static const Persistence dense;
  static const Persistence sparse;
  static const Persistence noisy;

  unsigned int frames_;
  bool holds_;
  std::uint32_t rate_;            // of the running means, 2^16 is 1
  std::uint32_t least_occupancy_; // below it empty voxels are forgotten
  BlocksAround around_;           // those of what is tracked
  SurfaceSupport surfaces_;
  HitShares hit_shares_;
  SeenDepths depths_;
  const DirectionDepths* rays_ = nullptr; // of the current frame
  bool has_depths_ = false;
  unsigned int ticks_ = FrameTicks::usual; // since the last frame
  std::uint32_t fall_ = 0;       // of an occupancy where there is nothing, 2^16 is 1
  std::size_t until_sample_ = 0; // shown voxels before the next one that is counted
};

} // namespace pcl_ext::PCL_EXT_ABI
