#include "recording/mcap/records.h"

#include "bytes/byte_writer.h"
#include "recording/span_reader.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace pcl_ext {
namespace recording {
namespace mcap {

namespace {

using Map = std::map<std::string, std::string>;

/** \brief Writes the prefix of a record, and its length when the record is complete. */
class RecordWriter : public io::ByteWriter {
public:
  RecordWriter(Opcode opcode, std::vector<std::uint8_t>& bytes)
  : ByteWriter(bytes), bytes_(bytes)
  {
    u8(static_cast<std::uint8_t>(opcode));
    u64(0); // replaced by finish()
    begin_ = bytes.size();
  }

  ~RecordWriter() { setLength(bytes_.size() - begin_); }
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter&
  operator=(const RecordWriter&) = delete;

  void
  string(const std::string& text)
  {
    u32(static_cast<std::uint32_t>(text.size()));
    raw(text.data(), text.size());
  }

  void
  map(const Map& values)
  {
    std::size_t size = 0;
    for (const auto& [key, value] : values)
      size += 8 + key.size() + value.size();
    u32(static_cast<std::uint32_t>(size));
    for (const auto& [key, value] : values) {
      string(key);
      string(value);
    }
  }

  void
  map(const std::map<std::uint16_t, std::uint64_t>& values)
  {
    u32(static_cast<std::uint32_t>(10 * values.size()));
    for (const auto& [key, value] : values) {
      u16(key);
      u64(value);
    }
  }

private:
  void
  setLength(std::uint64_t length)
  {
    for (std::size_t i = 0; i < 8; ++i, length >>= 8)
      bytes_[begin_ - 8 + i] = static_cast<std::uint8_t>(length);
  }

  std::vector<std::uint8_t>& bytes_;
  std::size_t begin_ = 0;
};

/** \brief A reader of the array or map that follows, whose size stands before it. */
SpanReader
nestedReader(SpanReader& reader)
{
  const std::uint32_t size = reader.u32();
  const std::uint8_t* const begin = reader.take(size);
  return {begin, begin == nullptr ? 0 : size};
}

bool
readMap(SpanReader& reader, Map& values)
{
  values.clear();
  SpanReader entries = nestedReader(reader);
  while (entries.remaining() > 0) {
    std::string key = entries.string();
    std::string value = entries.string();
    values.emplace(std::move(key), std::move(value));
  }
  return !entries.failed();
}

bool
readMap(SpanReader& reader, std::map<std::uint16_t, std::uint64_t>& values)
{
  values.clear();
  SpanReader entries = nestedReader(reader);
  while (entries.remaining() > 0) {
    const std::uint16_t key = entries.u16();
    values.emplace(key, entries.u64());
  }
  return !entries.failed();
}

Time
timeOf(std::uint64_t nanoseconds)
{
  return Time(static_cast<std::int64_t>(nanoseconds));
}

std::uint64_t
nanosecondsOf(Time time)
{
  return static_cast<std::uint64_t>(time.count());
}

} // namespace

bool
parse(const std::uint8_t* bytes, std::size_t size, Header& header)
{
  SpanReader reader(bytes, size);
  header.profile = reader.string();
  header.library = reader.string();
  return !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, Footer& footer)
{
  SpanReader reader(bytes, size);
  footer.summary_start = reader.u64();
  footer.summary_offset_start = reader.u64();
  footer.summary_checksum = reader.u32();
  return !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, Schema& schema)
{
  SpanReader reader(bytes, size);
  schema.id = reader.u16();
  schema.content.name = reader.string();
  schema.content.encoding = reader.string();
  schema.content.text = reader.string();
  return !reader.failed() && schema.id != 0;
}

bool
parse(const std::uint8_t* bytes, std::size_t size, Channel& channel)
{
  SpanReader reader(bytes, size);
  channel.id = reader.u16();
  channel.schema_id = reader.u16();
  channel.content.topic = reader.string();
  channel.content.message_encoding = reader.string();
  return readMap(reader, channel.content.metadata) && !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, MessagePrefix& message)
{
  SpanReader reader(bytes, size);
  message.channel_id = reader.u16();
  message.sequence = reader.u32();
  message.log_time = reader.u64();
  message.publish_time = reader.u64();
  return !reader.failed();
}

bool
parse(const std::uint8_t* bytes,
      std::size_t size,
      Chunk& chunk,
      std::size_t& fields_size)
{
  SpanReader reader(bytes, size);
  chunk.start_time = reader.u64();
  chunk.end_time = reader.u64();
  chunk.uncompressed_size = reader.u64();
  chunk.uncompressed_checksum = reader.u32();
  chunk.compression = reader.string();
  chunk.records_size = reader.u64();
  fields_size = reader.position();
  return !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, MessageIndex& index)
{
  SpanReader reader(bytes, size);
  index.channel_id = reader.u16();
  index.entries.clear();
  SpanReader entries = nestedReader(reader);
  while (entries.remaining() > 0) {
    const std::uint64_t time = entries.u64();
    index.entries.emplace_back(time, entries.u64());
  }
  return !reader.failed() && !entries.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, ChunkIndex& index)
{
  SpanReader reader(bytes, size);
  index.start_time = reader.u64();
  index.end_time = reader.u64();
  index.chunk_offset = reader.u64();
  index.chunk_length = reader.u64();
  const bool has_offsets = readMap(reader, index.message_index_offsets);
  index.message_index_length = reader.u64();
  index.compression = reader.string();
  index.compressed_size = reader.u64();
  index.uncompressed_size = reader.u64();
  return has_offsets && !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, Statistics& statistics)
{
  SpanReader reader(bytes, size);
  statistics.messages = reader.u64();
  statistics.schemas = reader.u16();
  statistics.channels = reader.u32();
  statistics.attachments = reader.u32();
  statistics.metadata = reader.u32();
  statistics.chunks = reader.u32();
  statistics.start_time = reader.u64();
  statistics.end_time = reader.u64();
  return readMap(reader, statistics.channel_messages) && !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, McapMetadata& metadata)
{
  SpanReader reader(bytes, size);
  metadata.name = reader.string();
  return readMap(reader, metadata.values) && !reader.failed();
}

bool
parse(const std::uint8_t* bytes, std::size_t size, McapAttachment& attachment)
{
  SpanReader reader(bytes, size);
  attachment.log_time = timeOf(reader.u64());
  attachment.create_time = timeOf(reader.u64());
  attachment.name = reader.string();
  attachment.media_type = reader.string();
  const std::uint64_t data_size = reader.u64();
  const std::uint8_t* const data = reader.take(data_size);
  if (data == nullptr)
    return false;
  attachment.bytes.assign(data, data + data_size);
  const std::size_t checked_size = reader.position();
  const std::uint32_t checksum = reader.u32();
  return !reader.failed() &&
         (checksum == 0 || checksum == checksumOf(bytes, checked_size));
}

bool
parse(const std::uint8_t* bytes, std::size_t size, RecordExtent& extent)
{
  SpanReader reader(bytes, size);
  extent.offset = reader.u64();
  extent.length = reader.u64();
  return !reader.failed();
}

void
append(const Header& header, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Header, bytes);
  writer.string(header.profile);
  writer.string(header.library);
}

void
append(const Schema& schema, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Schema, bytes);
  writer.u16(schema.id);
  writer.string(schema.content.name);
  writer.string(schema.content.encoding);
  writer.string(schema.content.text);
}

void
append(const Channel& channel, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Channel, bytes);
  writer.u16(channel.id);
  writer.u16(channel.schema_id);
  writer.string(channel.content.topic);
  writer.string(channel.content.message_encoding);
  writer.map(channel.content.metadata);
}

void
append(const MessageIndex& index, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::MessageIndex, bytes);
  writer.u16(index.channel_id);
  writer.u32(static_cast<std::uint32_t>(16 * index.entries.size()));
  for (const auto& [time, offset] : index.entries) {
    writer.u64(time);
    writer.u64(offset);
  }
}

void
append(const ChunkIndex& index, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::ChunkIndex, bytes);
  writer.u64(index.start_time);
  writer.u64(index.end_time);
  writer.u64(index.chunk_offset);
  writer.u64(index.chunk_length);
  writer.map(index.message_index_offsets);
  writer.u64(index.message_index_length);
  writer.string(index.compression);
  writer.u64(index.compressed_size);
  writer.u64(index.uncompressed_size);
}

void
append(const Statistics& statistics, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Statistics, bytes);
  writer.u64(statistics.messages);
  writer.u16(statistics.schemas);
  writer.u32(statistics.channels);
  writer.u32(statistics.attachments);
  writer.u32(statistics.metadata);
  writer.u32(statistics.chunks);
  writer.u64(statistics.start_time);
  writer.u64(statistics.end_time);
  writer.map(statistics.channel_messages);
}

void
append(const McapMetadata& metadata, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Metadata, bytes);
  writer.string(metadata.name);
  writer.map(metadata.values);
}

void
append(const McapAttachment& attachment, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Attachment, bytes);
  const std::size_t begin = bytes.size();
  writer.u64(nanosecondsOf(attachment.log_time));
  writer.u64(nanosecondsOf(attachment.create_time));
  writer.string(attachment.name);
  writer.string(attachment.media_type);
  writer.u64(attachment.bytes.size());
  writer.raw(attachment.bytes.data(), attachment.bytes.size());
  writer.u32(checksumOf(bytes.data() + begin, bytes.size() - begin));
}

void
append(const MessagePrefix& prefix,
       const std::vector<std::uint8_t>& message,
       std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Message, bytes);
  writer.u16(prefix.channel_id);
  writer.u32(prefix.sequence);
  writer.u64(prefix.log_time);
  writer.u64(prefix.publish_time);
  writer.raw(message.data(), message.size());
}

void
appendChunkFields(const Chunk& chunk, std::vector<std::uint8_t>& bytes)
{
  const std::uint64_t fields_size = 28 + 4 + chunk.compression.size() + 8;
  io::ByteWriter writer(bytes);
  writer.u8(static_cast<std::uint8_t>(Opcode::Chunk));
  writer.u64(fields_size + chunk.records_size);
  writer.u64(chunk.start_time);
  writer.u64(chunk.end_time);
  writer.u64(chunk.uncompressed_size);
  writer.u32(chunk.uncompressed_checksum);
  writer.u32(static_cast<std::uint32_t>(chunk.compression.size()));
  writer.raw(chunk.compression.data(), chunk.compression.size());
  writer.u64(chunk.records_size);
}

void
appendMetadataIndex(const RecordExtent& extent,
                    const std::string& name,
                    std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::MetadataIndex, bytes);
  writer.u64(extent.offset);
  writer.u64(extent.length);
  writer.string(name);
}

void
appendAttachmentIndex(const RecordExtent& extent,
                      const McapAttachment& attachment_without_bytes,
                      std::uint64_t size,
                      std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::AttachmentIndex, bytes);
  writer.u64(extent.offset);
  writer.u64(extent.length);
  writer.u64(nanosecondsOf(attachment_without_bytes.log_time));
  writer.u64(nanosecondsOf(attachment_without_bytes.create_time));
  writer.u64(size);
  writer.string(attachment_without_bytes.name);
  writer.string(attachment_without_bytes.media_type);
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
  RecordWriter writer(Opcode::DataEnd, bytes);
  writer.u32(data_checksum);
}

void
appendFooter(const Footer& footer, std::vector<std::uint8_t>& bytes)
{
  RecordWriter writer(Opcode::Footer, bytes);
  writer.u64(footer.summary_start);
  writer.u64(footer.summary_offset_start);
  writer.u32(footer.summary_checksum);
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

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
