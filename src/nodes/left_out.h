// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/message_layout.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Why a field that settings name is in a cloud, but cannot be kept; empty if
 * there is none such. */
std::string
faultOfNamedFields(const pcl::PCLPointCloud2& cloud,
                   const std::vector<io::FieldSetting>& settings);

/** \brief The layout of a cloud's message, of the fields that may come back, if the
 * settings carry it; it may be none by io::isLayout(). */
io::MessageLayout
layoutToCarry(const pcl::PCLPointCloud2& cloud, const SensorNodeSettings& settings);

} // namespace pcl_ext::PCL_EXT_ABI::nodes
