// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Between clouds of PCL, voxels, and messages.
 */
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "recording/point_cloud_messages.h"

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <string>

namespace pcl_ext::tools {

/** \brief Bytes of a number of a datatype of PointField; 0: there is no such type. */
inline std::uint32_t
bytesOf(std::uint8_t datatype)
{
  constexpr auto last = static_cast<std::uint8_t>(io::FieldType::Float64);
  return datatype >= static_cast<std::uint8_t>(io::FieldType::Int8) && datatype <= last
             ? static_cast<std::uint32_t>(
                   io::sizeOf(static_cast<io::FieldType>(datatype)))
             : 0;
}

/** \brief The cloud of a message; numbers in the byte order of this machine.
 * \param[in,out] message its points are moved out; it is not checked
 */
void
toCloud(recording::PointCloudMessage& message, pcl::PCLPointCloud2& cloud);

/** \brief The message of a cloud, without its points.
 * \param[in] stamp of the cloud
 */
recording::PointCloudMessage
describeCloud(const pcl::PCLPointCloud2& cloud, recording::Time stamp);

/** \brief The points of decoded voxels: x, y, z, and what the frame has of intensity
 * and rgb; a voxel with a number of points has as many. Coordinates are FLOAT64 where
 * VoxelFrame::needsDoubles(), else FLOAT32. */
void
toCloud(const io::VoxelFrame& frame, pcl::PCLPointCloud2& cloud);

/** \brief What point_cloud_transport adds to the topic of clouds that are
 * compressed. */
constexpr const char* compressed_suffix = "/pcl_ext";

/** \brief The topic of the clouds that a stream was made of: without that suffix. */
std::string
topicOf(const std::string& stream);

} // namespace pcl_ext::tools
