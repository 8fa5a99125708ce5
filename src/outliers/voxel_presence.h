// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

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

/** \brief What becomes of a shown voxel that a frame has not: it is held, or it has ended.
 * Left: nothing near is measured, so that it is held if anything is. */
enum class Miss { Held, Left, Ended };

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

  /** \brief Begins to count the frame's voxels. */
  void
  beginVoxels();

  /** \brief Counts the voxels of a block that are shown by the last frame, for what is
   * usual. */
  void
  countShown(const TrackedBlock& block, const std::vector<TrackedVoxel>& voxels)
  {
    const unsigned int number = bitCount(block.shown);
    for (; until_sample_ < number; until_sample_ += HitShares::sample_step) {
      std::uint64_t left = block.shown;
      for (std::size_t i = 0; i < until_sample_; ++i)
        left &= left - 1;
      const unsigned int cell = lowestBit(left);
      hit_shares_.add(distanceOf(block.key << io::block_key_bits | cell),
                      voxels[block.recordOf(cell)].empty_ticks > 0,
                      (block.hits >> cell & 1) != 0);
    }
    until_sample_ -= number;
  }

  /** \brief Takes a voxel that the frame has.
   * \param[in] is_tracked whether it was before
   * \return 1 if it may become shown next to a shown one, else 0 */
  std::uint64_t
  countHit(bool is_tracked, TrackedVoxel& voxel) const
  {
    const std::uint32_t occupancy = is_tracked ? voxel.occupancy : 0u;
    voxel.empty_ticks = 0;
    voxel.occupancy =
        static_cast<std::uint16_t>(occupancy + (((certain - occupancy) * rate_) >> 16));
    return (least_frequent - voxel.occupancy) >> 31;
  }

  /** \brief Decides whether a voxel that the frame has, and that was not shown, becomes
   * shown: one that may, or that has no shown one next to it in its block.
   * \param[in] block index of its block */
  bool
  becomesShown(const MergedBlocks& merged,
               std::size_t block,
               unsigned int cell,
               TrackedVoxel& voxel) const;

  /** \brief Takes a shown voxel that the frame has not.
   * \param[in] is_next_to_hit whether the frame has one next to it in its block */
  Miss
  countMiss(const MergedBlocks& merged,
            std::uint64_t key,
            bool is_next_to_hit,
            TrackedVoxel& voxel) const;

  /** \brief Takes a voxel that the frame has not, and that is not shown.
   * \return as isForgotten() */
  std::uint64_t
  fade(std::uint16_t& occupancy) const
  {
    occupancy = static_cast<std::uint16_t>(occupancy - (occupancy * rate_ >> 16));
    return isForgotten(occupancy);
  }

  /** \brief 1 if a voxel that is neither shown nor hit is not tracked any more, else 0.
   * By arithmetic, as branches would be mispredicted. */
  std::uint64_t
  isForgotten(std::uint32_t occupancy) const
  {
    return (occupancy - least_occupancy_) >> 31;
  }

  /** \brief Releases memory that the next frame does not need. */
  void
  releaseMemory()
  {
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

  static constexpr std::uint32_t least_frequent = certain * 2 / 5;
  static const Persistence dense;
  static const Persistence sparse;
  static const Persistence noisy;

  unsigned int frames_;
  bool holds_;
  std::uint32_t rate_;            // of the running means, 2^16 is 1
  std::uint32_t least_occupancy_; // below it empty voxels are forgotten
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
