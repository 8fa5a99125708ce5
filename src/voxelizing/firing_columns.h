// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Learns in which order a spinning sensor fires its lasers, one of each row after
 * the other: that of the rows of its points.
 * \param[in] rows of the points, below row_count
 * \return place of each row within a column
 */
std::vector<std::uint32_t>
firingRanks(const std::vector<std::uint32_t>& rows, std::uint32_t row_count);

/** \brief Finds the columns of points that come as lasers are fired. By these, and by
 * ranks within each, they are then in the order of the cloud.
 * \param[in] rows of the points, below the number of ranks
 * \return columns of the points, ascending by at most 1
 */
std::vector<std::uint32_t>
firingColumns(const std::vector<std::uint32_t>& rows,
              const std::vector<std::uint32_t>& ranks);

} // namespace pcl_ext::PCL_EXT_ABI::io
