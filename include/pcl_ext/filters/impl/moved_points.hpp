// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::detail {

/** \brief A rigid transformation followed by a crop box. */
struct PointMove {
  /** \brief The rows of [rotation | translation], metres: sensor -> global coordinate
   * frame. */
  std::array<std::array<float, 4>, 3> rows;
  std::array<float, 3> min; ///< corners of the crop box, global coordinates, metres,
  std::array<float, 3> max; ///< both ends included; infinite: no crop box
};

/** \brief A view of points: x, y, z as consecutive floats, metres. */
struct PointBytes {
  const unsigned char* first; ///< x of the first point; need not be aligned
  std::size_t stride;         ///< bytes from one x to the next, at least 12
  std::size_t count;          ///< at most MovedPoints::capacity
};

/** \brief The points that were kept; their coordinates are elsewhere. */
struct MovedPoints {
  static constexpr std::size_t capacity = 256;

  std::size_t count = 0;      ///< points that were kept
  std::size_t not_finite = 0; ///< points left out as they are not finite after the move
  std::array<float, capacity> depths; ///< z of those kept, before the move, metres
  std::array<std::uint32_t, capacity> sources; ///< their indices in the input
};

/** \brief Floats from one point to the next in the output of movePoints(), which are
 * pcl::PointXYZI. */
constexpr std::size_t moved_point_floats = 8;

/** \brief Moves points and drops those that are then not finite or outside the crop
 * box.
 * \param[in] points the input
 * \param[in] move transformation and crop box
 * \param[out] output x, y, z and 1 of each point that was kept, moved_point_floats
 * apart; needs space for all points, and is unspecified beyond those kept
 * \param[out] moved indices and depths of the points that were kept
 */
PCL_EXT_EXPORT void
movePoints(const PointBytes& points,
           const PointMove& move,
           float* output,
           MovedPoints& moved);

} // namespace pcl_ext::PCL_EXT_ABI::detail
