// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/cloud_input.h"
#include "recording/mcap_reader.h"
#include "recording/point_cloud_messages.h"

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief Sets a cloud by its message, or why that is none.
 * \param[in,out] message has memory that is used again
 */
void
readCloud(InputCloud& cloud, recording::PointCloudMessage& message);

/** \brief Reads messages of an MCAP file or a rosbag2 folder. */
class McapPlaceReader : public PlaceReader {
public:
  /** \throws std::runtime_error if the bag cannot be opened */
  explicit McapPlaceReader(const std::string& path);

  void
  read(InputCloud& cloud) override;

  bool
  read(std::size_t place, recording::McapMessage& message) override;

  const recording::McapReader&
  reader() const
  {
    return reader_;
  }

private:
  recording::McapReader reader_;
  recording::PointCloudMessage message_;
};

} // namespace tools
} // namespace pcl_ext
