// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/span_reader.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Bytes before the fields: the kind of encoding and options. */
constexpr std::size_t encapsulation_size = 4;

constexpr std::size_t alignment = 4;

/** \brief How messages are encoded: as ROS 2 has them ("plain CDR" and "delimited CDR" of
 * the OMG's DDS-XTypes, 7.4), or as ROS 1 has them: little-endian, without alignment. */
enum class MessageEncoding { Cdr, Ros1 };

/** \brief Reads the fields of a message, of either byte order. Fields of more than four
 * bytes, whose alignment depends on the version of CDR, are not read.
 */
class CdrReader : private SpanReader {
public:
  using SpanReader::failed;
  using SpanReader::take;
  using SpanReader::u8;

  CdrReader(const std::uint8_t* bytes,
            std::size_t size,
            MessageEncoding encoding = MessageEncoding::Cdr)
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

  /** \brief Begins a message, a structure in it, or a sequence of structures: delimited
   * CDR has its size before it, which is skipped. */
  void
  begin()
  {
    if (is_delimited_)
      u32();
  }

  std::uint32_t
  u32()
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
  string()
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

  /** \brief The number of elements of a sequence.
   * \param[in] least_size bytes that an element has at least; a number that cannot be
   * in the bytes that are left is an error
   */
  std::uint32_t
  sequenceSize(std::size_t least_size)
  {
    const std::uint32_t size = u32();
    if (size > remaining() / least_size)
      fail();
    return failed() ? 0 : size;
  }

private:
  MessageEncoding encoding_;
  bool is_big_endian_ = false;
  bool is_delimited_ = false;
};

/** \brief Writes the fields of a message in CDR, little-endian. */
class CdrWriter {
public:
  /** \param[out] bytes is emptied and gets the encapsulation header */
  explicit CdrWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes)
  {
    bytes_.assign({0, 1, 0, 0});
  }

  void
  u8(std::uint8_t number)
  {
    bytes_.push_back(number);
  }

  void
  u32(std::uint32_t number)
  {
    bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment);
    for (std::size_t i = 0; i < alignment; ++i, number >>= 8)
      bytes_.push_back(static_cast<std::uint8_t>(number));
  }

  void
  string(const std::string& text)
  {
    u32(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }

  void
  sequence(const std::vector<std::uint8_t>& bytes)
  {
    u32(static_cast<std::uint32_t>(bytes.size()));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }

private:
  std::vector<std::uint8_t>& bytes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
