// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "outliers/direction_depths.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief How far a sensor sees in each direction, in voxels, by the voxels of a frame. */
class SeenDepths {
public:
  /** \brief Depths that differ by less may be of one surface, voxels. */
  static constexpr float margin = 2.0f;

  /** \brief Sets the depths to those of a frame.
   * \param[in] keys its voxels
   * \param[in] grid of the frame
   * \param[in] position of the sensor, in the grid's coordinates, metres; finite
   */
  void
  assign(const std::vector<std::uint64_t>& keys,
         const io::VoxelGrid& grid,
         const std::array<double, 3>& position)
  {
    depths_.clear();
    edge_ = static_cast<float>(grid.resolution);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double voxels =
          std::clamp((position[axis] - grid.centre(axis, 0)) / grid.resolution,
                     -farthest,
                     farthest);
      position_[axis] = static_cast<float>(voxels);
      nearest_[axis] = static_cast<std::int64_t>(std::round(voxels));
    }
    std::uint64_t cube = 0;            // of 8 x 8 x 8 voxels
    io::VoxelPosition lowest{0, 0, 0}; // voxel of the cube
    std::array<std::array<std::int32_t, DirectionDepths::batch_size>, 3> at{};
    for (std::size_t first = 0; first < keys.size(); first += at[0].size()) {
      const std::size_t count = std::min(keys.size() - first, at[0].size());
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t key = keys[first + i];
        if (key >> 9 != cube) {
          cube = key >> 9;
          lowest = io::voxelPosition(cube << 9);
        }
        const std::uint32_t bits = io::detail::axis_bits[key & 511];
        at[0][i] = static_cast<std::int32_t>(lowest.x + (bits & 7));
        at[1][i] = static_cast<std::int32_t>(lowest.y + (bits >> 3 & 7));
        at[2][i] = static_cast<std::int32_t>(lowest.z + (bits >> 6));
      }
      DirectionDepths::Batch batch;
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < batch[axis].size(); ++i)
          batch[axis][i] = static_cast<float>(at[axis][i]) - position_[axis];
      depths_.add(batch, count, least_depth);
    }
  }

  /** \brief True if a voxel of the frame is farther than others in its direction, so
   * that the sensor cannot be at its position. */
  bool
  isBehindOthers(std::uint64_t key) const
  {
    const Direction at = directionOf(key);
    return at.depth >= least_depth && depths_[at.square] + margin < at.depth;
  }

  /** \brief True if the sensor sees that there is nothing at the place of a voxel: all
   * that is in its direction and around is farther.
   * \param[in] rays that end where the frame has no points, from the same position,
   * metres
   * \param[in] or_hidden whether it is true, too, if something is nearer */
  bool
  isEmpty(std::uint64_t key, const DirectionDepths& rays, bool or_hidden) const
  {
    const Direction at = directionOf(key);
    // Mostly there is something in the middle.
    if (at.depth < least_depth ||
        (!or_hidden && depths_[at.square] <= at.depth + margin))
      return false;
    // Half of a voxel, in squares.
    const std::uint32_t radius = at.depth <= 28.0f    ? 3
                                 : at.depth <= 51.0f  ? 2
                                 : at.depth <= 256.0f ? 1
                                                      : 0;
    float nearest = depths_.leastAround(at.square, radius);
    if (or_hidden || nearest > at.depth + margin)
      nearest = std::min(nearest, rays.leastAround(at.square, radius) / edge_);
    return nearest != DirectionDepths::unseen &&
           (nearest > at.depth + margin || (or_hidden && nearest + margin < at.depth));
  }

  /** \brief Square of the distance of a voxel from the sensor, in voxels; the sensor's
   * position is rounded to a voxel. */
  std::uint64_t
  squaredDistance(std::uint64_t key) const
  {
    const io::VoxelPosition at = io::voxelPosition(key);
    const std::int64_t x = std::int64_t{at.x} - nearest_[0];
    const std::int64_t y = std::int64_t{at.y} - nearest_[1];
    const std::int64_t z = std::int64_t{at.z} - nearest_[2];
    return static_cast<std::uint64_t>(x * x + y * y + z * z);
  }

private:
  using Direction = DirectionDepths::Direction;

  static constexpr double farthest = 0x1p28; // voxels, of the sensor from the grid

  static constexpr float least_depth = 1.0f; // voxels; nearer ones have no direction

  std::array<float, 3>
  fromSensor(const io::VoxelPosition& at) const
  {
    // As signed numbers, which vector instructions convert.
    const std::array<std::int32_t, 3> position = {static_cast<std::int32_t>(at.x),
                                                  static_cast<std::int32_t>(at.y),
                                                  static_cast<std::int32_t>(at.z)};
    return {static_cast<float>(position[0]) - position_[0],
            static_cast<float>(position[1]) - position_[1],
            static_cast<float>(position[2]) - position_[2]};
  }

  Direction
  directionOf(std::uint64_t key) const
  {
    const auto [x, y, z] = fromSensor(io::voxelPosition(key));
    return DirectionDepths::directionOf(x, y, z);
  }

  std::array<float, 3> position_{};       // of the sensor, voxels from that of key 0
  std::array<std::int64_t, 3> nearest_{}; // the same, rounded
  float edge_ = 1.0f;                     // of a voxel, metres
  DirectionDepths depths_;                // voxels
};

} // namespace pcl_ext::PCL_EXT_ABI
