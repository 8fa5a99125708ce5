// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/channel_list.h"

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

/** \brief Bytes of all channels with their schemas. Many channels may have one schema,
 * of which each gets a copy. */
constexpr std::size_t max_channel_bytes = std::size_t{1} << 27;

} // namespace

void
ChannelList::addSchema(const std::uint8_t* content, std::size_t size)
{
  Schema schema;
  if (parse(content, size, schema))
    schemas_.emplace(schema.id, std::move(schema.content));
}

void
ChannelList::addChannel(const std::uint8_t* content, std::size_t size)
{
  Channel channel;
  if (!parse(content, size, channel) || channels_.count(channel.id) != 0)
    return;
  const auto schema = schemas_.find(channel.schema_id);
  bytes_ += size + (schema != schemas_.end() ? schema->second.text.size() : 0);
  has_too_many_ |= bytes_ > max_channel_bytes;
  if (has_too_many_)
    return;
  if (schema != schemas_.end())
    channel.content.schema = schema->second;
  wanted_[channel.id] = !wants_ || wants_(channel.content);
  channels_.emplace(channel.id, std::move(channel.content));
}

bool
ChannelList::isWanted(std::uint16_t channel_id) const
{
  const auto found = wanted_.find(channel_id);
  return found != wanted_.end() && found->second;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
