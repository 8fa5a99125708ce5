// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/ros1/ros1_file.h"

#include "recording/ros1/records.h"
#include "recording/span_reader.h"

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

namespace {

void
findMessages(ChunkCache::Records& records)
{
  SpanReader reader(records.bytes.data(), records.bytes.size());
  Record record;
  for (std::size_t offset = 0; takeRecord(reader, record); offset = reader.position())
    if (record.fields.op() == Op::Message)
      records.offsets.push_back(offset);
}

} // namespace

/** \brief Takes all of a message but its bytes from the header of its record. */
std::string
Ros1File::takeMessage(const Fields& fields,
                      McapMessage& message,
                      std::uint16_t& channel_id) const
{
  const std::optional<std::uint32_t> connection = fields.connection();
  const std::optional<std::uint16_t> channel =
      connection ? connections_.channelOf(*connection) : std::nullopt;
  if (fields.op() != Op::Message || !channel)
    return not_indexed;
  channel_id = *channel;
  message.sequence = 0;
  message.log_time = message.publish_time =
      mcap::messageTime(nanosecondsOf(fields.number("time", 8).value_or(0)));
  return {};
}

std::string
Ros1File::read(const MessagePlace& place,
               McapMessage& message,
               std::uint16_t& channel_id)
{
  const Section& section = place.section;
  if (!section.is_chunk) {
    FileRecord record;
    if (!record.read(file(), place.offset) || record.end() > file().size())
      return "a message cannot be read";
    message.bytes.resize(static_cast<std::size_t>(record.dataSize()));
    if (!file().read(record.data(), message.bytes.size(), message.bytes.data()))
      return "a message cannot be read";
    return takeMessage(record.fields(), message, channel_id);
  }
  SpanReader reader(nullptr, 0);
  std::string failure = cache_.findMessage(
      place,
      [&](ChunkCache::Records& loaded) {
        loaded.failure = loadChunk(file(), section, loaded.bytes);
        findMessages(loaded);
      },
      reader);
  if (!failure.empty())
    return failure;
  Record record;
  if (!takeRecord(reader, record))
    return not_indexed;
  message.bytes.assign(record.data, record.data + record.size);
  return takeMessage(record.fields, message, channel_id);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
