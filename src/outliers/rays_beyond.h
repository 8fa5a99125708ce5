// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/point_view.h>

#include "outliers/direction_depths.h"

#include <array>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Takes the depths of the points outside of a box.
 * \param[in] points metres
 * \param[in] position of the sensor, metres; finite
 * \param[in,out] depths metres
 */
void
addPointsBeyond(io::PointBatches& points,
                const io::BoundingBox& box,
                const std::array<double, 3>& position,
                DirectionDepths& depths);

} // namespace pcl_ext::PCL_EXT_ABI
