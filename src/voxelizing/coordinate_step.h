// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The largest step of which all coordinates of a cloud are multiples: a larger
 * one than the resolution, to a quarter of it, or the resolution itself, to a
 * sixteenth.
 *
 * Recorded coordinates are often whole millimetres or centimetres. Voxels that are
 * centred on these keep them as they are; finer ones take more bytes for the same
 * points.
 * \param[in] points the cloud
 * \param[in] resolution metres
 * \param[in] may_be_larger looks for 0.1, 0.05, 0.02, 0.01 m, ... 0.0001 m, too, if at
 * least twice the resolution
 * \param[in] largest step to look for, metres
 * \param[in] most_multiples coordinates are fewer from the middle, which is at most 2^50
 * from the world's origin
 * \param[in] middle of the coordinates, about, metres
 * \return the step; 0 if there is none; NaN if no point is finite
 */
double
findCoordinateStep(PointBatches& points,
                   double resolution,
                   bool may_be_larger,
                   double largest,
                   double most_multiples,
                   const std::array<double, 3>& middle = {});

/** \brief A finite point of a cloud; the world's origin if there is none. */
std::array<double, 3>
anyPoint(PointBatches& points);

} // namespace pcl_ext::PCL_EXT_ABI::io
