// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/span_reader.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

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
            MessageEncoding encoding = MessageEncoding::Cdr);

  /** \brief Begins a message, a structure in it, or a sequence of structures: delimited
   * CDR has its size before it, which is skipped. */
  void
  begin();

  std::uint32_t
  u32();

  std::string
  string();

  /** \brief The number of elements of a sequence.
   * \param[in] least_size bytes that an element has at least; a number that cannot be
   * in the bytes that are left is an error
   */
  std::uint32_t
  sequenceSize(std::size_t least_size);

private:
  MessageEncoding encoding_;
  bool is_big_endian_ = false;
  bool is_delimited_ = false;
};

/** \brief Writes the fields of a message in CDR, little-endian. */
class CdrWriter {
public:
  /** \param[out] bytes is emptied and gets the encapsulation header */
  explicit CdrWriter(std::vector<std::uint8_t>& bytes);

  void
  u8(std::uint8_t number)
  {
    bytes_.push_back(number);
  }

  void
  u32(std::uint32_t number);

  void
  string(const std::string& text);

  void
  sequence(const std::vector<std::uint8_t>& bytes);

private:
  std::vector<std::uint8_t>& bytes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
