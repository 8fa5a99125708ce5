// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_search.h"

#include "bytes/exceptions.h"
#include "codec/frame_failures.h"
#include "codec/published/frame_header.h"
#include "stream/foreign_bytes.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Bytes that may be read again with any limits. */
constexpr std::size_t least_allowance = std::size_t{1} << 20;

/** \brief True if the last bytes read, the newest one lowest, are the first of magic
 * bytes. */
bool
endsInMagic(std::uint64_t last_bytes, const char* magic, std::size_t size)
{
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < size; ++i)
    word = word << 8 | static_cast<std::uint8_t>(magic[i]);
  return (last_bytes & ((std::uint64_t{1} << (8 * size)) - 1)) == word;
}

bool
mayBegin(const std::uint8_t* bytes,
         std::size_t count,
         const char* magic,
         std::size_t magic_size)
{
  return std::equal(magic,
                    magic + std::min(count, magic_size),
                    bytes,
                    [](char a, auto b) { return static_cast<std::uint8_t>(a) == b; });
}

/** \brief The bytes that a search began with, to name another format. */
struct FirstBytes {
  std::array<std::uint8_t, foreign_bytes_size> bytes;
  std::size_t size = 0;
};

/** \brief Reads up to and including the next magic bytes of either format.
 * \param[in,out] last_bytes the last 8 bytes read, the newest one lowest; an
 * interrupted search continues with them
 */
FoundFormat
findMagic(ByteSource& source, std::uint64_t& last_bytes, FirstBytes& first)
{
  for (;;) {
    const std::uint8_t byte = source.u8();
    if (source.failure() != ByteSource::Failure::None)
      return FoundFormat::None;
    if (first.size < first.bytes.size())
      first.bytes[first.size++] = byte;
    last_bytes = last_bytes << 8 | byte;
    if (endsInMagic(last_bytes, version1_magic, version1_magic_size))
      return FoundFormat::Version1;
    if (endsInMagic(last_bytes, published::magic, published::magic_size))
      return FoundFormat::Published;
  }
}

/** \brief Number of bytes at the end of the input that may be the beginning of a frame.
 */
std::size_t
incompleteMagicSize(std::uint64_t last_bytes)
{
  for (std::size_t size = published::magic_size - 1; size > 0; --size)
    if (endsInMagic(last_bytes, published::magic, size) ||
        (size < version1_magic_size && endsInMagic(last_bytes, version1_magic, size)))
      return size;
  return 0;
}

/** \brief The status of a search that found nothing. */
CompressionStatus
noFrame(const ByteSource& source, const FirstBytes& first, std::size_t max_bytes)
{
  const bool is_limit = source.failure() == ByteSource::Failure::LimitExceeded;
  if (source.consumed() == 0 && !is_limit)
    return {CompressionCode::EndOfStream, "the stream has no more bytes"};
  std::string message =
      is_limit
          ? "no frame found within the limit of " + std::to_string(max_bytes) + " bytes"
          : "no frame found in the last " + std::to_string(source.consumed()) +
                " bytes of the stream";
  const std::string format = describeForeignBytes(first.bytes.data(), first.size);
  if (!format.empty())
    message += ", which begin as " + format;
  return {CompressionCode::NoFrame, message};
}

/** \brief Read position of a buffer; -1 if it cannot seek, for which some buffers
 * throw an exception. */
std::streambuf::off_type
positionOf(std::streambuf& buffer)
{
  const auto position = [&]() -> std::streambuf::off_type {
    return buffer.pubseekoff(0, std::ios_base::cur, std::ios_base::in);
  };
  return callOrElse(position, [] { return -1; });
}

void
seekTo(std::streambuf& buffer, std::streambuf::off_type begin, std::size_t offset)
{
  const auto seek = [&] {
    buffer.pubseekpos(begin + static_cast<std::streambuf::off_type>(offset),
                      std::ios_base::in);
  };
  // Fails for a buffer that cannot seek; the status is not changed.
  callOrElse(seek, [] {});
}

/** \brief True if a frame or nothing follows, which confirms the size of the previous
 * one, whose checksum could not be verified. True for a buffer that cannot seek. */
bool
continuesWithFrame(std::streambuf& buffer)
{
  const std::streambuf::off_type position = positionOf(buffer);
  if (position < 0)
    return true;
  std::array<char, published::magic_size> next{};
  // If the buffer throws, the next call reports it.
  const std::streamsize size =
      callOrElse([&] { return buffer.sgetn(next.data(), next.size()); },
                 [] { return std::streamsize{0}; });
  seekTo(buffer, position, 0);
  const auto begins = [&](const char* magic, std::size_t magic_size) {
    const auto known = std::min(static_cast<std::size_t>(size), magic_size);
    return std::equal(magic, magic + known, next.data());
  };
  return begins(version1_magic, version1_magic_size) ||
         begins(published::magic, published::magic_size);
}

/** \brief True for a frame that is old or lacks its reference. */
bool
isOutOfOrder(CompressionCode code)
{
  return code == CompressionCode::MissingReference || code == CompressionCode::OldFrame;
}

/** \brief True if a forged size of the failed frame may have included other frames,
 * which the next call has to find. */
bool
mayHideFrames(CompressionCode code)
{
  return code != CompressionCode::Ok && code != CompressionCode::EndOfStream &&
         code != CompressionCode::NoFrame && code != CompressionCode::InputFailed &&
         !isOutOfOrder(code);
}

} // namespace

std::size_t
magicSize(FoundFormat format)
{
  return format == FoundFormat::Published ? published::magic_size : version1_magic_size;
}

FrameSearch::FrameSearch(std::size_t max_bytes, bool keeps_incomplete)
: max_bytes_(max_bytes)
, keeps_incomplete_(keeps_incomplete)
, rereads_(std::max(max_bytes, least_allowance))
{}

void
FrameSearch::begin(std::streambuf& buffer)
{
  begin_ = positionOf(buffer);
  frame_offset_ = 0;
}

FoundFormat
FrameSearch::find(std::streambuf& buffer, CompressionStatus& status)
{
  ByteSource source(buffer, max_bytes_);
  std::uint64_t last_bytes = std::exchange(unfinished_search_, 0);
  FirstBytes first;
  const FoundFormat format = findMagic(source, last_bytes, first);
  if (format != FoundFormat::None) {
    // Magic bytes may have begun in the previous call.
    frame_offset_ = source.consumed() - std::min(source.consumed(), magicSize(format));
    return format;
  }
  if (source.failure() == ByteSource::Failure::LimitExceeded)
    unfinished_search_ = last_bytes;
  const std::size_t kept = std::min(
      source.consumed(), keeps_incomplete_ ? incompleteMagicSize(last_bytes) : 0);
  if (kept > 0 && source.failure() == ByteSource::Failure::EndOfInput) {
    frame_offset_ = source.consumed() - kept;
    status = failedRead(source, "the first bytes of a frame");
  }
  else {
    status = noFrame(source, first, max_bytes_);
  }
  return format;
}

void
FrameSearch::end(const CompressionStatus& status,
                 std::streambuf& buffer,
                 std::size_t skipped)
{
  const std::streambuf::off_type end = positionOf(buffer);
  if (begin_ < 0 || end <= begin_)
    return;
  if (keeps_incomplete_ && status.code() == CompressionCode::Truncated) {
    seekTo(buffer, begin_, frame_offset_);
    return;
  }
  auto consumed = static_cast<std::size_t>(end - begin_);
  const std::size_t second_byte = frame_offset_ + 1;
  const std::size_t bytes_read = consumed - skipped;
  if (mayHideFrames(status.code()) ||
      (isOutOfOrder(status.code()) && !continuesWithFrame(buffer)))
    if (second_byte < consumed &&
        rereads_.take(bytes_read - std::min(bytes_read, second_byte))) {
      seekTo(buffer, begin_, second_byte);
      consumed = second_byte;
    }
  rereads_.pass(consumed);
}

FoundFormat
possibleFormat(const std::uint8_t* bytes, std::size_t count)
{
  if (mayBegin(bytes, count, version1_magic, version1_magic_size))
    return FoundFormat::Version1;
  if (mayBegin(bytes, count, published::magic, published::magic_size))
    return FoundFormat::Published;
  return FoundFormat::None;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
