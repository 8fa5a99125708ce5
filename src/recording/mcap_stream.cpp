// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap_stream.h"

#include "recording/compressed_input.h"
#include "recording/mcap/channel_list.h"
#include "recording/mcap/record_access.h"
#include "recording/mcap/records.h"
#include "recording/span_reader.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

using mcap::Opcode;

McapStream::McapStream(ReadSome read, std::string name)
: read_(std::move(read)), name_(std::move(name)), list_(wants_)
{}

/** \brief Reads bytes to the end of the record, as they come, or skips them.
 * \return their number, less than asked for at the end of the file
 */
std::uint64_t
McapStream::readBytes(std::uint64_t count, bool is_kept)
{
  constexpr std::uint64_t piece_bytes = std::uint64_t{1} << 20;
  const std::size_t begin = record_.size();
  std::uint64_t done = 0;
  while (done < count) {
    const auto piece = static_cast<std::size_t>(std::min(count - done, piece_bytes));
    const std::size_t end = begin + (is_kept ? static_cast<std::size_t>(done) : 0);
    record_.resize(end + piece);
    const std::size_t read = read_(record_.data() + end, piece);
    record_.resize(is_kept ? end + read : begin);
    if (read == 0)
      break;
    done += read;
  }
  position_ += done;
  return done;
}

/** \brief Reads the next record, unless it is too large.
 * \return false at the end of the records
 */
bool
McapStream::readRecord()
{
  offset_ = position_;
  record_.clear();
  if (const std::uint64_t size = readBytes(mcap::record_prefix_size, true);
      size < mcap::record_prefix_size) {
    addDamage(size == 0 ? "the file has no end: its recorder did not complete it"
                        : "the file ends within a record");
    return false;
  }
  SpanReader prefix(record_.data(), record_.size());
  const auto opcode = static_cast<Opcode>(prefix.u8());
  const std::uint64_t length = prefix.u64();
  if (static_cast<std::uint8_t>(opcode) == 0) {
    addDamage("there is no valid record; what follows is lost");
    return false;
  }
  const bool is_too_large = length > max_record_bytes;
  if (readBytes(length, !is_too_large) < length) {
    addDamage("the file ends within a record, or the record's length is wrong; what "
              "follows is lost");
    return false;
  }
  if (is_too_large) {
    addDamage("a record: " + largerThan(max_record_bytes) + "; it is lost");
    record_.resize(mcap::record_prefix_size);
    record_[0] = std::numeric_limits<std::uint8_t>::max(); // of no known kind
  }
  if (mcap::endsData(opcode, length))
    return false;
  if (opcode == Opcode::DataEnd || opcode == Opcode::Footer)
    addDamage("a record cannot be read");
  return true;
}

/** \brief Reads what follows the data: who writes the file is not stopped by a pipe that
 * nobody reads. */
void
McapStream::readAfterData()
{
  constexpr std::size_t piece_bytes = std::size_t{1} << 20;
  mcap::BytesAfterEnd after;
  record_.resize(piece_bytes);
  while (const std::size_t read = read_(record_.data(), piece_bytes)) {
    after.add(record_.data(), read);
    position_ += read;
  }
  offset_ = position_ - after.count();
  if (after.count() > 0)
    addDamage(after.describe());
}

void
McapStream::addChannel(const std::uint8_t* content, std::size_t size)
{
  mcap::Channel channel;
  if (!mcap::parse(content, size, channel) || numbers_.count(channel.id) != 0)
    return;
  list_.addChannel(content, size);
  if (const McapChannel* const added = list_.find(channel.id); added != nullptr) {
    numbers_[channel.id] = channels_.size();
    channels_.push_back(*added);
  }
}

bool
McapStream::takeMessage(const std::uint8_t* content, std::size_t size)
{
  std::uint16_t channel_id = 0;
  if (!mcap::readMessage(content, size, message_, channel_id))
    return false;
  const auto channel = numbers_.find(channel_id);
  if (channel == numbers_.end())
    return false;
  message_.channel = channel->second;
  const std::string failure =
      decompressMessage(channels_[channel->second], message_.bytes);
  if (!failure.empty())
    addDamage(failure);
  return failure.empty();
}

/** \brief Takes the records of the chunk up to a message.
 * \return false if there is none
 */
bool
McapStream::takeNextOfChunk()
{
  SpanReader reader(chunk_.data() + next_in_chunk_, chunk_.size() - next_in_chunk_);
  const std::size_t begin = next_in_chunk_;
  mcap::Record record;
  while (mcap::takeRecord(reader, record)) {
    next_in_chunk_ = begin + reader.position();
    const auto& [opcode, content, size] = record;
    if (opcode == Opcode::Schema)
      list_.addSchema(content, size);
    else if (opcode == Opcode::Channel)
      addChannel(content, size);
    else if (opcode == Opcode::Message && takeMessage(content, size))
      return true;
  }
  next_in_chunk_ = chunk_.size();
  return false;
}

void
McapStream::unpackChunk()
{
  const auto readAt =
      [this](std::uint64_t offset, std::size_t count, std::uint8_t* bytes) {
        if (offset > record_.size() || count > record_.size() - offset)
          return false;
        std::memcpy(bytes, record_.data() + offset, count);
        return true;
      };
  next_in_chunk_ = 0;
  const std::string failure =
      mcap::loadChunk(readAt, {true, 0, record_.size(), false}, chunk_);
  if (!failure.empty())
    addDamage("a chunk: " + failure);
}

/** \brief Takes what a record of the file tells.
 * \return true if it is what next() looks for
 */
bool
McapStream::takeRecord(Found& found)
{
  const auto opcode = static_cast<Opcode>(record_[0]);
  const std::uint8_t* const content = record_.data() + mcap::record_prefix_size;
  const std::size_t size = record_.size() - mcap::record_prefix_size;
  mcap::Header header;
  switch (opcode) {
  case Opcode::Header:
    if (mcap::parse(content, size, header))
      profile_ = header.profile;
    return false;
  case Opcode::Schema:
    list_.addSchema(content, size);
    return false;
  case Opcode::Channel:
    addChannel(content, size);
    return false;
  case Opcode::Chunk:
    unpackChunk();
    found = Found::Message;
    return takeNextOfChunk();
  case Opcode::Message:
    found = Found::Message;
    return takeMessage(content, size);
  case Opcode::Metadata:
    found = Found::Metadata;
    return mcap::parse(content, size, metadata_);
  case Opcode::Attachment:
    found = Found::Attachment;
    return mcap::parse(content, size, attachment_);
  default:
    return false;
  }
}

McapStream::Found
McapStream::next()
{
  if (takeNextOfChunk())
    return Found::Message;
  Found found = Found::End;
  while (!is_at_end_) {
    is_at_end_ = !readRecord();
    if (!is_at_end_ && takeRecord(found))
      return found;
  }
  readAfterData();
  if (list_.hasTooMany())
    addDamage("there are too many channels with too large schemas; some are lost");
  return Found::End;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
