// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The symbol that one point adds to a voxel, for intensities that depend on the
 * depth in a sensor's frame. From it the coder computes a voxel's number of points and
 * codes the residual of its symbol in few bits. Symbols are coded exactly with any
 * model.
 *
 * Fixed point, so that both ends of a stream compute the same numbers.
 */
struct DepthModel {
  /** \brief Exponent of the relative depth z / z_c: 1 for the linear law, 2 for the
   * quadratic one (sections 2.5.2 and 2.5.3 of the paper). */
  std::uint8_t exponent = 2;

  /** \brief Symbol of a share of 1, in units of 2^-8; below 2^24. */
  std::uint32_t full_symbol = 0;

  /** \brief Relative depth at the centre of the grid's lowest voxel, in units of 2^-32;
   * -2^56..2^56. */
  std::int64_t origin = 0;

  /** \brief Change of the relative depth from one voxel to the next along x, y and z,
   * in units of 2^-32. */
  std::array<std::int32_t, 3> step{};

  /** \brief Symbol that a point at the centre of a voxel adds, in units of 2^-16. */
  std::uint64_t
  pointSymbol(const VoxelPosition& position) const
  {
    return pointSymbolAt(origin + std::int64_t{step[0]} * position.x +
                         std::int64_t{step[1]} * position.y +
                         std::int64_t{step[2]} * position.z);
  }

  /** \brief The same for a relative depth in units of 2^-32, clamped to 0..1. */
  std::uint64_t
  pointSymbolAt(std::int64_t depth) const
  {
    constexpr std::int64_t one = std::int64_t{1} << 32;
    const auto relative_depth =
        static_cast<std::uint64_t>(std::clamp(depth, std::int64_t{0}, one)) >> 8;
    const std::uint64_t share =
        exponent == 2 ? relative_depth * relative_depth >> 24 : relative_depth;
    return share * full_symbol >> 16;
  }

  bool
  operator==(const DepthModel& other) const
  {
    return exponent == other.exponent && full_symbol == other.full_symbol &&
           origin == other.origin && step == other.step;
  }

  bool
  operator!=(const DepthModel& other) const
  {
    return !(*this == other);
  }
};

/** \brief True if all members of a depth model are within their ranges. */
PCL_EXT_CODEC_EXPORT bool
isConsistent(const DepthModel& model);

struct IntensityScale;

/** \brief The depth model of a grid.
 * \param[in] law the law; its full intensity in the unit of decoded intensities
 * \param[in] sensor_origin position of the sensor in the world, metres
 * \param[in] optical_axis direction of the sensor's z axis in the world, of length 1
 * \param[in] grid grid of the frame
 * \param[in] scale intensity scale of the frame
 * \return std::nullopt if a member would be out of range, as with voxels of the size of
 * the cut-off depth, or if the scale does not begin at 0 or is companded
 */
PCL_EXT_CODEC_EXPORT std::optional<DepthModel>
depthModelOf(const DepthLaw& law,
             const std::array<double, 3>& sensor_origin,
             const std::array<double, 3>& optical_axis,
             const VoxelGrid& grid,
             const IntensityScale& scale);

} // namespace pcl_ext::PCL_EXT_ABI::io
