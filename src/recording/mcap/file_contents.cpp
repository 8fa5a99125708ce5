// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/channel_list.h"
#include "recording/mcap/mcap_file.h"
#include "recording/mcap/record_access.h"
#include "recording/mcap/summary.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

namespace {

/** \brief Collects the contents of a file, from its summary or from all of it. */
class ContentsFinder {
public:
  ContentsFinder(const InputFile& file,
                 const ChannelFilter& wants,
                 FileContents& contents)
  : file_(file), contents_(contents), channels_(wants)
  {
    contents_ = FileContents();
    contents_.sections.push_back({false, 0, file.size(), false});
  }

  /** \brief Hands the channels over, when all are known. */
  void
  finish()
  {
    if (channels_.hasTooMany())
      addDamage(0, "there are too many channels with too large schemas; some are lost");
    contents_.channels = channels_.takeAll();
  }

  /** \return false if there is no summary, or it does not tell of all messages */
  bool
  readSummary()
  {
    contents_.has_end = hasMcapEnd(file_);
    Summary summary;
    if (!contents_.has_end || !mcap::readSummary(file_, channels_, summary))
      return false;
    contents_.attachments = std::move(summary.attachments);
    contents_.metadata = std::move(summary.metadata);
    addIndexedChunks(summary.chunks);
    const Statistics& statistics = summary.statistics;
    std::uint64_t expected = 0;
    for (const auto& [id, count] : statistics.channel_messages)
      expected += channels_.isWanted(id) ? count : 0;
    if (statistics.channel_messages.empty() && statistics.messages > 0)
      expected = channels_.hasFilter() ? ~std::uint64_t{0} : statistics.messages;
    return expected == contents_.messages.size() || !contents_.damage.empty();
  }

  void
  scan()
  {
    for (std::uint64_t offset = magic.size(); offset != 0 && offset < file_.size();) {
      Opcode opcode{};
      std::uint64_t length = 0;
      if (!readRecordPrefix(file_, offset, opcode, length)) {
        addDamage(offset, "the file ends within a record");
        return;
      }
      if (static_cast<std::uint8_t>(opcode) == 0) {
        addDamage(offset, "there is no valid record; what follows is lost");
        return;
      }
      if (length > file_.size() - offset - record_prefix_size) {
        scanLastRecord(offset, opcode);
        return;
      }
      offset = scanRecord(offset, opcode, length);
    }
  }

private:
  bool
  hasWanted(const ChunkIndex& chunk)
  {
    // Without offsets the chunk has no message index.
    return chunk.message_index_offsets.empty() ||
           std::any_of(
               chunk.message_index_offsets.begin(),
               chunk.message_index_offsets.end(),
               [this](const auto& offset) { return channels_.isWanted(offset.first); });
  }

  /** \brief Adds the chunks in the order of the file. Chunks that overlap, which could be
   * read any number of times, are damage. */
  void
  addIndexedChunks(std::vector<ChunkIndex>& chunks)
  {
    std::sort(
        chunks.begin(), chunks.end(), [](const ChunkIndex& a, const ChunkIndex& b) {
          return a.chunk_offset < b.chunk_offset;
        });
    std::uint64_t end = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      const ChunkIndex& chunk = chunks[i];
      if (chunk.chunk_offset < end || chunk.chunk_offset > file_.size() ||
          chunk.chunk_length < record_prefix_size ||
          chunk.chunk_length > file_.size() - chunk.chunk_offset) {
        addDamage(chunk.chunk_offset,
                  "a chunk overlaps another, or is outside of the file; it is lost");
        continue;
      }
      end = chunk.chunk_offset + chunk.chunk_length;
      addIndexedChunk(
          chunk, i + 1 < chunks.size() ? chunks[i + 1].chunk_offset : file_.size());
    }
  }

  void
  addIndexedChunk(const ChunkIndex& chunk, std::uint64_t next_chunk)
  {
    if (!hasWanted(chunk))
      return;
    const std::size_t section = contents_.sections.size();
    contents_.sections.push_back({true, chunk.chunk_offset, chunk.chunk_length, false});
    const std::size_t messages = contents_.messages.size();
    if (!chunk.message_index_offsets.empty() &&
        addByMessageIndex(chunk, next_chunk, section))
      return;
    contents_.messages.resize(messages);
    addByRecords(section);
  }

  /** \brief Adds the messages that the indexes after a chunk list. They end before the
   * next chunk, so that no bytes are read for several chunks.
   * \return false if they are invalid
   */
  bool
  addByMessageIndex(const ChunkIndex& chunk,
                    std::uint64_t next_chunk,
                    std::size_t section)
  {
    const std::uint64_t begin = chunk.chunk_offset + chunk.chunk_length;
    if (begin > next_chunk || chunk.message_index_length > next_chunk - begin)
      return false;
    buffer_.resize(static_cast<std::size_t>(chunk.message_index_length));
    if (!file_.read(begin, buffer_.size(), buffer_.data()))
      return false;
    SpanReader reader(buffer_.data(), buffer_.size());
    MessageIndex index;
    std::vector<std::uint64_t> offsets;
    Record record;
    while (takeRecord(reader, record)) {
      if (record.opcode != Opcode::MessageIndex ||
          !parse(record.content, record.size, index) ||
          chunk.message_index_offsets.count(index.channel_id) == 0)
        return false;
      if (!channels_.isWanted(index.channel_id))
        continue;
      for (const auto& [time, offset] : index.entries) {
        if (time < chunk.start_time || time > chunk.end_time ||
            offset >= chunk.uncompressed_size)
          return false;
        contents_.messages.push_back({time, section, offset, index.channel_id});
        offsets.push_back(offset);
      }
    }
    std::sort(offsets.begin(), offsets.end());
    return !reader.failed() &&
           std::adjacent_find(offsets.begin(), offsets.end()) == offsets.end();
  }

  /** \brief Adds the messages of a chunk by reading all of it. */
  void
  addByRecords(std::size_t section)
  {
    std::vector<std::uint8_t> records;
    const std::string failure = loadChunk(file_, contents_.sections[section], records);
    if (!failure.empty())
      addDamage(contents_.sections[section].offset, "a chunk: " + failure);
    scanRecords(records, section);
  }

  void
  scanRecords(const std::vector<std::uint8_t>& records, std::size_t section)
  {
    SpanReader reader(records.data(), records.size());
    Record record;
    for (std::size_t offset = 0; takeRecord(reader, record);
         offset = reader.position()) {
      const auto& [opcode, content, size] = record;
      if (opcode == Opcode::Schema)
        channels_.addSchema(content, size);
      else if (opcode == Opcode::Channel)
        channels_.addChannel(content, size);
      else if (opcode == Opcode::Message)
        addMessage(content, size, section, offset);
    }
  }

  void
  addMessage(const std::uint8_t* content,
             std::size_t size,
             std::size_t section,
             std::uint64_t offset)
  {
    MessagePrefix message;
    if (!parse(content, size, message) || !channels_.isWanted(message.channel_id))
      return;
    if (contents_.messages.size() < mostMessages(file_.size()))
      contents_.messages.push_back(
          {message.log_time, section, offset, message.channel_id});
    else if (!has_too_many_messages_) {
      has_too_many_messages_ = true;
      addDamage(contents_.sections[section].offset,
                "there are more messages than a file of this size may have; those that "
                "follow are lost");
    }
  }

  /** \brief Adds what a whole record of the file tells.
   * \return where the next record begins; 0 after the last one
   */
  std::uint64_t
  scanRecord(std::uint64_t offset, Opcode opcode, std::uint64_t length)
  {
    const std::uint64_t end = offset + record_prefix_size + length;
    if (endsData(opcode, length)) {
      scanEnd(end);
      return 0;
    }
    if (length > max_record_bytes) {
      addDamage(offset, "a record: " + largerThan(max_record_bytes) + "; it is lost");
      return end;
    }
    if (opcode == Opcode::Chunk) {
      contents_.sections.push_back({true, offset, end - offset, false});
      addByRecords(contents_.sections.size() - 1);
      return end;
    }
    if (opcode == Opcode::Attachment || opcode == Opcode::Metadata)
      (opcode == Opcode::Metadata ? contents_.metadata : contents_.attachments)
          .push_back({offset, end - offset});
    else if (opcode == Opcode::DataEnd || opcode == Opcode::Footer)
      addDamage(offset, "a record cannot be read");
    else if (opcode == Opcode::Message) {
      buffer_.resize(message_prefix_size - record_prefix_size);
      if (length >= buffer_.size() &&
          file_.read(offset + record_prefix_size, buffer_.size(), buffer_.data()))
        addMessage(buffer_.data(), buffer_.size(), 0, offset);
    }
    else if (opcode == Opcode::Header || opcode == Opcode::Schema ||
             opcode == Opcode::Channel) {
      Header header;
      if (!readRecord(file_, offset, opcode, buffer_))
        addDamage(offset, "a record cannot be read");
      else if (opcode == Opcode::Schema)
        channels_.addSchema(buffer_.data(), buffer_.size());
      else if (opcode == Opcode::Channel)
        channels_.addChannel(buffer_.data(), buffer_.size());
      else if (parse(buffer_.data(), buffer_.size(), header))
        contents_.profile = header.profile;
    }
    return end;
  }

  /** \brief Looks for what follows the file, from the end of its data on. */
  void
  scanEnd(std::uint64_t offset)
  {
    constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
    BytesAfterEnd after;
    while (offset < file_.size()) {
      buffer_.resize(
          static_cast<std::size_t>(std::min(piece_bytes, file_.size() - offset)));
      if (!file_.read(offset, buffer_.size(), buffer_.data()))
        break;
      after.add(buffer_.data(), buffer_.size());
      offset += buffer_.size();
    }
    if (after.count() > 0)
      addDamage(file_.size() - after.count(), after.describe());
  }

  /** \brief Adds what can be read of a record whose end is missing. */
  void
  scanLastRecord(std::uint64_t offset, Opcode opcode)
  {
    addDamage(offset,
              "the file ends within a record, or the record's length is wrong; what "
              "follows is lost");
    if (opcode != Opcode::Chunk)
      return;
    contents_.sections.push_back({true, offset, file_.size() - offset, true});
    std::vector<std::uint8_t> records;
    loadChunk(file_, contents_.sections.back(), records);
    scanRecords(records, contents_.sections.size() - 1);
  }

  void
  addDamage(std::uint64_t offset, const std::string& message)
  {
    contents_.addDamage({offset, message, file_.path()});
  }

  const InputFile& file_;
  FileContents& contents_;
  ChannelList channels_;
  std::vector<std::uint8_t> buffer_;
  bool has_too_many_messages_ = false;
};

} // namespace

bool
isMcapFile(const InputFile& file)
{
  return hasMagic(file, 0) || hasMcapEnd(file);
}

RecordingStatus
McapFile::findContents(const ChannelFilter& wants, FileContents& contents)
{
  const InputFile& file = this->file();
  if (!isMcapFile(file))
    return {RecordingCode::NotARecording, "'" + file.path() + "' is not an MCAP file"};
  if (ContentsFinder finder(file, wants, contents); finder.readSummary()) {
    finder.finish();
    if (!hasMagic(file, 0))
      contents.damage.push_back(
          {0, "the file does not begin as MCAP files do", file.path()});
    // The summary has no header.
    std::vector<std::uint8_t> content;
    Header header;
    if (readRecord(file, magic.size(), Opcode::Header, content) &&
        parse(content.data(), content.size(), header))
      contents.profile = header.profile;
    return {};
  }
  const bool has_end = contents.has_end;
  ContentsFinder finder(file, wants, contents);
  finder.scan();
  finder.finish();
  contents.has_end = has_end;
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
