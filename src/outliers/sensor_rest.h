// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "outliers/block_neighbours.h"
#include "outliers/frame_ticks.h"
#include "outliers/surface_support.h"
#include "outliers/tracked_voxels.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Tells whether a sensor moves: by its positions, and by the share of the
 * surfaces' voxels that were near none in a frame before. */
class SensorRest {
public:
  /** \brief Takes the next frame.
   * \param[in] frame its voxels
   * \param[in] surfaces that have learned from it
   * \param[in] position of the sensor, metres, if it is known; finite
   * \param[in] ticks since the frame before
   * \return Unknown of the first one
   */
  io::SensorMotion
  judge(const io::VoxelFrame& frame,
        const SurfaceSupport& surfaces,
        const std::optional<std::array<double, 3>>& position,
        unsigned int ticks)
  {
    rest_ticks_ = std::min(rest_ticks_ + ticks, ticks_to_rest);
    followPosition(position, frame.grid.resolution);
    const bool is_elsewhere = rest_ticks_ < ticks_to_rest;
    const bool is_first = !reference_;
    if (reference_) {
      reference_->age += ticks;
      has_other_surfaces_ =
          reference_->has_surfaces && showsOtherSurfaces(frame, surfaces);
    }
    // After one that is empty or nearly so the next one with surfaces is taken.
    if (!reference_ || reference_->age >= oldest_reference ||
        (!reference_->has_surfaces && hasSurfaces(frame, surfaces))) {
      reference_ = Reference{frame.grid, {}, 0, hasSurfaces(frame, surfaces)};
      for (unsigned int level = 0; level <= surfaces.highestLevel(); ++level)
        reference_->occupied.push_back(surfaces.occupied(level));
    }
    return is_elsewhere || has_other_surfaces_ ? io::SensorMotion::Moving
           : is_first                          ? io::SensorMotion::Unknown
                                               : io::SensorMotion::AtRest;
  }

  /** \brief Takes it that the sensor moves in the last frame, as the temporal filter has
   * found out. */
  void
  setMoving()
  {
    rest_ticks_ = 0;
  }

private:
  /** \brief A reference is replaced when it is as old, ticks: in this time a slow sensor
   * moves by more than a voxel. */
  static constexpr unsigned int oldest_reference = 4 * FrameTicks::usual;

  /** \brief For so long a sensor that has moved counts as moving, ticks. */
  static constexpr unsigned int ticks_to_rest = 10 * FrameTicks::usual;

  /** \brief One voxel of so many is compared. */
  static constexpr std::size_t sample_step = 16;

  /** \brief Of fewer surfaces' voxels in the sample nothing is said. */
  static constexpr std::size_t least_sample = 16;

  /** \brief Where fewer of the voxels than one of so many are of surfaces, coarse voxels
   * are compared. */
  static constexpr std::size_t surface_part = 4;

  /** \brief Neighbours of the voxels of surfaces; noise has fewer. */
  static constexpr unsigned int surface_neighbours = 4;

  /** \brief A frame that later ones are compared with. */
  struct Reference {
    io::VoxelGrid grid;
    std::vector<BlockNeighbours> occupied; // voxels, coarse voxels
    unsigned int age;                      // ticks
    bool has_surfaces;                     // else nothing is compared with it
  };

  /** \brief A position that is more than a voxel from the last is of a sensor that
   * moves. */
  void
  followPosition(const std::optional<std::array<double, 3>>& position,
                 double resolution)
  {
    if (!position)
      return;
    const std::array<double, 3> last = position_.value_or(*position);
    double square = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double along = (*position)[axis] - last[axis];
      square += along * along;
    }
    if (square > resolution * resolution)
      rest_ticks_ = 0;
    if (!position_ || rest_ticks_ == 0)
      position_ = position;
  }

  /** \brief Voxels of surfaces, and how many of them are more than a voxel from all of
   * the reference. */
  struct Comparison {
    std::size_t surfaces = 0;
    std::size_t others = 0;

    /** \brief Whether others are more than one of so many. */
    bool
    hasOthers(std::size_t part) const
    {
      return part * others > surfaces;
    }

    Comparison&
    operator+=(const Comparison& other)
    {
      surfaces += other.surfaces;
      others += other.others;
      return *this;
    }
  };

  /** \brief Of as many parts of a frame, each of voxels that are near each other. */
  using Comparisons = std::array<Comparison, 32>;

  static Comparison
  sumOf(const Comparisons& parts)
  {
    Comparison sum;
    for (const Comparison& part : parts)
      sum += part;
    return sum;
  }

  /** \brief The sum without the parts that have most others, which have up to a third of
   * the surfaces' voxels. */
  static Comparison
  sumOfLeast(Comparisons parts)
  {
    const auto has_more = [](const Comparison& one, const Comparison& next) {
      return one.others * (next.surfaces + 1) > next.others * (one.surfaces + 1);
    };
    std::sort(parts.begin(), parts.end(), has_more);
    const std::size_t most = sumOf(parts).surfaces / 3;
    std::size_t left_out = 0;
    Comparison sum;
    for (const Comparison& part : parts) {
      left_out += part.surfaces;
      if (left_out > most)
        sum += part;
    }
    return sum;
  }

  Comparisons
  compare(const io::VoxelFrame& frame,
          const BlockNeighbours& occupied,
          unsigned int level) const
  {
    Comparisons parts;
    for (std::size_t i = 0; i < frame.size(); i += sample_step) {
      const std::uint64_t at = frame.keys[i] >> 3 * level;
      if (!isOfSurface(at, occupied))
        continue;
      Comparison& part = parts[i * parts.size() / frame.size()];
      ++part.surfaces;
      const std::optional<std::uint64_t> key =
          keyInGrid(reference_->grid, frame.grid, frame.keys[i]);
      const bool is_near = key && reference_->occupied[level].isNear(*key >> 3 * level);
      part.others += is_near ? 0 : 1;
    }
    return parts;
  }

  /** \brief Whether a frame has so many voxels of surfaces that others can be compared
   * with them. */
  static bool
  hasSurfaces(const io::VoxelFrame& frame, const SurfaceSupport& surfaces)
  {
    for (unsigned int level = 0; level <= surfaces.highestLevel(); ++level) {
      std::size_t count = 0;
      for (std::size_t i = 0; i < frame.size(); i += sample_step)
        count += isOfSurface(frame.keys[i] >> 3 * level, surfaces.occupied(level));
      if (count >= least_sample)
        return true;
    }
    return false;
  }

  static bool
  isOfSurface(std::uint64_t key, const BlockNeighbours& occupied)
  {
    return occupied.count(key, surface_neighbours) >= surface_neighbours;
  }

  /** \brief True if more than a quarter of the surfaces' voxels are others than in the
   * reference, and an eighth of those in the parts of the frame that have least of them:
   * what moves before a sensor that rests is in a few parts. Half of these shares, where
   * that was so before. */
  bool
  showsOtherSurfaces(const io::VoxelFrame& frame, const SurfaceSupport& surfaces) const
  {
    const std::size_t levels =
        std::min<std::size_t>(surfaces.highestLevel() + 1, reference_->occupied.size());
    Comparisons parts;
    Comparison sum;
    for (unsigned int level = 0; level < levels; ++level) {
      parts = compare(frame, surfaces.occupied(level), level);
      sum = sumOf(parts);
      if (surface_part * sample_step * sum.surfaces >= frame.size())
        break;
    }
    const std::size_t share = has_other_surfaces_ ? 8 : 4;
    return sum.surfaces >= least_sample && sum.hasOthers(share) &&
           sumOfLeast(parts).hasOthers(2 * share);
  }

  std::optional<Reference> reference_;
  bool has_other_surfaces_ = false;
  std::optional<std::array<double, 3>> position_; // at first, or of the last move
  unsigned int rest_ticks_ = ticks_to_rest;       // since it moved
};

/** \brief Tells whether the sensor of a stream moves, where no TemporalVoxelFilter
 * does. */
class FrameMotion {
public:
  /** \brief Takes the stream's next frame.
   * \param[in] frame its voxels
   * \param[in] position of the sensor, metres
   * \param[in] time of the cloud
   * \return as SensorRest::judge()
   */
  io::SensorMotion
  judge(const io::VoxelFrame& frame,
        const std::array<double, 3>& position,
        const std::optional<std::chrono::nanoseconds>& time)
  {
    if (grid_ && (grid_->resolution != frame.grid.resolution ||
                  grid_->origin != frame.grid.origin))
      rest_ = SensorRest();
    grid_ = frame.grid;
    surfaces_.learn(frame, [](std::uint64_t) { return std::uint64_t{0}; });
    return rest_.judge(frame, surfaces_, position, ticks_.take(time));
  }

private:
  std::optional<io::VoxelGrid> grid_; // of the last frame
  FrameTicks ticks_;
  SurfaceSupport surfaces_;
  SensorRest rest_;
};

} // namespace pcl_ext::PCL_EXT_ABI
