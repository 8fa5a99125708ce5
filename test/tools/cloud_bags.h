// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/mcap_content.h"
#include "recording/point_cloud_messages.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

/** \brief Log time of cloud i; its stamp is earlier. */
recording::Time
logTime(std::size_t i);
recording::Time
stampOf(std::size_t i);

recording::McapChannel
imuChannel();

recording::McapMessage
cloudMessage(const pcl::PointCloud<pcl::PointXYZI>& points,
             std::size_t i,
             const std::string& frame_id = "lidar");

std::vector<recording::PointCloudMessage>
cloudsOf(const std::string& path);

/** \brief Writes a bag with two topics of clouds, another topic, metadata and an
 * attachment. */
void
writeBag(const std::string& path, std::size_t frames);

/** \brief Writes a bag with topics of uneven rates: clouds of /fast, every seventh time
 * one of /slow, and messages of /imu. Some clouds of both cannot be read.
 * \param[in] frames clouds of /fast
 */
void
writeUnevenBag(const std::string& path, std::size_t frames);

} // namespace pcl_ext::tools::test
