// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "outliers/block_neighbours.h"
#include "outliers/distance_bands.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief How many occupied neighbours the voxels of surfaces have at each distance:
 * few where pixels are further apart than voxels. Learned from a sample of the voxels.
 */
class SurfaceDensity {
public:
  /** \brief One voxel of so many is counted. */
  static constexpr std::size_t sample_step = 32;

  /** \brief Forgets a part of the earlier frames. */
  void
  age()
  {
    for (Band& band : bands_) {
      band.voxels -= band.voxels / 8;
      band.neighbours -= band.neighbours / 8;
    }
  }

  /** \param[in] distance of a voxel from the sensor, squared, in voxels; 0 without one
   * \param[in] neighbours its occupied neighbours, 0..26 */
  void
  add(std::uint64_t distance, unsigned int neighbours)
  {
    Band& band = bands_[distanceBand(distance)];
    band.voxels += unit;
    band.neighbours += unit * neighbours;
  }

  /** \brief Computes mean() from what was added. A distance where few voxels were seen
   * has the mean of the next nearer one, and nearer surfaces are at least as dense:
   * where there is mostly noise, its neighbours do not count. */
  void
  update()
  {
    std::uint32_t mean = 0;
    for (std::size_t i = 0; i < bands_.size(); ++i) {
      if (isSeen(i))
        mean = static_cast<std::uint32_t>(16 * bands_[i].neighbours / bands_[i].voxels);
      means_[i] = mean;
    }
    for (std::size_t i = bands_.size() - 1; i > 0; --i)
      means_[i - 1] = std::max(means_[i - 1], means_[i]);
  }

  /** \brief True if the mean is lower where voxels were seen at some distance. */
  bool
  isBelow(std::uint32_t mean) const
  {
    for (std::size_t i = 0; i < bands_.size(); ++i)
      if (isSeen(i) && means_[i] < mean)
        return true;
    return false;
  }

  /** \brief Mean number of neighbours at a distance, in sixteenths. */
  std::uint32_t
  mean(std::uint64_t distance) const
  {
    return means_[distanceBand(distance)];
  }

private:
  static constexpr std::uint64_t unit = 64;         // of the sums, as they are divided
  static constexpr std::uint64_t least_voxels = 16; // of the last frames

  bool
  isSeen(std::size_t band) const
  {
    return bands_[band].voxels >= least_voxels * unit;
  }

  struct Band {
    std::uint64_t voxels = 0;
    std::uint64_t neighbours = 0;
  };

  std::array<Band, distance_band_count> bands_{};
  std::array<std::uint32_t, distance_band_count> means_{};
};

/** \brief How many neighbours of a voxel are occupied, in relation to those that
 * surfaces have: enough for one, a few, or none. */
enum class Support { None, Some, Enough };

/** \brief Judges the voxels of a frame by their neighbours. Where pixels are too far
 * apart for voxels, coarse voxels of 2 or 4 voxels along each axis count instead. */
class SurfaceSupport {
public:
  static constexpr unsigned int level_count = 3;

  /** \brief Takes the voxels of a frame, and learns how many neighbours they have.
   * \param[in] frame with keys
   * \param[in] distance_of called as distance_of(key): square of the distance of a
   * voxel from the sensor, in voxels; 0 without a sensor
   * \param[in] is_noisy whether hasCoarseNeighbour() is called
   */
  template <typename DistanceT>
  void
  learn(const io::VoxelFrame& frame, DistanceT&& distance_of, bool is_noisy = false)
  {
    for (unsigned int level = 0; level < level_count; ++level) {
      const bool is_used = level == 0 || (level == 1 && is_noisy) ||
                           levels_[level - 1].density.isBelow(enough_neighbours);
      if (!is_used || (level > 0 && frame.grid.depth <= level))
        return;
      highest_ = level;
      Level& around = levels_[level];
      if (level == 0)
        around.occupied.assign(frame.keys);
      else
        around.occupied.assignOctants(levels_[level - 1].occupied);
      around.density.age();
      for (std::size_t i = 0; i < frame.size(); i += SurfaceDensity::sample_step)
        around.density.add(distance_of(frame.keys[i]),
                           around.occupied.count(frame.keys[i] >> 3 * level));
      around.density.update();
    }
  }

  /** \brief Removes the voxels, and releases memory; what was learned stays. */
  void
  releaseMemory()
  {
    for (Level& level : levels_)
      level.occupied = BlockNeighbours();
  }

  /** \brief True if a frame does not hit all voxels of a surface at a distance. */
  bool
  isSparse(std::uint64_t distance) const
  {
    return levelAt(distance) > 0;
  }

  /** \brief The support of a voxel.
   * \param[in] key of the voxel
   * \param[in] distance as above
   * \param[in] neighbours that the frame has around it
   * \param[in] additional neighbours that it takes to have enough
   */
  Support
  of(std::uint64_t key,
     std::uint64_t distance,
     unsigned int neighbours,
     unsigned int additional = 0) const
  {
    const unsigned int level = levelAt(distance);
    const std::uint32_t mean = levels_[level].density.mean(distance);
    // A plane has 8 neighbours, of which its edges and corners have 5 and 3.
    const std::uint32_t least = mean < enough_neighbours ? 1 : 2;
    const std::uint32_t needed =
        std::clamp(mean * mean / (256 * 34), least, std::uint32_t{5}) + additional;
    const unsigned int count =
        level == 0 ? neighbours
                   : levels_[level].occupied.count(key >> 3 * level, needed);
    if (count >= needed)
      return Support::Enough;
    return count > 0 || mean < lone_neighbours ? Support::Some : Support::None;
  }

  /** \brief True if the frame has a voxel in one of the 27 coarse voxels of level 1
   * around a voxel, or around it where a grid has no coarse voxels. */
  bool
  hasCoarseNeighbour(std::uint64_t key) const
  {
    const unsigned int level = std::min(highest_, 1u);
    return levels_[level].occupied.isNear(key >> 3 * level);
  }

  /** \brief The level of the coarsest voxels in use. */
  unsigned int
  highestLevel() const
  {
    return highest_;
  }

  /** \brief The frame's voxels, or its coarse ones of a level in use, which have 2^level
   * voxels along each axis. */
  const BlockNeighbours&
  occupied(unsigned int level) const
  {
    return levels_[level].occupied;
  }

private:
  /** \brief Mean number of neighbours, in sixteenths, from which voxels do without
   * coarse voxels. */
  static constexpr std::uint32_t enough_neighbours = 16 * 7;
  /** \brief Below this mean, in sixteenths, surfaces have lone voxels. */
  static constexpr std::uint32_t lone_neighbours = 16 * 2;

  /** \brief The occupied voxels or coarse voxels of a frame. */
  struct Level {
    BlockNeighbours occupied;
    SurfaceDensity density;
  };

  /** \brief The level at which surfaces at a distance have enough neighbours. */
  unsigned int
  levelAt(std::uint64_t distance) const
  {
    unsigned int level = 0;
    while (level < highest_ &&
           levels_[level].density.mean(distance) < enough_neighbours)
      ++level;
    return level;
  }

  std::array<Level, level_count> levels_; // coarse voxels are 2^level voxels wide
  unsigned int highest_ = 0;              // that is in use
};

} // namespace pcl_ext::PCL_EXT_ABI
