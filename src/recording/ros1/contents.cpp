// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/ros1/records.h"
#include "recording/ros1/ros1_file.h"
#include "recording/span_reader.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::ros1 {

namespace {

/** \brief Bytes of chunks that are read in all to find messages: so many, and so many
 * for each byte of the file. */
constexpr std::uint64_t least_scanned_bytes = std::uint64_t{1} << 28;
constexpr std::uint64_t scanned_ratio = 300; // more than that of lz4

constexpr std::size_t index_entry_size = 12;

class ContentsFinder {
public:
  ContentsFinder(const InputFile& file,
                 const ChannelFilter& wants,
                 Connections& connections,
                 FileContents& contents)
  : file_(file), wants_(wants), connections_(connections), contents_(contents)
  {
    contents_.profile = "ros1";
    contents_.sections.push_back({false, 0, file.size(), false});
  }

  RecordingStatus
  find()
  {
    if (RecordingStatus status = readBagHeader(); !status.ok())
      return status;
    const bool has_index = readIndexSection();
    readRecords(first_line_size, has_index ? index_begin_ : file_.size());
    chunk_.is_valid &= has_index; // else some may be missing
    finishChunk();
    if (connections_.hasTooMany())
      addDamage(0,
                "there are too many connections with too large definitions; some are "
                "lost");
    if (without_connection_ > 0)
      addDamage(0,
                std::to_string(without_connection_) +
                    " messages are of connections that the bag does not name; they are "
                    "lost");
    contents_.channels = connections_.channels();
    contents_.has_end = has_index;
    return {};
  }

private:
  /** \brief A message as an index or its record has it. */
  struct FoundMessage {
    std::uint32_t connection;
    std::uint64_t time;
    std::uint64_t offset;
  };

  /** \brief A chunk whose indexes are being read. */
  struct OpenChunk {
    std::size_t section = 0; // 0: there is none
    std::uint64_t size = 0;  // uncompressed
    std::vector<FoundMessage> indexed;
    bool is_valid = true; // of the indexes
  };

  RecordingStatus
  readBagHeader()
  {
    std::array<char, first_line_size> line{};
    file_.read(0, line.size(), reinterpret_cast<std::uint8_t*>(line.data()));
    if (!std::equal(line.begin(), line.end(), first_line))
      return {RecordingCode::NotARecording,
              "'" + file_.path() +
                  "' is no bag of ROS 1's format 2.0: 'rosbag filter' copies bags of "
                  "earlier formats into new ones"};
    std::string encryptor;
    if (!record_.read(file_, first_line_size) ||
        record_.fields().op() != Op::BagHeader) {
      addDamage(first_line_size, "the bag has no header");
      return {};
    }
    if (record_.fields().find("encryptor", encryptor) && !encryptor.empty())
      return {RecordingCode::NotARecording,
              "'" + file_.path() + "' is encrypted (" + encryptor.substr(0, 80) +
                  "): copy it with 'rosbag decrypt' first"};
    // 0 while the bag is recorded.
    const std::uint64_t index = record_.fields().number("index_pos", 8).value_or(0);
    index_begin_ = index > first_line_size && index <= file_.size() ? index : 0;
    if (index_begin_ == 0 && index != 0)
      addDamage(first_line_size, "the bag ends before its index");
    return {};
  }

  /** \brief Reads connections and places of chunks, which the recorder writes last.
   * \return false if they are not all there; then the whole file is read for them
   */
  bool
  readIndexSection()
  {
    if (index_begin_ == 0)
      return false;
    for (std::uint64_t offset = index_begin_; offset < file_.size();
         offset = record_.end()) {
      const bool is_read = record_.read(file_, offset) && record_.end() <= file_.size();
      const std::optional<Op> op = is_read ? record_.fields().op() : std::nullopt;
      if (op == Op::Connection)
        addConnection(offset);
      else if (op == Op::ChunkInfo)
        chunks_.push_back(record_.fields().number("chunk_pos", 8).value_or(0));
      else {
        addDamage(offset, "the index of the bag is not whole");
        chunks_.clear();
        return false;
      }
    }
    std::sort(chunks_.begin(), chunks_.end());
    return true;
  }

  /** \brief Reads records one after the other. After damage those from the next chunk on
   * are read, if its place is known. */
  void
  readRecords(std::uint64_t begin, std::uint64_t end)
  {
    for (std::uint64_t offset = begin; offset < end;) {
      const std::uint64_t limit = limitAfter(offset, end);
      if (const std::uint64_t next = readRecord(offset, limit); next > 0) {
        offset = next;
        continue;
      }
      addDamage(offset,
                limit < file_.size()
                    ? "there is no valid record; what follows is lost up to byte " +
                          std::to_string(limit)
                    : "the file ends within a record, or the record's length is wrong; "
                      "what follows is lost");
      chunk_.is_valid = false; // indexes may be missing
      finishChunk();
      offset = limit;
    }
  }

  /** \brief Where the next chunk begins, or the end. */
  std::uint64_t
  limitAfter(std::uint64_t offset, std::uint64_t end) const
  {
    const auto next = std::upper_bound(chunks_.begin(), chunks_.end(), offset);
    return next == chunks_.end() ? end : std::min(*next, end);
  }

  /** \return where the next one begins; 0 if there is none that ends before the limit */
  std::uint64_t
  readRecord(std::uint64_t offset, std::uint64_t limit)
  {
    if (!record_.read(file_, offset))
      return 0;
    const std::optional<Op> op = record_.fields().op();
    if (op == Op::Chunk)
      return beginChunk(offset, limit);
    const std::uint64_t end = record_.end();
    if (!op || end > limit)
      return 0;
    if (op == Op::Index) {
      readIndex();
      return end;
    }
    finishChunk();
    if (op == Op::Connection)
      addConnection(offset);
    else if (op == Op::Message)
      addFileMessage(offset);
    return end;
  }

  /** \brief Begins a chunk. The sizes of the last one of a bag that was cut off are 0, and
   * its records, if they are not compressed, are read as those of the file.
   * \return where the next record begins; 0 if the chunk is cut off
   */
  std::uint64_t
  beginChunk(std::uint64_t offset, std::uint64_t limit)
  {
    finishChunk();
    std::string compression;
    record_.fields().find("compression", compression);
    const bool is_unfinished =
        record_.dataSize() == 0 && record_.end() < limit && isCompressed(compression);
    if (record_.dataSize() == 0 && !is_unfinished)
      return record_.end();
    const bool is_cut_off = is_unfinished || record_.end() > limit;
    const std::uint64_t end = is_cut_off ? limit : record_.end();
    contents_.sections.push_back({true, offset, end - offset, is_cut_off});
    const std::size_t section = contents_.sections.size() - 1;
    if (is_unfinished) {
      scanChunk(section, false);
      return end;
    }
    chunk_.section = section;
    chunk_.size = record_.fields().number("size", 4).value_or(0);
    return is_cut_off ? 0 : end;
  }

  void
  readIndex()
  {
    const std::optional<std::uint32_t> connection = record_.fields().connection();
    const std::uint64_t count = record_.fields().number("count", 4).value_or(0);
    chunk_.is_valid &= connection && record_.fields().number("ver", 4) == 1 &&
                       count * index_entry_size == record_.dataSize();
    if (chunk_.section == 0 || !chunk_.is_valid)
      return;
    buffer_.resize(static_cast<std::size_t>(record_.dataSize()));
    chunk_.is_valid = file_.read(record_.data(), buffer_.size(), buffer_.data());
    SpanReader entries(buffer_.data(), buffer_.size());
    while (chunk_.is_valid && entries.remaining() > 0) {
      const std::uint64_t time = nanosecondsOf(entries.u64());
      chunk_.indexed.push_back({*connection, time, entries.u32()});
    }
  }

  /** \brief Adds the messages of the chunk that was read last, now that its indexes are
   * known. */
  void
  finishChunk()
  {
    OpenChunk chunk = std::exchange(chunk_, OpenChunk());
    if (chunk.section == 0)
      return;
    if (!isIndexComplete(chunk))
      scanChunk(chunk.section, contents_.sections[chunk.section].is_cut_off);
    else
      for (const FoundMessage& message : chunk.indexed)
        addMessage(message, chunk.section);
  }

  /** \brief True if the indexes of a chunk may be right: they are there, and have
   * different places in the chunk for messages of connections that are known. */
  bool
  isIndexComplete(OpenChunk& chunk) const
  {
    std::vector<FoundMessage>& indexed = chunk.indexed;
    if (!chunk.is_valid || indexed.empty() ||
        contents_.sections[chunk.section].is_cut_off)
      return false;
    std::sort(indexed.begin(),
              indexed.end(),
              [](const FoundMessage& a, const FoundMessage& b) {
                return a.offset < b.offset;
              });
    return indexed.back().offset < chunk.size &&
           std::adjacent_find(indexed.begin(),
                              indexed.end(),
                              [](const FoundMessage& a, const FoundMessage& b) {
                                return a.offset == b.offset;
                              }) == indexed.end() &&
           std::all_of(
               indexed.begin(), indexed.end(), [this](const FoundMessage& message) {
                 return connections_.channelOf(message.connection).has_value();
               });
  }

  /** \brief Adds the connections and messages of a chunk by reading all of it. */
  void
  scanChunk(std::size_t section, bool is_damage_known)
  {
    const Section& place = contents_.sections[section];
    if (scanned_bytes_ > least_scanned_bytes + scanned_ratio * file_.size()) {
      addDamage(place.offset,
                "the chunks without an index are larger than a file of this size may "
                "have; the messages of this one are lost");
      return;
    }
    const std::string failure = loadChunk(file_, place, buffer_);
    scanned_bytes_ += buffer_.size();
    if (!failure.empty() && !place.is_cut_off)
      buffer_.clear();
    if (!failure.empty() && !is_damage_known)
      addDamage(place.offset, "a chunk: " + failure);
    SpanReader reader(buffer_.data(), buffer_.size());
    Record record;
    std::size_t offset = 0;
    for (; takeRecord(reader, record); offset = reader.position()) {
      const std::optional<Op> op = record.fields.op();
      const std::optional<std::uint32_t> connection = record.fields.connection();
      if (op == Op::Connection)
        connections_.add(record.fields, {record.data, record.size});
      else if (op == Op::Message && connection)
        addMessage({*connection,
                    nanosecondsOf(record.fields.number("time", 8).value_or(0)),
                    offset},
                   section);
    }
    if (failure.empty() && !is_damage_known && offset < buffer_.size())
      addDamage(place.offset,
                "a chunk: a record in it is not whole; what follows is lost");
  }

  /** \brief Adds the connection of the record at an offset, which was read. */
  void
  addConnection(std::uint64_t offset)
  {
    bool is_valid = record_.dataSize() <= max_chunk_bytes &&
                    record_.dataSize() <= file_.size() - record_.data();
    if (is_valid) {
      buffer_.resize(static_cast<std::size_t>(record_.dataSize()));
      is_valid = file_.read(record_.data(), buffer_.size(), buffer_.data()) &&
                 connections_.add(record_.fields(), {buffer_.data(), buffer_.size()});
    }
    if (!is_valid)
      addDamage(offset, "a connection cannot be read");
  }

  /** \brief Adds a message outside of chunks, as in one that was not completed. */
  void
  addFileMessage(std::uint64_t offset)
  {
    if (const std::optional<std::uint32_t> connection = record_.fields().connection())
      addMessage({*connection,
                  nanosecondsOf(record_.fields().number("time", 8).value_or(0)),
                  offset},
                 0);
  }

  void
  addMessage(const FoundMessage& message, std::size_t section)
  {
    const std::optional<std::uint16_t> channel =
        connections_.channelOf(message.connection);
    if (!channel) {
      ++without_connection_;
      return;
    }
    const auto [wanted, is_new] = wanted_.emplace(*channel, true);
    if (is_new && wants_)
      wanted->second = wants_(connections_.channels().at(*channel));
    if (!wanted->second)
      return;
    if (contents_.messages.size() < mostMessages(file_.size()))
      contents_.messages.push_back({message.time, section, message.offset, *channel});
    else if (!std::exchange(has_too_many_messages_, true))
      addDamage(contents_.sections[section].offset,
                "there are more messages than a file of this size may have; those that "
                "follow are lost");
  }

  void
  addDamage(std::uint64_t offset, const std::string& message)
  {
    contents_.addDamage({offset, message, file_.path()});
  }

  const InputFile& file_;
  const ChannelFilter& wants_;
  Connections& connections_;
  FileContents& contents_;
  FileRecord record_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t index_begin_ = 0;     // of the section of connections; 0: there is none
  std::vector<std::uint64_t> chunks_; // where that says that chunks begin, ascending
  std::map<std::uint16_t, bool> wanted_; // by channel
  OpenChunk chunk_;
  std::uint64_t scanned_bytes_ = 0;
  std::uint64_t without_connection_ = 0;
  bool has_too_many_messages_ = false;
};

} // namespace

RecordingStatus
Ros1File::findContents(const ChannelFilter& wants, FileContents& contents)
{
  return ContentsFinder(file(), wants, connections_, contents).find();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::ros1
