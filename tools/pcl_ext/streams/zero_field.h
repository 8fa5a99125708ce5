// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <string>

namespace pcl_ext::tools {

/** \brief Makes a cloud with a further field of zeros, FLOAT32, behind the other bytes of
 * a point, without the fields of that name, which cannot be read.
 * \return false: not all points are within the data
 */
bool
addZeros(const pcl::PCLPointCloud2& cloud,
         const std::string& name,
         pcl::PCLPointCloud2& with_zeros);

} // namespace pcl_ext::tools
