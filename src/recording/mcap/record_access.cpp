// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/record_access.h"

#include "recording/mcap/chunk_compression.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

/** \brief Bytes of a chunk that hold its fields before the records. */
constexpr std::size_t max_chunk_fields_size = 256;

} // namespace

bool
takeRecord(SpanReader& reader, Record& record)
{
  if (reader.remaining() == 0)
    return false;
  record.opcode = static_cast<Opcode>(reader.u8());
  const std::uint64_t length = reader.u64();
  record.content = reader.take(length);
  record.size = static_cast<std::size_t>(length);
  return record.content != nullptr;
}

bool
hasMagic(const InputFile& file, std::uint64_t offset)
{
  std::array<std::uint8_t, magic.size()> bytes;
  return file.read(offset, bytes.size(), bytes.data()) && bytes == magic;
}

bool
hasMcapEnd(const InputFile& file)
{
  return file.size() >= 2 * magic.size() + footer_size &&
         hasMagic(file, file.size() - magic.size());
}

void
BytesAfterEnd::add(const std::uint8_t* bytes, std::size_t count)
{
  std::size_t used = 0;
  // The first of the magic bytes is in them once.
  for (; used < count && matched_ < magic.size(); ++used)
    matched_ = bytes[used] == magic[matched_] ? matched_ + 1
               : bytes[used] == magic[0]      ? 1
                                              : 0;
  count_ += count - used;
}

std::string
BytesAfterEnd::describe() const
{
  return std::to_string(count_) + " bytes follow the end of the file, as where another "
                                  "one was appended; they are lost";
}

bool
readRecordPrefix(const InputFile& file,
                 std::uint64_t offset,
                 Opcode& opcode,
                 std::uint64_t& content_length)
{
  std::array<std::uint8_t, record_prefix_size> prefix;
  if (!file.read(offset, prefix.size(), prefix.data()))
    return false;
  SpanReader reader(prefix.data(), prefix.size());
  opcode = static_cast<Opcode>(reader.u8());
  content_length = reader.u64();
  return true;
}

bool
readRecord(const InputFile& file,
           std::uint64_t offset,
           Opcode opcode,
           std::vector<std::uint8_t>& content)
{
  Opcode found{};
  std::uint64_t length = 0;
  if (!readRecordPrefix(file, offset, found, length) || found != opcode ||
      length > max_record_bytes || length > file.size() - offset - record_prefix_size)
    return false;
  content.resize(static_cast<std::size_t>(length));
  return file.read(offset + record_prefix_size, content.size(), content.data());
}

bool
readMessage(const std::uint8_t* content,
            std::size_t size,
            McapMessage& message,
            std::uint16_t& channel_id)
{
  MessagePrefix prefix;
  if (!parse(content, size, prefix))
    return false;
  constexpr std::size_t fields_size = message_prefix_size - record_prefix_size;
  channel_id = prefix.channel_id;
  message.sequence = prefix.sequence;
  message.log_time = messageTime(prefix.log_time);
  message.publish_time = messageTime(prefix.publish_time);
  message.bytes.assign(content + fields_size, content + size);
  return true;
}

std::string
loadChunk(const InputFile& file,
          const Section& section,
          std::vector<std::uint8_t>& records)
{
  return loadChunk(
      [&file](std::uint64_t offset, std::size_t count, std::uint8_t* bytes) {
        return file.read(offset, count, bytes);
      },
      section,
      records);
}

std::string
loadChunk(const ReadAt& read,
          const Section& section,
          std::vector<std::uint8_t>& records)
{
  records.clear();
  const auto fields_at_hand = static_cast<std::size_t>(
      std::min<std::uint64_t>(section.length, max_chunk_fields_size));
  std::array<std::uint8_t, max_chunk_fields_size> fields;
  Chunk chunk;
  std::size_t fields_size = 0;
  if (fields_at_hand < record_prefix_size ||
      !read(section.offset, fields_at_hand, fields.data()) ||
      fields[0] != static_cast<std::uint8_t>(Opcode::Chunk) ||
      !parse(fields.data() + record_prefix_size,
             fields_at_hand - record_prefix_size,
             chunk,
             fields_size))
    return "its fields are invalid; its messages are lost";
  const std::uint64_t begin = record_prefix_size + fields_size;
  std::uint64_t size = section.length - begin;
  if (section.is_cut_off ? chunk.records_size < size : chunk.records_size != size)
    return "its size contradicts that of its record; its messages are lost";
  const std::uint64_t most_bytes = mostChunkBytes(size);
  if (chunk.uncompressed_size > most_bytes || size > most_bytes)
    return largerThan(most_bytes) + "; its messages are lost";
  std::vector<std::uint8_t> compressed(static_cast<std::size_t>(size));
  if (!read(section.offset + begin, compressed.size(), compressed.data()))
    return "it cannot be read; its messages are lost";
  std::string failure = decompress(chunk.compression,
                                   compressed.data(),
                                   compressed.size(),
                                   chunk.uncompressed_size,
                                   records);
  if (section.is_cut_off)
    return failure;
  if (failure.empty() && records.size() != chunk.uncompressed_size)
    failure = "it has fewer bytes than it declares";
  if (failure.empty() && chunk.uncompressed_checksum != 0 &&
      checksumOf(records.data(), records.size()) != chunk.uncompressed_checksum)
    failure = "its checksum is wrong";
  if (failure.empty())
    return {};
  records.clear();
  return failure + "; its messages are lost";
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
