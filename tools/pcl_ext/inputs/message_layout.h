// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/stream_metadata.h"
#include "recording/point_cloud_messages.h"

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Where messages have the fields of their points, for programs that read these
 * as structures. */
struct MessageLayout {
  std::vector<recording::PointFieldMessage> fields;
  std::uint32_t point_step = 0;  ///< bytes; 0: the layout is not known
  std::uint32_t row_padding = 0; ///< bytes behind each row of an organised cloud
};

/** \brief The layout of the messages that a stream was made of; without point_step if
 * its metadata has none, or an invalid one. */
MessageLayout
layoutOf(const StreamMetadata& metadata);

/** \brief Adds the layout of a cloud to the metadata of its stream.
 * \return false: it is none, or none that layoutOf() returns, and was not added
 */
bool
addLayout(const pcl::PCLPointCloud2& cloud, StreamMetadata& metadata);

/** \brief Gives a message another layout.
 *
 * Numbers are converted to the types of the layout: rounded to whole ones and limited to
 * their range. rgb and rgba are the same colour. Fields that the layout does not have
 * follow its last byte. Fields that the message does not have are not listed; their
 * bytes are 0, as is padding.
 * \param[in] layout as layoutOf() returns it; without point_step nothing is done
 * \param[in,out] message in the byte order of this machine, without padding
 * \return why nothing was done; empty if it has the layout
 */
std::string
arrange(const MessageLayout& layout, recording::PointCloudMessage& message);

} // namespace tools
} // namespace pcl_ext
