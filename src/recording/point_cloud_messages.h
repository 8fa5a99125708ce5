// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/cdr.h"
#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief A field of a point, as sensor_msgs/msg/PointField. */
struct PointFieldMessage {
  std::string name;
  std::uint32_t offset = 0; ///< bytes from the beginning of the point
  std::uint8_t datatype =
      0; ///< 1 to 8: INT8, UINT8, INT16, ..., FLOAT32 is 7, FLOAT64 8
  std::uint32_t count = 1;
};

/** \brief A message of the type sensor_msgs/msg/PointCloud2, or with a format
 * point_cloud_interfaces/msg/CompressedPointCloud2. */
struct PointCloudMessage {
  Time stamp{0};
  std::string frame_id;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PointFieldMessage> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;    ///< bytes of a point
  std::uint32_t row_step = 0;      ///< bytes of a row
  std::vector<std::uint8_t> bytes; ///< the points, or the compressed ones
  bool is_dense = false;           ///< no point is invalid
  std::string format;              ///< of compressed bytes
};

/** \brief True if a channel has messages of sensor_msgs/msg/PointCloud2 in CDR. */
PCL_EXT_RECORDING_EXPORT bool
isPointCloud(const McapChannel& channel);

/** \brief True if a channel has messages of sensor_msgs/PointCloud2 as ROS 1 writes
 * them. */
PCL_EXT_RECORDING_EXPORT bool
isRos1PointCloud(const McapChannel& channel);

/** \brief True if a channel has messages of
 * point_cloud_interfaces/msg/CompressedPointCloud2 in CDR, or those of ROS 1's compressor
 * of this library as ROS 1 writes them. Their format may be another than this
 * library's. */
PCL_EXT_RECORDING_EXPORT bool
isCompressedPointCloud(const McapChannel& channel);

/** \brief A channel of point clouds, with the full text of its schema.
 * \param[in] topic of the channel
 */
PCL_EXT_RECORDING_EXPORT McapChannel
pointCloudChannel(const std::string& topic);

PCL_EXT_RECORDING_EXPORT McapChannel
compressedPointCloudChannel(const std::string& topic);

/** \brief True if the compressed bytes of a message are frames of this library. A
 * format may say more after a slash, such as pcl_ext/version1. */
bool
isFormatOfFrames(const std::string& format);

/** \brief The encoding of the messages of a channel with clouds. */
PCL_EXT_RECORDING_EXPORT MessageEncoding
encodingOf(const McapChannel& channel);

/** \brief Reads a message.
 * \param[in] bytes of the message
 * \param[in] size number of bytes
 * \param[in] is_compressed which of the two types it is
 * \param[out] message its memory is reused
 * \param[in] encoding of the message
 * \return Damaged if the bytes are no such message
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
readPointCloud(const std::uint8_t* bytes,
               std::size_t size,
               bool is_compressed,
               PointCloudMessage& message,
               MessageEncoding encoding = MessageEncoding::Cdr);

/** \brief Writes a message in CDR, little-endian.
 * \param[in] message a stamp whose seconds do not fit 32 bits, as all do between 1901 and
 * 2038, is written as 0, and without a format that of this library's frames
 * \param[in] is_compressed which of the two types it is
 * \param[out] bytes its memory is reused
 */
PCL_EXT_RECORDING_EXPORT void
writePointCloud(const PointCloudMessage& message,
                bool is_compressed,
                std::vector<std::uint8_t>& bytes);

} // namespace pcl_ext::PCL_EXT_ABI::recording
