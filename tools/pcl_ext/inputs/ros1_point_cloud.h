// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/point_cloud_messages.h"

#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace tools {

/** \brief Reads a message of the type sensor_msgs/PointCloud2 in the encoding of ROS 1.
 * \throws std::runtime_error if the bytes are no such message
 */
void
readRos1PointCloud(const std::uint8_t* bytes,
                   std::size_t size,
                   recording::PointCloudMessage& message);

} // namespace tools
} // namespace pcl_ext
