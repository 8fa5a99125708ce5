// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include <array>
#include <cstdint>
#include <vector>

// How points without rays follow each other, and where they are in voxels.

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds after how many points of a sequence one is near to the last such one, as
 * those of a laser where several fire in turns.
 * \param[in] positions metres
 * \param[in] edge nearer points are near to each other, metres
 * \return 2 or more; 0: a point is nearest to the one before it
 */
std::uint32_t
findPointPeriod(const std::vector<std::array<double, 3>>& positions, double edge);

/** \brief Finds where in voxels, on each axis, the points are to be that are whole edges
 * apart: in the centres, unless coordinates are on a grid of their own.
 * \param[in] positions metres
 * \return edges, 0 to below 1
 */
std::array<double, 3>
findPhases(const std::vector<std::array<double, 3>>& positions, const VoxelGrid& grid);

} // namespace pcl_ext::PCL_EXT_ABI::io
