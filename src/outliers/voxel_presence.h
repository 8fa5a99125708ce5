// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "outliers/block_neighbours.h"
#include "outliers/direction_depths.h"
#include "outliers/frame_ticks.h"
#include "outliers/held_value.h"
#include "outliers/hit_shares.h"
#include "outliers/seen_depths.h"
#include "outliers/surface_support.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief A voxel of the last frames. */
struct TrackedVoxel {
  std::uint64_t key;
  std::uint16_t occupancy;  ///< running mean, 2^16 is 1
  std::uint8_t empty_ticks; ///< since the last frame in which it was occupied
  bool is_shown;
  HeldValue intensity;
};

/** \brief Decides which tracked voxels are shown (doc/temporal_filter.md, "Rules"). */
class VoxelPresence {
public:
  /** \param[in] frames strength of the filter
   * \param[in] holds whether a voxel may stay where nothing within one voxel is
   * measured */
  VoxelPresence(unsigned int frames, bool holds);

  /** \brief Takes the next frame, before its voxels are counted.
   * \param[in] sensor_position metres, if it is known; finite
   * \param[in] rays that end where the frame has no points, metres
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
  beginVoxels(const std::vector<TrackedVoxel>& tracked, unsigned int depth);

  /** \brief Counts a voxel that is shown by the last frame, for what is usual.
   * \param[in] is_hit whether the frame has it */
  void
  countShown(const TrackedVoxel& voxel, bool is_hit);

  /** \brief Takes a voxel that the frame has. */
  void
  countHit(TrackedVoxel& voxel) const;

  /** \brief Takes a voxel that the frame has not.
   * \param[in] holds whether it may stay where nothing near is measured, in this frame
   * \return whether it has not ended, and nothing near is measured
   */
  bool
  countMiss(TrackedVoxel& voxel, bool holds) const;

  /** \brief True if a voxel that the frame has not need not be tracked any more. */
  bool
  isForgotten(const TrackedVoxel& voxel) const
  {
    return !voxel.is_shown && voxel.occupancy < least_occupancy_;
  }

  /** \brief Takes what is shown in the end.
   * \param[in] keys ascending
   * \param[in] depth of the grid */
  void
  setShown(const std::vector<std::uint64_t>& keys, unsigned int depth)
  {
    shown_.assign(keys, depth);
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
  /** \brief When a voxel is shown by its occupancy and hidden. */
  struct Persistence;

  void
  look(const io::VoxelFrame& frame,
       const std::optional<std::array<double, 3>>& sensor_position,
       const DirectionDepths& rays);

  bool
  isAmongSeldomVoxels(std::uint64_t key) const;

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
  BlockNeighbours shown_;         // by the last frame
  BlockNeighbours seldom_;        // tracked, but not shown by it
  SurfaceSupport surfaces_;
  HitShares hit_shares_;
  SeenDepths depths_;
  bool has_depths_ = false;
  unsigned int ticks_ = FrameTicks::usual; // since the last frame
  std::uint32_t fall_ = 0;       // of an occupancy where there is nothing, 2^16 is 1
  std::size_t shown_number_ = 0; // of those that were counted
  std::vector<std::uint64_t> keys_;
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
