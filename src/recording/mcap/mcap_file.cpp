// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/mcap_file.h"

#include "recording/mcap/record_access.h"

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

void
findMessages(ChunkCache::Records& records)
{
  SpanReader reader(records.bytes.data(), records.bytes.size());
  Record record;
  for (std::size_t offset = 0; takeRecord(reader, record); offset = reader.position())
    if (record.opcode == Opcode::Message)
      records.offsets.push_back(offset);
}

/** \brief Takes a message from the content of its record. */
} // namespace

std::string
McapFile::read(const MessagePlace& place,
               McapMessage& message,
               std::uint16_t& channel_id)
{
  const Section& section = place.section;
  if (!section.is_chunk) {
    if (!readRecord(file(), place.offset, Opcode::Message, record_))
      return "a message cannot be read";
    return readMessage(record_.data(), record_.size(), message, channel_id)
               ? std::string()
               : not_indexed;
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
  return takeRecord(reader, record) &&
                 readMessage(record.content, record.size, message, channel_id)
             ? std::string()
             : not_indexed;
}

bool
McapFile::readMetadata(const RecordExtent& extent, McapMetadata& metadata)
{
  return readRecord(file(), extent.offset, Opcode::Metadata, record_) &&
         parse(record_.data(), record_.size(), metadata);
}

bool
McapFile::readAttachment(const RecordExtent& extent, McapAttachment& attachment)
{
  return readRecord(file(), extent.offset, Opcode::Attachment, record_) &&
         parse(record_.data(), record_.size(), attachment);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
