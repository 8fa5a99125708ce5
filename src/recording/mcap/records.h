// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The records of MCAP files, version 0 of the format (https://mcap.dev/spec), field by
 * field.
 */
#pragma once

#include "recording/mcap_content.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief The bytes that an MCAP file begins and ends with; the 0 is the version. */
constexpr std::array<std::uint8_t, 8> magic = {
    0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : std::uint8_t {
  Header = 1,
  Footer,
  Schema,
  Channel,
  Message,
  Chunk,
  MessageIndex,
  ChunkIndex,
  Attachment,
  AttachmentIndex,
  Statistics,
  Metadata,
  MetadataIndex,
  SummaryOffset,
  DataEnd
};

/** \brief Bytes before the content of a record: opcode and length of the content. */
constexpr std::size_t record_prefix_size = 9;

/** \brief Bytes of a footer with its prefix. */
constexpr std::size_t footer_size = record_prefix_size + 20;

/** \brief True for a record that ends the data. With another length it is a damaged one
 * of another kind. */
constexpr bool
endsData(Opcode opcode, std::uint64_t content_length)
{
  return (opcode == Opcode::DataEnd && content_length == sizeof(std::uint32_t)) ||
         (opcode == Opcode::Footer &&
          content_length == footer_size - record_prefix_size);
}

/** \brief Bytes of a message before its own, with the prefix of the record. */
constexpr std::size_t message_prefix_size = record_prefix_size + 22;

struct Header {
  static constexpr Opcode opcode = Opcode::Header;

  std::string profile;
  std::string library;
};

struct Footer {
  static constexpr Opcode opcode = Opcode::Footer;

  std::uint64_t summary_start = 0;
  std::uint64_t summary_offset_start = 0;
  std::uint32_t summary_checksum = 0;
};

struct Schema {
  static constexpr Opcode opcode = Opcode::Schema;

  std::uint16_t id = 0;
  McapSchema content;
};

/** \brief The schema of its content is not part of the record, but its id. */
struct Channel {
  static constexpr Opcode opcode = Opcode::Channel;

  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  McapChannel content;
};

struct MessagePrefix {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
};

struct Chunk {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_checksum = 0; // 0: none
  std::string compression;
  std::uint64_t records_size = 0; // as they are in the file
};

struct MessageIndex {
  static constexpr Opcode opcode = Opcode::MessageIndex;

  std::uint16_t channel_id = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> entries; // log time, offset
};

struct ChunkIndex {
  static constexpr Opcode opcode = Opcode::ChunkIndex;

  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t chunk_offset = 0;
  std::uint64_t chunk_length = 0; // of the record with its prefix
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
};

struct Statistics {
  static constexpr Opcode opcode = Opcode::Statistics;

  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0;
  std::uint32_t attachments = 0;
  std::uint32_t metadata = 0;
  std::uint32_t chunks = 0;
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::map<std::uint16_t, std::uint64_t> channel_messages;
};

/** \brief Where in a file an attachment or a metadata record is. */
struct RecordExtent {
  std::uint64_t offset = 0;
  std::uint64_t length = 0; // of the record with its prefix
};

/** \brief Parses the content of a record, without its prefix. Later versions of the
 * format may append fields, which are ignored.
 * \tparam RecordT one of the records above but a chunk, McapMetadata or McapAttachment.
 * Of an index of attachments or metadata a RecordExtent is parsed.
 * \return false if the content is too short or contradicts itself
 */
template <class RecordT>
bool
parse(const std::uint8_t* bytes, std::size_t size, RecordT& record);

/** \brief The same for the fields of a chunk before its records.
 * \param[in] size bytes at hand; 256 are enough for known compressions
 * \param[out] fields_size bytes of these fields; the records begin after them
 */
bool
parse(const std::uint8_t* bytes,
      std::size_t size,
      Chunk& chunk,
      std::size_t& fields_size);

/** \brief Appends a whole record.
 * \tparam RecordT a record with an opcode, McapMetadata or McapAttachment
 */
template <class RecordT>
void
append(const RecordT& record, std::vector<std::uint8_t>& bytes);

/** \brief Appends a message. */
void
append(const MessagePrefix& prefix,
       const std::vector<std::uint8_t>& message,
       std::vector<std::uint8_t>& bytes);

/** \brief Appends a chunk up to and without its records. */
void
appendChunkFields(const Chunk& chunk, std::vector<std::uint8_t>& bytes);

/** \brief Append index records of metadata and attachments. */
void
appendMetadataIndex(const RecordExtent& extent,
                    const std::string& name,
                    std::vector<std::uint8_t>& bytes);
void
appendAttachmentIndex(const RecordExtent& extent,
                      const McapAttachment& attachment_without_bytes,
                      std::uint64_t size,
                      std::vector<std::uint8_t>& bytes);

void
appendSummaryOffset(Opcode group,
                    std::uint64_t start,
                    std::uint64_t length,
                    std::vector<std::uint8_t>& bytes);

void
appendDataEnd(std::uint32_t data_checksum, std::vector<std::uint8_t>& bytes);

/** \brief Appends a footer whose checksum is 0, as it covers the fields before it. */
void
appendFooter(const Footer& footer, std::vector<std::uint8_t>& bytes);

/** \brief The time of a message. Those beyond the range of Time, the year 2262, are its
 * last one. */
Time
messageTime(std::uint64_t nanoseconds);

/** \brief CRC-32 (ISO-HDLC) of bytes that follow others.
 * \param[in] checksum of the bytes before, 0 if there are none
 */
std::uint32_t
checksumOf(const std::uint8_t* bytes, std::size_t size, std::uint32_t checksum = 0);

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
