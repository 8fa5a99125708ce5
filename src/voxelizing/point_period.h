// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds after how many points of a sequence one is near to the last such one, as
 * those of a laser where several fire in turns.
 * \param[in] positions metres
 * \param[in] edge nearer points are near to each other, metres
 * \return 2 or more; 0: a point is nearest to the one before it
 */
std::uint32_t
findPointPeriod(const std::vector<std::array<double, 3>>& positions, double edge);

} // namespace pcl_ext::PCL_EXT_ABI::io
