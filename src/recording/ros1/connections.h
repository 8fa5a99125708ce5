// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/ros1/records.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

/** \brief The connections of a bag and their channels: each publisher of a topic has a
 * connection, and those that agree in everything are one channel. */
class Connections {
public:
  /** \brief Adds a connection, unless there is one of its number.
   * \param[in] fields of the record's header
   * \param[in] data of the record: fields, too
   * \return false if it is invalid
   */
  bool
  add(const Fields& fields, const Fields& data);

  /** \brief The channel of a connection; nothing if there is none. */
  std::optional<std::uint16_t>
  channelOf(std::uint32_t connection) const
  {
    const auto found = channel_of_.find(connection);
    return found == channel_of_.end() ? std::nullopt
                                      : std::optional<std::uint16_t>(found->second);
  }

  /** \brief True if connections were left out, as all together were too large. */
  bool
  hasTooMany() const
  {
    return has_too_many_;
  }

  const std::map<std::uint16_t, McapChannel>&
  channels() const
  {
    return channels_;
  }

private:
  std::map<std::uint32_t, std::uint16_t> channel_of_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::map<std::string, std::uint16_t> by_content_;
  std::size_t bytes_ = 0; // of all channels
  bool has_too_many_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
