// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/records.h"

#include "bytes/byte_writer.h"
#include "recording/span_reader.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <tuple>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

/** \brief The fields of a record in the order of the file, for both directions. */
template <class RecordT>
auto
fieldsOf(RecordT& record)
{
  using Record = std::remove_const_t<RecordT>;
  if constexpr (std::is_same_v<Record, Header>)
    return std::tie(record.profile, record.library);
  else if constexpr (std::is_same_v<Record, Footer>)
    return std::tie(
        record.summary_start, record.summary_offset_start, record.summary_checksum);
  else if constexpr (std::is_same_v<Record, Schema>)
    return std::tie(
        record.id, record.content.name, record.content.encoding, record.content.text);
  else if constexpr (std::is_same_v<Record, Channel>)
    return std::tie(record.id,
                    record.schema_id,
                    record.content.topic,
                    record.content.message_encoding,
                    record.content.metadata);
  else if constexpr (std::is_same_v<Record, MessagePrefix>)
    return std::tie(
        record.channel_id, record.sequence, record.log_time, record.publish_time);
  else if constexpr (std::is_same_v<Record, Chunk>)
    return std::tie(record.start_time,
                    record.end_time,
                    record.uncompressed_size,
                    record.uncompressed_checksum,
                    record.compression,
                    record.records_size);
  else if constexpr (std::is_same_v<Record, MessageIndex>)
    return std::tie(record.channel_id, record.entries);
  else if constexpr (std::is_same_v<Record, ChunkIndex>)
    return std::tie(record.start_time,
                    record.end_time,
                    record.chunk_offset,
                    record.chunk_length,
                    record.message_index_offsets,
                    record.message_index_length,
                    record.compression,
                    record.compressed_size,
                    record.uncompressed_size);
  else if constexpr (std::is_same_v<Record, Statistics>)
    return std::tie(record.messages,
                    record.schemas,
                    record.channels,
                    record.attachments,
                    record.metadata,
                    record.chunks,
                    record.start_time,
                    record.end_time,
                    record.channel_messages);
  else if constexpr (std::is_same_v<Record, McapMetadata>)
    return std::tie(record.name, record.values);
  else if constexpr (std::is_same_v<Record, McapAttachment>) // then the bytes
    return std::tie(
        record.log_time, record.create_time, record.name, record.media_type);
  else if constexpr (std::is_same_v<Record, RecordExtent>)
    return std::tie(record.offset, record.length);
}

class FieldWriter : public io::ByteWriter {
public:
  using ByteWriter::ByteWriter;

  /** \param[in] field a number, a time, a text, or pairs of these, after their size */
  template <class FieldT>
  void
  write(const FieldT& field)
  {
    if constexpr (std::is_same_v<FieldT, Time>)
      u64(static_cast<std::uint64_t>(field.count()));
    else if constexpr (std::is_same_v<FieldT, std::uint16_t>)
      u16(field);
    else if constexpr (std::is_same_v<FieldT, std::uint32_t>)
      u32(field);
    else if constexpr (std::is_same_v<FieldT, std::uint64_t>)
      u64(field);
    else if constexpr (std::is_same_v<FieldT, std::string>) {
      u32(static_cast<std::uint32_t>(field.size()));
      raw(field.data(), field.size());
    }
    else {
      std::size_t size = 0;
      for (const auto& [key, value] : field)
        size += sizeOf(key) + sizeOf(value);
      u32(static_cast<std::uint32_t>(size));
      for (const auto& [key, value] : field) {
        write(key);
        write(value);
      }
    }
  }

  template <class... FieldsT>
  void
  writeAll(const std::tuple<FieldsT...>& fields)
  {
    std::apply([this](const auto&... field) { (write(field), ...); }, fields);
  }

private:
  template <class FieldT>
  static std::size_t
  sizeOf(const FieldT& field)
  {
    if constexpr (std::is_same_v<FieldT, std::string>)
      return sizeof(std::uint32_t) + field.size();
    else
      return sizeof(field);
  }
};

/** \brief Writes the prefix of a record, and its length when the record is complete. */
class RecordWriter : public FieldWriter {
public:
  RecordWriter(Opcode opcode, std::vector<std::uint8_t>& bytes)
  : FieldWriter(bytes), bytes_(bytes)
  {
    u8(static_cast<std::uint8_t>(opcode));
    u64(0); // replaced by the destructor
    begin_ = bytes.size();
  }

  ~RecordWriter()
  {
    std::uint64_t length = bytes_.size() - begin_;
    for (std::size_t i = 0; i < 8; ++i, length >>= 8)
      bytes_[begin_ - 8 + i] = static_cast<std::uint8_t>(length);
  }

  RecordWriter(const RecordWriter&) = delete;
  RecordWriter&
  operator=(const RecordWriter&) = delete;

private:
  std::vector<std::uint8_t>& bytes_;
  std::size_t begin_ = 0;
};

class FieldReader : public SpanReader {
public:
  using SpanReader::SpanReader;

  /** \return false if there are too few bytes */
  template <class... FieldsT>
  bool
  readAll(const std::tuple<FieldsT...>& fields)
  {
    bool is_whole = true;
    std::apply([&](auto&... field) { ((is_whole = read(field) && is_whole), ...); },
               fields);
    return is_whole && !failed();
  }

private:
  template <class FieldT>
  bool
  read(FieldT& field)
  {
    if constexpr (std::is_same_v<FieldT, Time>)
      field = Time(static_cast<std::int64_t>(u64()));
    else if constexpr (std::is_integral_v<FieldT>)
      field = static_cast<FieldT>(number(sizeof(FieldT)));
    else if constexpr (std::is_same_v<FieldT, std::string>)
      field = string();
    else
      return readPairs(field);
    return true;
  }

  /** \brief Maps and arrays. Of keys that are there twice the first one counts. */
  template <class PairsT>
  bool
  readPairs(PairsT& pairs)
  {
    pairs.clear();
    const std::uint32_t size = u32();
    const std::uint8_t* const begin = take(size);
    FieldReader entries(begin, begin == nullptr ? 0 : size);
    while (entries.remaining() > 0) {
      std::remove_const_t<typename PairsT::value_type::first_type> key{};
      typename PairsT::value_type::second_type value{};
      entries.read(key);
      entries.read(value);
      pairs.insert(pairs.end(), {std::move(key), std::move(value)});
    }
    return !entries.failed();
  }
};

} // namespace

template <class RecordT>
bool
parse(const std::uint8_t* bytes, std::size_t size, RecordT& record)
{
  FieldReader reader(bytes, size);
  bool is_valid = reader.readAll(fieldsOf(record));
  if constexpr (std::is_same_v<RecordT, Schema>)
    is_valid = is_valid && record.id != 0;
  if constexpr (std::is_same_v<RecordT, McapAttachment>) {
    const std::uint64_t data_size = reader.u64();
    const std::uint8_t* const data = reader.take(data_size);
    if (data == nullptr)
      return false;
    record.bytes.assign(data, data + data_size);
    const std::size_t checked_size = reader.position();
    const std::uint32_t checksum = reader.u32();
    is_valid = !reader.failed() &&
               (checksum == 0 || checksum == checksumOf(bytes, checked_size));
  }
  return is_valid;
}

template bool
parse(const std::uint8_t*, std::size_t, Header&);
template bool
parse(const std::uint8_t*, std::size_t, Footer&);
template bool
parse(const std::uint8_t*, std::size_t, Schema&);
template bool
parse(const std::uint8_t*, std::size_t, Channel&);
template bool
parse(const std::uint8_t*, std::size_t, MessagePrefix&);
template bool
parse(const std::uint8_t*, std::size_t, MessageIndex&);
template bool
parse(const std::uint8_t*, std::size_t, ChunkIndex&);
template bool
parse(const std::uint8_t*, std::size_t, Statistics&);
template bool
parse(const std::uint8_t*, std::size_t, McapMetadata&);
template bool
parse(const std::uint8_t*, std::size_t, McapAttachment&);
template bool
parse(const std::uint8_t*, std::size_t, RecordExtent&);

bool
parse(const std::uint8_t* bytes,
      std::size_t size,
      Chunk& chunk,
      std::size_t& fields_size)
{
  FieldReader reader(bytes, size);
  const bool is_whole = reader.readAll(fieldsOf(chunk));
  fields_size = reader.position();
  return is_whole;
}

template <class RecordT>
void
append(const RecordT& record, std::vector<std::uint8_t>& bytes)
{
  if constexpr (std::is_same_v<RecordT, McapAttachment>) {
    RecordWriter writer(Opcode::Attachment, bytes);
    const std::size_t begin = bytes.size();
    writer.writeAll(fieldsOf(record));
    writer.u64(record.bytes.size());
    writer.raw(record.bytes.data(), record.bytes.size());
    writer.u32(checksumOf(bytes.data() + begin, bytes.size() - begin));
  }
  else if constexpr (std::is_same_v<RecordT, McapMetadata>)
    RecordWriter(Opcode::Metadata, bytes).writeAll(fieldsOf(record));
  else
    RecordWriter(RecordT::opcode, bytes).writeAll(fieldsOf(record));
}

template void
append(const Header&, std::vector<std::uint8_t>&);
template void
append(const Schema&, std::vector<std::uint8_t>&);
template void
append(const Channel&, std::vector<std::uint8_t>&);
template void
append(const MessageIndex&, std::vector<std::uint8_t>&);
template void
append(const ChunkIndex&, std::vector<std::uint8_t>&);
template void
append(const Statistics&, std::vector<std::uint8_t>&);
template void
append(const McapMetadata&, std::vector<std::uint8_t>&);
template void
append(const McapAttachment&, std::vector<std::uint8_t>&);

void
append(const MessagePrefix& prefix,
       const std::vector<std::uint8_t>& message,
       std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Message, bytes);
  writer.writeAll(fieldsOf(prefix));
  writer.raw(message.data(), message.size());
}

void
appendChunkFields(const Chunk& chunk, std::vector<std::uint8_t>& bytes)
{
  const std::uint64_t fields_size = 28 + 4 + chunk.compression.size() + 8;
  FieldWriter writer(bytes);
  writer.u8(static_cast<std::uint8_t>(Opcode::Chunk));
  writer.u64(fields_size + chunk.records_size);
  writer.writeAll(fieldsOf(chunk));
}

void
appendMetadataIndex(const RecordExtent& extent,
                    const std::string& name,
                    std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::MetadataIndex, bytes);
  writer.writeAll(fieldsOf(extent));
  writer.write(name);
}

void
appendAttachmentIndex(const RecordExtent& extent,
                      const McapAttachment& attachment_without_bytes,
                      std::uint64_t size,
                      std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::AttachmentIndex, bytes);
  writer.writeAll(fieldsOf(extent));
  writer.write(attachment_without_bytes.log_time);
  writer.write(attachment_without_bytes.create_time);
  writer.write(size);
  writer.write(attachment_without_bytes.name);
  writer.write(attachment_without_bytes.media_type);
}

void
appendSummaryOffset(Opcode group,
                    std::uint64_t start,
                    std::uint64_t length,
                    std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::SummaryOffset, bytes);
  writer.u8(static_cast<std::uint8_t>(group));
  writer.u64(start);
  writer.u64(length);
}

void
appendDataEnd(std::uint32_t data_checksum, std::vector<std::uint8_t>& bytes)
{
  RecordWriter(Opcode::DataEnd, bytes).u32(data_checksum);
}

void
appendFooter(const Footer& footer, std::vector<std::uint8_t>& bytes)
{
  RecordWriter(Opcode::Footer, bytes).writeAll(fieldsOf(footer));
}

Time
messageTime(std::uint64_t nanoseconds)
{
  return Time(static_cast<std::int64_t>(
      std::min<std::uint64_t>(nanoseconds, std::numeric_limits<std::int64_t>::max())));
}

std::uint32_t
checksumOf(const std::uint8_t* bytes, std::size_t size, std::uint32_t checksum)
{
  // zlib returns the initial checksum for a null pointer, which no bytes may have.
  if (size == 0)
    return checksum;
  return static_cast<std::uint32_t>(crc32_z(checksum, bytes, size));
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
