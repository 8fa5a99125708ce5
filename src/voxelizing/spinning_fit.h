// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "codec/scan/scan_rays.h"
#include "voxelizing/ray_fit.h"
#include "voxelizing/turn_motion.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Columns of a turn whose points fits are made with, spread over the turn. */
struct SampledColumns {
  std::uint32_t count; ///< of the turn
  std::uint32_t every; ///< one of so many is used

  /** \param[in] pixels_of_point where points are few more columns are used */
  SampledColumns(std::uint32_t column_count, std::size_t pixels_of_point = 1)
  : count(column_count)
  {
    constexpr std::size_t enough = 96;
    constexpr std::size_t many_pixels = 3;
    const std::size_t share = pixels_of_point < many_pixels ? 1 : pixels_of_point;
    every = static_cast<std::uint32_t>(count / (enough * share) + 1);
  }

  bool
  has(std::uint32_t column) const
  {
    return column % every == 0;
  }
};

/** \brief Rays of a spinning sensor, in its coordinates, metres and radians. */
struct SpinningFit {
  std::vector<RowFit> rows;
  TurnMotion motion;
  bool has_motion = false;
  double depth_step = 0.0;
  double turn_step = 0.0; ///< of the angles of columns; negative: clockwise
  bool is_even = false;   ///< columns are a step apart
  /** \brief Whether the angles of all points are multiples of it. */
  bool has_turn_step = false;
};

/** \brief Fits the rays of the rows of a spinning sensor whose columns are at any angles,
 * the distance of its depths and that of its angles.
 * \param[in] points with rows and columns
 * \param[in] edge that places are to be exact to, metres
 * \return nothing if most points are in rows that have too few
 */
std::optional<SpinningFit>
fitSpinning(const std::vector<PixelPoint>& points,
            std::uint32_t row_count,
            const SampledColumns& sampled,
            double edge);

/** \brief The same for a sensor whose columns are evenly spaced, whose lasers may be
 * beside its axis.
 * \param[in] points row after row, if the turn is not known; few of each row are enough,
 * if there are neighbours among them
 * \param[in] turn of a column, radians, if it is known
 * \return nothing if there are too few points
 */
std::optional<SpinningFit>
fitEvenSpinning(const std::vector<PixelPoint>& points,
                const ImageSize& size,
                const std::optional<double>& turn);

/** \brief Moves the motion of a fit, if it has one, to that of another turn.
 * \param[in] points of that turn, with rows and columns
 */
void
followMotion(const std::vector<PixelPoint>& points,
             const SampledColumns& sampled,
             SpinningFit& fit);

/** \brief Fits the heights of the rays of rows, as lines over the distance from the axis.
 * \param[in,out] rows those with few points are left as they are
 */
void
fitHeights(const std::vector<TurnPoint>& samples, std::vector<RowFit>& rows);

/** \brief How many points are in rows whose heights are fitted. */
std::size_t
pointsOfFittedRows(const std::vector<TurnPoint>& samples,
                   const std::vector<RowFit>& rows);

/** \brief Half of the points are nearer to the rays of their rows than this, radians.
 * \param[in] samples not empty, none at the sensor
 */
double
medianHeightOff(const std::vector<TurnPoint>& samples, const std::vector<RowFit>& rows);

/** \brief Sets the rays of a scan, but for the angles of columns that are not even.
 * \param[in] sensor_pose sensor -> grid, metres
 * \param[in,out] layout its size is given
 * \return whether they are within their ranges
 */
bool
setSpinningRays(const SpinningFit& fit,
                const WorldPose& sensor_pose,
                const VoxelGrid& grid,
                scan::ScanLayout& layout);

} // namespace pcl_ext::PCL_EXT_ABI::io
