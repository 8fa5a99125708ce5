// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <pcl/PCLPointCloud2.h>

#include <string>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief Why a field that settings name is in a cloud, but cannot be kept; empty if
 * there is none such. */
std::string
faultOfNamedFields(const pcl::PCLPointCloud2& cloud,
                   const std::vector<io::FieldSetting>& settings);

} // namespace nodes
} // namespace pcl_ext
