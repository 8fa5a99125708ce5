// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/live_messages.h"

#include <nlohmann/json.hpp>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

using nlohmann::json;

/** \brief As text; names that are no UTF-8 get replacement characters. */
std::string
textOf(const json& value)
{
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void
writeLittleEndian(std::uint64_t value, std::size_t count, std::uint8_t* bytes)
{
  for (std::size_t i = 0; i < count; ++i)
    bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

} // namespace

FrameHead
frameHead(std::size_t stream, std::uint32_t flags, std::chrono::nanoseconds time)
{
  FrameHead head;
  writeLittleEndian(stream, 4, head.data());
  writeLittleEndian(flags, 4, head.data() + 4);
  writeLittleEndian(static_cast<std::uint64_t>(time.count()), 8, head.data() + 8);
  return head;
}

std::string
streamsMessage(const std::vector<LiveStream>& streams)
{
  json list = json::array();
  for (std::size_t i = 0; i < streams.size(); ++i)
    list.push_back({{"id", i},
                    {"name", streams[i].name},
                    {"metadata", json(streams[i].metadata)}});
  return textOf({{"type", "streams"}, {"streams", list}});
}

std::string
stateMessage(const std::string& problem,
             const std::vector<std::optional<std::chrono::milliseconds>>& ages)
{
  json list = json::array();
  for (const auto& age : ages)
    list.push_back(age ? json(age->count()) : json());
  return textOf({{"type", "state"}, {"problem", problem}, {"ages_ms", list}});
}

std::string
endMessage()
{
  return R"({"type":"end"})";
}

std::optional<std::size_t>
requestedIFrame(const std::string& message)
{
  const json value = json::parse(message, nullptr, /* allow_exceptions */ false);
  if (!value.is_object())
    return std::nullopt;
  const auto type = value.find("type");
  const auto stream = value.find("stream");
  if (type == value.end() || *type != "i-frame" || stream == value.end() ||
      !stream->is_number_unsigned())
    return std::nullopt;
  return stream->get<std::size_t>();
}

std::string
liveSource(const std::string& name)
{
  return textOf({{"kind", "live"}, {"name", name}, {"socket", "api/live"}});
}

std::string
recordingSource(const std::string& name, const std::vector<ListedFile>& files)
{
  json list = json::array();
  for (const ListedFile& file : files)
    list.push_back({{"name", file.name}, {"url", file.url}, {"size", file.size}});
  return textOf({{"kind", "recording"}, {"name", name}, {"files", list}});
}

} // namespace pcl_ext::PCL_EXT_ABI::view
