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

  /** \brief Counts a voxel that is shown by the last frame, for what is usual.
   * \param[in] is_hit whether the frame has it */
  void
  countShown(std::uint64_t key, const TrackedVoxel& voxel, bool is_hit)
  {
    if (shown_number_++ % HitShares::sample_step == 0)
      hit_shares_.add(distanceOf(key), voxel.empty_ticks > 0, is_hit);
  }

  /** \brief Of the cells of a block that the frame has and that are not shown, those next
   * to what is shown.
   * \param[in] tracked as in beginVoxels(), or nothing since forgetVoxels()
   * \param[in] shown cells of the block */
  std::uint64_t
  nextToShown(const TrackedVoxels& tracked,
              std::uint64_t block,
              std::uint64_t shown,
              std::uint64_t cells) const
  {
    return cells == 0 ? 0 : around_.nextTo(tracked.shown, shown, block, cells);
  }

  /** \brief Of the shown cells of a block that the frame has not, those next to what it
   * has.
   * \param[in] hits cells of the block that it has */
  std::uint64_t
  nextToHits(std::uint64_t block, std::uint64_t hits, std::uint64_t cells) const
  {
    return cells == 0 ? 0 : surfaces_.occupied(0).nextTo(hits, block, cells);
  }

  /** \brief Takes a voxel that the frame has.
   * \param[in] tracked as above
   * \param[in] is_next_to_shown whether it is not shown, and something next to it is */
  void
  countHit(const TrackedVoxels& tracked,
           std::uint64_t key,
           bool is_next_to_shown,
           TrackedVoxel& voxel) const
  {
    voxel.empty_ticks = 0;
    voxel.occupancy = static_cast<std::uint16_t>(
        voxel.occupancy + (((certain - voxel.occupancy) * rate_) >> 16));
    if (!voxel.is_shown)
      judgeHidden(tracked, key, is_next_to_shown, voxel);
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

  /** \brief Takes a voxel that is not shown and that the frame has not. */
  void
  countMiss(TrackedVoxel& voxel) const
  {
    voxel.occupancy =
        static_cast<std::uint16_t>(voxel.occupancy - (voxel.occupancy * rate_ >> 16));
  }

  /** \brief True if a voxel that the frame has not need not be tracked any more. */
  bool
  isForgotten(const TrackedVoxel& voxel) const
  {
    return !voxel.is_shown && voxel.occupancy < least_occupancy_;
  }

  /** \brief Shows nothing; what is usual stays. */
  void
  forgetVoxels();

  /** \brief Releases memory that the next frame does not need. */
  void
  releaseMemory();

  /** \brief That have learned from the frame. */
  const SurfaceSupport&
  surfaces() const
  {
    return surfaces_;
  }

  /** \brief As HitShares::isAnyNoisy(). */
  bool
  isAnyNoisy() const
  {
    return hit_shares_.isAnyNoisy();
  }

  /** \brief As HitShares::returnsRarely(). */
  bool
  returnsRarely() const
  {
    return hit_shares_.returnsRarely();
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
  std::size_t shown_number_ = 0; // of those that were counted
};

} // namespace pcl_ext::PCL_EXT_ABI
