// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace pcl_ext {
namespace measuring {

/** \brief Calls of operator new in this thread since it began.
 * Memory from malloc itself is not counted: the points of PCL's clouds, and zstd's. */
std::size_t
allocationCount();

} // namespace measuring
} // namespace pcl_ext
