// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/cloud_input.h"
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"

#include <string>

namespace pcl_ext::tools {

/** \brief True if a channel has messages of clouds, of ROS 2 or of ROS 1. */
bool
hasClouds(const recording::McapChannel& channel);

/** \brief Sets a cloud by its message, or why that is none.
 * \param[in] channel of the message
 * \param[in] packs_colours see InputOptions
 * \param[in,out] message has memory that is used again
 */
void
readCloud(const recording::McapChannel& channel,
          bool packs_colours,
          InputCloud& cloud,
          recording::PointCloudMessage& message);

/** \brief Reads messages of a file or a folder that BagReader takes. */
class BagPlaceReader : public PlaceReader {
public:
  /** \throws std::runtime_error if the bag cannot be opened */
  BagPlaceReader(const std::string& path, bool packs_colours);

  void
  read(InputCloud& cloud) override;

  bool
  read(std::size_t place, recording::McapMessage& message) override;

  const recording::BagReader&
  reader() const
  {
    return reader_;
  }

private:
  bool packs_colours_;
  recording::BagReader reader_;
  recording::PointCloudMessage message_;
};

} // namespace pcl_ext::tools
