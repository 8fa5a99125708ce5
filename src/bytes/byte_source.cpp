// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/byte_source.h"

#include "bytes/exceptions.h"
#include "bytes/reserve_ahead.h"

#include <algorithm>
#include <array>
#include <ios>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

std::uint64_t
ByteSource::varint()
{
  constexpr std::uint64_t invalid = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t number = 0;
  for (unsigned int shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = u8();
    if (shift == 63 && byte > 1)
      return invalid;
    number |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
    if ((byte & 0x80) == 0)
      return byte == 0 && shift > 0 ? invalid : number;
  }
  return invalid;
}

bool
ByteSource::mayHold(std::size_t size)
{
  const auto is_long_enough = [&] {
    const auto position = buffer_.pubseekoff(0, std::ios_base::cur, std::ios_base::in);
    if (position < 0)
      return true;
    const auto end = buffer_.pubseekoff(0, std::ios_base::end, std::ios_base::in);
    buffer_.pubseekpos(position, std::ios_base::in);
    return end < position ||
           static_cast<std::uint64_t>(end - position) >= std::uint64_t{size};
  };
  // A buffer that cannot seek may throw.
  return callOrElse(is_long_enough, [] { return true; });
}

void
ByteSource::skip(std::size_t size)
{
  if (size > remaining_)
    fail(Failure::LimitExceeded);
  if (failure_ != Failure::None)
    return;
  if (!mayHold(size)) {
    fail(Failure::EndOfInput);
    return;
  }
  if (seekForward(size)) {
    remaining_ -= size;
    consumed_ += size;
    skipped_ += size;
    return;
  }
  std::array<char, 4096> skipped;
  while (size > 0 && failure_ == Failure::None) {
    const std::size_t chunk = std::min(size, skipped.size());
    const auto got = static_cast<std::size_t>(
        buffer_.sgetn(skipped.data(), static_cast<std::streamsize>(chunk)));
    remaining_ -= got;
    consumed_ += got;
    size -= got;
    if (got < chunk)
      fail(Failure::EndOfInput);
  }
}

/** \brief Returns false if the buffer cannot seek; nothing is skipped then. */
bool
ByteSource::seekForward(std::size_t size)
{
  const auto seek = [&] {
    return buffer_.pubseekoff(static_cast<std::streambuf::off_type>(size),
                              std::ios_base::cur,
                              std::ios_base::in) >= 0;
  };
  return callOrElse(seek, [] { return false; });
}

void
ByteSource::read(std::size_t size, std::vector<std::uint8_t>& bytes)
{
  constexpr std::size_t largest_chunk = std::size_t{1} << 16;
  if (size > remaining_)
    fail(Failure::LimitExceeded);
  else if (size > largest_chunk && failure_ == Failure::None && !mayHold(size))
    fail(Failure::EndOfInput);
  while (size > 0 && failure_ == Failure::None) {
    const std::size_t chunk = std::min(size, largest_chunk);
    const std::size_t old_size = bytes.size();
    reserveAhead(bytes, old_size + chunk);
    bytes.resize(old_size + chunk);
    const auto got = static_cast<std::size_t>(
        buffer_.sgetn(reinterpret_cast<char*>(bytes.data() + old_size),
                      static_cast<std::streamsize>(chunk)));
    bytes.resize(old_size + got);
    if (record_ != nullptr && record_ != &bytes)
      record_->insert(record_->end(),
                      bytes.begin() + static_cast<std::ptrdiff_t>(old_size),
                      bytes.end());
    remaining_ -= got;
    consumed_ += got;
    size -= got;
    if (got < chunk)
      fail(Failure::EndOfInput);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
