// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/mcap/records.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief The channels of a file with their schemas, as their records are found. */
class ChannelList {
public:
  /** \param[in] wants channels whose messages are wanted; empty: all; must outlive
   * this */
  explicit ChannelList(const ChannelFilter& wants) : wants_(wants) {}

  /** \brief Adds a schema, unless there is one of its id.
   * \param[in] content of the record
   * \param[in] size bytes of the content
   */
  void
  addSchema(const std::uint8_t* content, std::size_t size);

  /** \brief Adds a channel, unless there is one of its id; its schema was added before.
   * \param[in] content of the record
   * \param[in] size bytes of the content
   */
  void
  addChannel(const std::uint8_t* content, std::size_t size);

  /** \brief True if there is a channel whose messages are wanted. */
  bool
  isWanted(std::uint16_t channel_id) const;

  /** \brief True if not all channels are wanted. */
  bool
  hasFilter() const
  {
    return static_cast<bool>(wants_);
  }

  /** \brief True if channels were left out, as all together were too large. */
  bool
  hasTooMany() const
  {
    return has_too_many_;
  }

  /** \brief The channel of an id; null if there is none. */
  const McapChannel*
  find(std::uint16_t channel_id) const
  {
    const auto found = channels_.find(channel_id);
    return found == channels_.end() ? nullptr : &found->second;
  }

  std::size_t
  size() const
  {
    return channels_.size();
  }

  /** \brief The channels by id; the list is of no use afterwards. */
  std::map<std::uint16_t, McapChannel>
  takeAll()
  {
    return std::move(channels_);
  }

private:
  const ChannelFilter& wants_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::map<std::uint16_t, bool> wanted_; // by the channel's id
  std::size_t bytes_ = 0;                // of all channels with their schemas
  bool has_too_many_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
