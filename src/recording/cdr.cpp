// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/cdr.h"

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

/** \brief Bytes before the fields: the kind of encoding and options. */
constexpr std::size_t encapsulation_size = 4;

constexpr std::size_t alignment = 4;

} // namespace

CdrReader::CdrReader(const std::uint8_t* bytes,
                     std::size_t size,
                     MessageEncoding encoding)
: SpanReader(bytes, size), encoding_(encoding)
{
  if (encoding == MessageEncoding::Ros1)
    return;
  // 0, 1: CDR; 6, 7: the same of version 2, and 8, 9 delimited. The odd ones are
  // little-endian.
  constexpr std::uint8_t last_of_version_1 = 1;
  constexpr std::uint8_t first_of_version_2 = 6;
  constexpr std::uint8_t first_delimited = 8;
  constexpr std::uint8_t last_of_version_2 = 9;
  const std::uint8_t* const header = take(encapsulation_size);
  if (header == nullptr || header[0] != 0 || header[1] > last_of_version_2 ||
      (header[1] > last_of_version_1 && header[1] < first_of_version_2)) {
    fail();
    return;
  }
  is_big_endian_ = header[1] % 2 == 0;
  is_delimited_ = header[1] >= first_delimited;
}

void
CdrReader::begin()
{
  if (is_delimited_)
    u32();
}

std::uint32_t
CdrReader::u32()
{
  // The encapsulation header has the size of an alignment.
  if (encoding_ == MessageEncoding::Cdr)
    take((alignment - position() % alignment) % alignment);
  const std::uint8_t* const begin = take(alignment);
  std::uint32_t number = 0;
  for (std::size_t i = 0; begin != nullptr && i < alignment; ++i)
    number |= std::uint32_t{begin[i]} << 8 * (is_big_endian_ ? alignment - 1 - i : i);
  return number;
}

std::string
CdrReader::string()
{
  const std::uint32_t size = u32();
  const std::uint8_t* const begin = take(size);
  if (begin == nullptr || size == 0)
    return {};
  // In CDR the last byte is 0 and is counted; some writers leave an empty string without
  // it.
  return {reinterpret_cast<const char*>(begin),
          encoding_ == MessageEncoding::Cdr ? size - 1 : size};
}

std::uint32_t
CdrReader::sequenceSize(std::size_t least_size)
{
  const std::uint32_t size = u32();
  if (size > remaining() / least_size)
    fail();
  return failed() ? 0 : size;
}

CdrWriter::CdrWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes)
{
  bytes_.assign({0, 1, 0, 0});
}

void
CdrWriter::u32(std::uint32_t number)
{
  bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment);
  for (std::size_t i = 0; i < alignment; ++i, number >>= 8)
    bytes_.push_back(static_cast<std::uint8_t>(number));
}

void
CdrWriter::string(const std::string& text)
{
  u32(static_cast<std::uint32_t>(text.size() + 1));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
  bytes_.push_back(0);
}

void
CdrWriter::sequence(const std::vector<std::uint8_t>& bytes)
{
  u32(static_cast<std::uint32_t>(bytes.size()));
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
