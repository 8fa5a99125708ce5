// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/frame_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

/** \brief Bytes that hold the header of most frames of version 1. Where they do not, more
 * are read. */
constexpr std::uint64_t header_bytes = 2048;

/** \brief Bytes that may be read in vain to find the sizes of frames, for each byte of
 * the file, and besides. Without a bound a file of forged beginnings would take for
 * ever. */
constexpr std::uint64_t rereads = 16;
constexpr std::uint64_t more_rereads = std::uint64_t{1} << 24;

/** \brief What frames begin with, in either format. */
constexpr std::array<const char*, 2> magics = {"PCXI", "<HEAD>"};
constexpr std::size_t longest_magic = 6;

/** \brief True if bytes begin with magic bytes, or may do so if more follow. */
bool
mayBeginWithMagic(const std::uint8_t* bytes, std::size_t count)
{
  return std::any_of(magics.begin(), magics.end(), [&](const char* magic) {
    return std::memcmp(bytes, magic, std::min(count, std::strlen(magic))) == 0;
  });
}

/** \brief Where the next frame may begin; count if nowhere. */
std::size_t
findMagic(const std::uint8_t* bytes, std::size_t count)
{
  std::size_t first = count;
  for (const char* magic : magics) {
    const std::size_t size = std::strlen(magic);
    // Bytes that begin nothing, as zeros, are passed over quickly.
    for (std::size_t i = 0; i < first && count - i >= size; ++i) {
      const void* const found = std::memchr(bytes + i, magic[0], first - i);
      if (found == nullptr)
        break;
      i = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes);
      if (count - i >= size && std::memcmp(bytes + i, magic, size) == 0)
        first = i;
    }
  }
  return first;
}

} // namespace

/** \brief Reads bytes of the file, from the block that was searched last if they are in
 * it. */
bool
FrameFile::readBytes(std::uint64_t offset, std::size_t count, std::uint8_t* bytes) const
{
  const bool is_in_block = offset >= block_offset_ && count <= block_.size() &&
                           offset - block_offset_ <= block_.size() - count;
  if (!is_in_block)
    return file_.read(offset, count, bytes);
  std::memcpy(bytes, block_.data() + (offset - block_offset_), count);
  return true;
}

/** \brief Size of the frame at an offset. The published layout does not tell it, so
 * that as many bytes are read as it needs. */
io::FrameSize
FrameFile::sizeAt(std::uint64_t offset)
{
  const std::uint64_t remaining = file_.size() - offset;
  std::uint64_t at_hand = std::min(remaining, header_bytes);
  for (;;) {
    bytes_.resize(static_cast<std::size_t>(at_hand));
    if (!readBytes(offset, bytes_.size(), bytes_.data()))
      return {{io::CompressionCode::InputFailed, "the file cannot be read"}};
    io::FrameSize size = io::frameSize(bytes_.data(), bytes_.size(), limitsOfReading());
    if (size.status.code() != io::CompressionCode::Truncated || at_hand == remaining ||
        at_hand >= max_recorded_frame_bytes ||
        reread_ > rereads * file_.size() + more_rereads) {
      reread_ += size.status.ok() || at_hand <= header_bytes ? 0 : at_hand;
      return size;
    }
    at_hand = std::min(remaining, std::max<std::uint64_t>(2 * at_hand, size.needed));
  }
}

void
FrameFile::addFrameAt(std::uint64_t offset, std::uint64_t size)
{
  const io::FrameDescription frame =
      io::describeFrame(bytes_.data(), bytes_.size(), limitsOfReading());
  // Stamps are differences, and unknown between a lost frame and the next I-frame.
  knows_stamps_ =
      frame.is_i_frame || (knows_stamps_ && frame.frame_number == last_number_ + 1);
  last_number_ = frame.frame_number;
  if (frame.is_i_frame)
    stamp_ = frame.stamp;
  else if (!knows_stamps_)
    stamp_.reset();
  else if (frame.stamp_difference)
    stamp_ = stamp_.value_or(0) + static_cast<std::uint64_t>(*frame.stamp_difference);
  if (frame.frame_id)
    frame_id_ = *frame.frame_id;
  // A stamp of 0 is none, as everywhere: frames with a frame_id alone have it.
  const bool is_told =
      frame.is_i_frame || (knows_stamps_ && frame.stamp_difference.has_value());
  const std::uint64_t stamp = is_told ? stamp_.value_or(0) : 0;
  const bool has_stamp =
      stamp > 0 &&
      stamp <= std::uint64_t{std::numeric_limits<std::int64_t>::max()} / 1000;
  const Time time(has_stamp
                      ? std::chrono::microseconds(static_cast<std::int64_t>(stamp))
                      : std::chrono::microseconds(0));
  streams_.front().has_times |= has_stamp;
  const Time last_time = found_frames_.empty() ? Time(0) : found_frames_.back().time;
  found_frames_.push_back({has_stamp ? time : last_time, 0, 0, stored_frames_.size()});
  stored_frames_.push_back({offset, size, time, frame_id_});
}

bool
FrameFile::mayBeginAt(std::uint64_t offset)
{
  std::array<std::uint8_t, longest_magic> begin;
  const auto count = static_cast<std::size_t>(
      std::min<std::uint64_t>(begin.size(), file_.size() - offset));
  return readBytes(offset, count, begin.data()) &&
         mayBeginWithMagic(begin.data(), count);
}

/** \brief Where the next frame may begin from an offset on; the end of the file if
 * nowhere. */
std::uint64_t
FrameFile::findFrame(std::uint64_t offset)
{
  constexpr std::uint64_t block_size = std::uint64_t{1} << 16;
  // A file without a frame at its beginning, as one of zeros, is not searched as a
  // whole.
  const std::uint64_t search_end =
      stored_frames_.empty()
          ? std::min<std::uint64_t>(file_.size(), max_recorded_frame_bytes)
          : file_.size();
  while (offset < search_end) {
    const bool is_in_block =
        offset >= block_offset_ && offset < block_offset_ + block_.size();
    if (!is_in_block) {
      block_offset_ = offset;
      block_.resize(
          static_cast<std::size_t>(std::min(block_size, file_.size() - offset)));
      if (!file_.read(offset, block_.size(), block_.data())) {
        block_.clear();
        return file_.size();
      }
    }
    const auto begin = static_cast<std::size_t>(offset - block_offset_);
    const std::size_t count = block_.size() - begin;
    const std::size_t found = findMagic(block_.data() + begin, count);
    if (found < count)
      return offset + found;
    // Magic bytes may be at the end of the block.
    const std::uint64_t end = block_offset_ + block_.size();
    block_.clear();
    if (end == file_.size())
      break;
    offset = std::max(offset, end - (longest_magic - 1));
  }
  return file_.size();
}

/** \brief Takes a frame, unless its size is wrong, as where bytes are missing.
 * \return where to go on
 */
std::uint64_t
FrameFile::takeFrame(std::uint64_t offset, std::uint64_t size)
{
  const std::uint64_t remaining = file_.size() - offset;
  if (size == remaining || (size < remaining && mayBeginAt(offset + size))) {
    addFrameAt(offset, size);
    return offset + size;
  }
  const std::vector<std::uint8_t> header = bytes_; // of the frame
  const std::uint64_t next = findFrame(offset + 1);
  if (size > remaining && next == file_.size()) {
    is_cut_off_ = true;
    addDamage(offset, "the file ends within a frame, which is lost");
    return next;
  }
  if (size > remaining || next < offset + size) {
    addDamage(offset, "bytes of a frame are missing; the frame is lost");
    return next;
  }
  bytes_ = header;
  addFrameAt(offset, size);
  addDamage(offset + size,
            std::to_string(next - offset - size) + " bytes that are no frame");
  return next;
}

/** \brief Skips bytes that no frame begins with.
 * \return where to go on
 */
std::uint64_t
FrameFile::skipBytes(std::uint64_t offset, const std::string& reason)
{
  const std::uint64_t next = findFrame(offset + 1);
  const bool follows = !damage_.empty() && skipped_end_ == offset;
  const std::uint64_t begin = follows ? damage_.back().offset : offset;
  if (!follows) {
    addDamage(offset, {});
    skip_reason_ = reason;
  }
  damage_.back().message =
      std::to_string(next - begin) + " bytes that are no frame: " + skip_reason_;
  skipped_end_ = next;
  return next;
}

RecordingStatus
FrameFile::open(InputFile file)
{
  file_ = std::move(file);
  RecordedStream stream;
  stream.name = std::filesystem::path(file_.path()).stem().string();
  streams_.push_back(stream);
  if (file_.size() == 0)
    return {RecordingCode::NotARecording, "'" + file_.path() + "' is empty"};
  const std::string first_problem = sizeAt(0).status.message();
  for (std::uint64_t offset = 0; offset < file_.size();) {
    const io::FrameSize size = sizeAt(offset);
    if (size.status.ok())
      offset = takeFrame(offset, size.known);
    else if (size.status.code() == io::CompressionCode::Truncated)
      offset = takeFrame(offset, std::numeric_limits<std::uint64_t>::max() / 2);
    else
      offset = skipBytes(offset, size.status.message());
    if (stored_frames_.empty() && offset >= max_recorded_frame_bytes)
      break;
  }
  if (stored_frames_.empty())
    return {RecordingCode::NotARecording,
            "'" + file_.path() + "' is not a recording: " +
                (first_problem.empty() ? "the file ends within its first frame"
                                       : first_problem)};
  makeTimesRise(found_frames_);
  takeFrames(std::move(found_frames_));
  return {};
}

RecordingStatus
FrameFile::read(const IndexedFrame& indexed, RecordedFrame& frame)
{
  const StoredFrame& stored = stored_frames_[static_cast<std::size_t>(indexed.at)];
  frame.time = stored.stamp == Time(0) ? indexed.time : stored.stamp;
  frame.stamp = stored.stamp;
  frame.frame_id = stored.frame_id;
  frame.offset = stored.offset;
  frame.bytes.resize(static_cast<std::size_t>(stored.size));
  if (file_.read(stored.offset, frame.bytes.size(), frame.bytes.data()))
    return {};
  frame.bytes.clear();
  return {RecordingCode::Damaged,
          "'" + file_.path() + "', byte " + std::to_string(stored.offset) +
              ": a frame cannot be read"};
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
