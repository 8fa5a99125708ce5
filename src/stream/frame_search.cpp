// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_search.h"

#include "codec/published/frame_header.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

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

} // namespace

FoundFormat
findFrame(ByteSource& source, std::uint64_t& last_bytes, FirstBytes& first)
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

std::size_t
incompleteMagicSize(std::uint64_t last_bytes)
{
  for (std::size_t size = published::magic_size - 1; size > 0; --size)
    if (endsInMagic(last_bytes, published::magic, size) ||
        (size < version1_magic_size && endsInMagic(last_bytes, version1_magic, size)))
      return size;
  return 0;
}

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
