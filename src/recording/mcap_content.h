// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief What the messages of a channel consist of. */
struct McapSchema {
  std::string name;     ///< such as "sensor_msgs/msg/PointCloud2"
  std::string encoding; ///< such as "ros2msg"; empty: there is no schema
  std::string text;     ///< the definition, with those of all types in it
};

/** \brief The messages of one topic. */
struct McapChannel {
  std::string topic;
  std::string message_encoding; ///< such as "cdr"
  McapSchema schema;
  std::map<std::string, std::string> metadata;
};

struct McapMessage {
  std::size_t channel = 0;    ///< index in the channels of the file
  std::uint32_t sequence = 0; ///< counts the messages of the channel, or 0
  Time log_time{0};           ///< when it was recorded
  Time publish_time{0};       ///< when it was published
  std::vector<std::uint8_t> bytes;
};

/** \brief Named values that a file has besides its messages. */
struct McapMetadata {
  std::string name;
  std::map<std::string, std::string> values;
};

/** \brief A file within the file. */
struct McapAttachment {
  Time log_time{0};
  Time create_time{0};
  std::string name;
  std::string media_type;
  std::vector<std::uint8_t> bytes;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
