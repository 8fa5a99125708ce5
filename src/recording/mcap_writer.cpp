// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap_writer.h"

#include <pcl_ext/version.h>

#include "recording/files.h"
#include "recording/guarded.h"
#include "recording/mcap/chunk_builder.h"
#include "recording/mcap/records.h"
#include "recording/output_paths.h"
#include "recording/rosbag2_folder.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

constexpr char library_name[] = "pcl_ext " PCL_EXT_VERSION_TEXT;

std::uint64_t
nanosecondsOf(Time time)
{
  return static_cast<std::uint64_t>(time.count());
}

struct WrittenChannel {
  mcap::Channel record;
  std::uint64_t messages = 0;
  bool has_own_chunks = false;
  mcap::ChunkBuilder chunk; // with own chunks
};

} // namespace

class McapWriter::Implementation {
public:
  ~Implementation()
  {
    if (!is_finished_)
      guarded([this] { return flush(); });
    std::error_code ignored;
    if (!is_finished_ && chunks_.empty() && !paths_.unfinished.empty()) {
      file_ = OutputFile(); // Windows removes no open file
      fs::remove_all(paths_.unfinished, ignored);
    }
  }

  RecordingStatus
  open(const std::string& path, const std::string& profile)
  {
    paths_ = OutputPaths(path);
    std::error_code ignored;
    if (!paths_.is_folder && fs::is_directory(paths_.final, ignored))
      return status_ = {RecordingCode::OutputFailed, "'" + path + "' is a folder"};
    if (paths_.is_folder)
      status_ = createFolder();
    else if (!paths_.unfinished.empty())
      status_ = setAsideUnfinished(paths_.unfinished, paths_.file);
    if (!status_.ok() || !(status_ = file_.open(paths_.file)).ok())
      return status_;
    is_finished_ = false;
    bytes_.assign(mcap::magic.begin(), mcap::magic.end());
    mcap::append(mcap::Header{profile, library_name}, bytes_);
    return keep(writeBytes());
  }

  RecordingStatus
  addChannel(const McapChannel& channel, McapChunking chunking, std::size_t& number)
  {
    if (!status_.ok())
      return status_;
    if (channels_.size() == std::numeric_limits<std::uint16_t>::max())
      return {RecordingCode::InvalidArgument, "more than 65535 channels"};
    WrittenChannel written;
    written.record.id = static_cast<std::uint16_t>(channels_.size());
    written.record.schema_id = schemaId(channel.schema);
    written.record.content = channel;
    written.has_own_chunks = chunking == McapChunking::OwnStream;
    mcap::append(written.record, bytes_);
    number = channels_.size();
    channels_.push_back(std::move(written));
    return keep(writeBytes());
  }

  RecordingStatus
  write(const McapMessage& message, bool may_begin_chunk)
  {
    if (!status_.ok())
      return status_;
    if (message.channel >= channels_.size())
      return {RecordingCode::InvalidArgument, "a message of an unknown channel"};
    WrittenChannel& channel = channels_[message.channel];
    mcap::ChunkBuilder& chunk = channel.has_own_chunks ? channel.chunk : shared_chunk_;
    const bool is_complete =
        channel.has_own_chunks ? (may_begin_chunk && chunk.size() >= own_chunk_bytes) ||
                                     chunk.size() >= max_own_chunk_bytes
                               : chunk.size() >= shared_chunk_bytes;
    if (is_complete)
      if (RecordingStatus status = writeChunk(chunk, !channel.has_own_chunks);
          !status.ok())
        return status;
    const std::uint64_t time = nanosecondsOf(message.log_time);
    at_hand_ -= chunk.size();
    chunk.add({channel.record.id,
               message.sequence,
               time,
               nanosecondsOf(message.publish_time)},
              message.bytes);
    at_hand_ += chunk.size();
    const bool is_first = statistics_.messages == 0;
    statistics_.start_time = is_first ? time : std::min(statistics_.start_time, time);
    statistics_.end_time = is_first ? time : std::max(statistics_.end_time, time);
    ++statistics_.messages;
    ++channel.messages;
    return {};
  }

  RecordingStatus
  write(const McapMetadata& metadata)
  {
    if (!status_.ok())
      return status_;
    const std::uint64_t offset = file_.position();
    mcap::append(metadata, bytes_);
    mcap::appendMetadataIndex(
        {offset, bytes_.size()}, metadata.name, metadata_indexes_);
    ++statistics_.metadata;
    return keep(writeBytes());
  }

  RecordingStatus
  write(const McapAttachment& attachment)
  {
    if (!status_.ok())
      return status_;
    const std::uint64_t offset = file_.position();
    mcap::append(attachment, bytes_);
    mcap::appendAttachmentIndex({offset, bytes_.size()},
                                attachment,
                                attachment.bytes.size(),
                                attachment_indexes_);
    ++statistics_.attachments;
    return keep(writeBytes());
  }

  RecordingStatus
  flush()
  {
    if (!status_.ok())
      return status_;
    RecordingStatus status = writeChunk(shared_chunk_, true);
    for (WrittenChannel& channel : channels_)
      if (status.ok())
        status = writeChunk(channel.chunk, false);
    return status;
  }

  std::uint64_t
  bytes() const
  {
    return file_.position() + at_hand_;
  }

  RecordingStatus
  finish(ExistingFile existing)
  {
    if (RecordingStatus status = flush(); !status.ok())
      return status;
    statistics_.schemas = static_cast<std::uint16_t>(schemas_.size());
    statistics_.channels = static_cast<std::uint32_t>(channels_.size());
    statistics_.chunks = static_cast<std::uint32_t>(chunks_.size());
    for (const WrittenChannel& channel : channels_)
      if (channel.messages > 0)
        statistics_.channel_messages[channel.record.id] = channel.messages;
    mcap::appendDataEnd(checksum_, bytes_);
    appendSummary(file_.position() + bytes_.size());
    bytes_.insert(bytes_.end(), mcap::magic.begin(), mcap::magic.end());
    RecordingStatus status = keep(writeBytes());
    if (status.ok())
      status = keep(file_.close());
    if (status.ok())
      status = keep(nameFile(existing));
    is_finished_ |= status.ok();
    if (status.ok())
      status_ = {RecordingCode::OutputFailed, "the file is finished"};
    return status;
  }

private:
  RecordingStatus
  createFolder()
  {
    std::error_code error;
    if (fs::exists(paths_.final, error))
      return {RecordingCode::OutputFailed,
              "'" + paths_.final +
                  "' exists; a bag is not written into a folder that exists"};
    if (RecordingStatus status = setAsideUnfinished(paths_.unfinished, paths_.file);
        !status.ok())
      return status;
    error.clear();
    fs::create_directories(paths_.unfinished, error);
    return error ? RecordingStatus{RecordingCode::OutputFailed,
                                   "cannot create '" + paths_.unfinished +
                                       "': " + error.message()}
                 : RecordingStatus();
  }

  RecordingStatus
  writeBytes()
  {
    checksum_ = mcap::checksumOf(bytes_.data(), bytes_.size(), checksum_);
    RecordingStatus status = file_.write(bytes_.data(), bytes_.size());
    bytes_.clear();
    return status;
  }

  RecordingStatus
  writeChunk(mcap::ChunkBuilder& chunk, bool is_compressed)
  {
    if (chunk.size() == 0)
      return {};
    at_hand_ -= chunk.size();
    chunks_.push_back(chunk.take(is_compressed, file_.position(), bytes_));
    return keep(writeBytes());
  }

  /** \brief The id of a schema, which is written if it is new. */
  std::uint16_t
  schemaId(const McapSchema& schema)
  {
    if (schema.name.empty() && schema.encoding.empty() && schema.text.empty())
      return 0;
    for (const mcap::Schema& known : schemas_)
      if (known.content.name == schema.name &&
          known.content.encoding == schema.encoding &&
          known.content.text == schema.text)
        return known.id;
    const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
    schemas_.push_back({id, schema});
    mcap::append(schemas_.back(), bytes_);
    return id;
  }

  /** \brief Appends the summary, in groups of records of the same kind, and where these
   * are. */
  void
  appendSummary(std::uint64_t summary_start)
  {
    std::vector<std::uint8_t> offsets;
    std::size_t group_begin = bytes_.size();
    const std::size_t begin = group_begin;
    const auto end_group = [&](mcap::Opcode opcode) {
      if (bytes_.size() > group_begin)
        mcap::appendSummaryOffset(opcode,
                                  summary_start + (group_begin - begin),
                                  bytes_.size() - group_begin,
                                  offsets);
      group_begin = bytes_.size();
    };
    for (const mcap::Schema& schema : schemas_)
      mcap::append(schema, bytes_);
    end_group(mcap::Opcode::Schema);
    for (const WrittenChannel& channel : channels_)
      mcap::append(channel.record, bytes_);
    end_group(mcap::Opcode::Channel);
    mcap::append(statistics_, bytes_);
    end_group(mcap::Opcode::Statistics);
    for (const mcap::ChunkIndex& chunk : chunks_)
      mcap::append(chunk, bytes_);
    end_group(mcap::Opcode::ChunkIndex);
    bytes_.insert(bytes_.end(), attachment_indexes_.begin(), attachment_indexes_.end());
    end_group(mcap::Opcode::AttachmentIndex);
    bytes_.insert(bytes_.end(), metadata_indexes_.begin(), metadata_indexes_.end());
    end_group(mcap::Opcode::MetadataIndex);
    const std::uint64_t offsets_start = summary_start + (bytes_.size() - begin);
    bytes_.insert(bytes_.end(), offsets.begin(), offsets.end());
    mcap::appendFooter({summary_start, offsets_start, 0}, bytes_);
    constexpr std::size_t checksum_size = 4;
    std::uint32_t checksum =
        mcap::checksumOf(bytes_.data() + begin, bytes_.size() - begin - checksum_size);
    for (std::size_t i = 0; i < checksum_size; ++i, checksum >>= 8)
      bytes_[bytes_.size() - checksum_size + i] = static_cast<std::uint8_t>(checksum);
  }

  RecordingStatus
  nameFile(ExistingFile existing)
  {
    if (paths_.final.empty())
      return {};
    if (paths_.is_folder) {
      std::vector<Rosbag2Topic> topics;
      for (const WrittenChannel& channel : channels_)
        topics.push_back({&channel.record.content, channel.messages});
      const RecordingStatus status =
          writeRosbag2Metadata(paths_.unfinished,
                               paths_.file_name,
                               topics,
                               Time(static_cast<std::int64_t>(statistics_.start_time)),
                               Time(static_cast<std::int64_t>(statistics_.end_time)));
      if (!status.ok())
        return status;
    }
    return renameFile(paths_.unfinished, paths_.final, existing);
  }

  /** \brief Keeps the first failure, which all later calls return. */
  RecordingStatus
  keep(const RecordingStatus& status)
  {
    if (status_.ok() && !status.ok())
      status_ = status;
    return status;
  }

  OutputPaths paths_{standard_stream};
  OutputFile file_;
  RecordingStatus status_{RecordingCode::OutputFailed, "no file is open"};
  bool is_finished_ = true;
  std::vector<std::uint8_t> bytes_; // to be written
  std::uint32_t checksum_ = 0;      // of all bytes before the end of the data
  std::vector<mcap::Schema> schemas_;
  std::vector<WrittenChannel> channels_;
  mcap::ChunkBuilder shared_chunk_;
  std::uint64_t at_hand_ = 0; // bytes of all chunks that are not written
  std::vector<mcap::ChunkIndex> chunks_;
  std::vector<std::uint8_t> attachment_indexes_;
  std::vector<std::uint8_t> metadata_indexes_;
  mcap::Statistics statistics_;
};

McapWriter::McapWriter() : implementation_(new Implementation) {}
McapWriter::~McapWriter() = default;
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter&
McapWriter::operator=(McapWriter&&) noexcept = default;

RecordingStatus
McapWriter::open(const std::string& path, const std::string& profile)
{
  return guarded([&] {
    implementation_ = std::make_unique<Implementation>();
    return implementation_->open(path, profile);
  });
}

RecordingStatus
McapWriter::addChannel(const McapChannel& channel,
                       McapChunking chunking,
                       std::size_t& number)
{
  return guarded(
      [&] { return implementation_->addChannel(channel, chunking, number); });
}

RecordingStatus
McapWriter::write(const McapMessage& message, bool may_begin_chunk)
{
  return guarded([&] { return implementation_->write(message, may_begin_chunk); });
}

RecordingStatus
McapWriter::write(const McapMetadata& metadata)
{
  return guarded([&] { return implementation_->write(metadata); });
}

RecordingStatus
McapWriter::write(const McapAttachment& attachment)
{
  return guarded([&] { return implementation_->write(attachment); });
}

RecordingStatus
McapWriter::flush()
{
  return guarded([&] { return implementation_->flush(); });
}

std::uint64_t
McapWriter::bytes() const
{
  return implementation_->bytes();
}

RecordingStatus
McapWriter::finish(ExistingFile existing)
{
  return guarded([&] { return implementation_->finish(existing); });
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
