// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/ros1/connections.h"

#include <limits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

namespace {

constexpr std::size_t max_channels = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t max_connections = std::size_t{1} << 20;
constexpr std::size_t max_bytes = std::size_t{1}
                                  << 26; // of all texts, and their copies

/** \brief All that tells channels apart. */
std::string
contentOf(const McapChannel& channel)
{
  std::string content;
  const auto add = [&content](const std::string& text) {
    content += std::to_string(text.size()) + ":" + text;
  };
  add(channel.topic);
  add(channel.schema.name);
  add(channel.schema.text);
  for (const auto& [name, value] : channel.metadata) {
    add(name);
    add(value);
  }
  return content;
}

} // namespace

bool
Connections::add(const Fields& fields, const Fields& data)
{
  const std::optional<std::uint32_t> connection = fields.connection();
  McapChannel channel;
  if (!connection || !fields.find("topic", channel.topic) ||
      !data.find("type", channel.schema.name))
    return false;
  if (channel_of_.count(*connection) != 0 || has_too_many_)
    return true;
  channel.message_encoding = "ros1";
  channel.schema.encoding = "ros1msg";
  data.find("message_definition", channel.schema.text);
  for (const char* const name : {"md5sum", "callerid", "latching"})
    if (std::string value; data.find(name, value))
      channel.metadata[name] = value;
  const std::string content = contentOf(channel);
  const auto id = static_cast<std::uint16_t>(channels_.size());
  const auto same = by_content_.find(content);
  const bool is_new = same == by_content_.end();
  bytes_ += is_new ? 2 * content.size() : 0;
  has_too_many_ = bytes_ > max_bytes || channel_of_.size() >= max_connections ||
                  (is_new && channels_.size() >= max_channels);
  if (has_too_many_)
    return true;
  channel_of_[*connection] = is_new ? id : same->second;
  if (is_new) {
    by_content_.emplace(content, id);
    channels_.emplace(id, std::move(channel));
  }
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
