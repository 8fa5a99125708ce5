// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <streambuf>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A stream buffer over bytes that it does not own. */
class MemoryBuffer : public std::streambuf {
public:
  MemoryBuffer(const std::uint8_t* bytes, std::size_t size)
  {
    // streambuf takes char*, but does not write to a get area without a putback.
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes));
    setg(begin, begin, begin + size);
  }
};

/** \brief Reads little-endian numbers from a stream buffer, never more bytes than
 * allowed.
 *
 * Errors are sticky: after the first failed read all reads return 0, so that a parser
 * can check failure() once at the end.
 */
class ByteSource {
public:
  enum class Failure {
    None,
    EndOfInput,   ///< the stream ended
    LimitExceeded ///< the allowed number of bytes is exceeded
  };

  /** \param[in] buffer where to read
   * \param[in] max_bytes most bytes that may be read
   */
  ByteSource(std::streambuf& buffer, std::size_t max_bytes)
  : buffer_(buffer), remaining_(max_bytes)
  {}

  std::uint8_t
  u8()
  {
    if (remaining_ == 0)
      fail(Failure::LimitExceeded);
    if (failure_ != Failure::None)
      return 0;
    const auto byte = buffer_.sbumpc();
    if (byte == std::streambuf::traits_type::eof()) {
      fail(Failure::EndOfInput);
      return 0;
    }
    --remaining_;
    ++consumed_;
    const auto number =
        static_cast<std::uint8_t>(std::streambuf::traits_type::to_char_type(byte));
    if (record_ != nullptr)
      record_->push_back(number);
    return number;
  }

  std::uint16_t
  u16()
  {
    return static_cast<std::uint16_t>(littleEndian(2));
  }

  std::uint32_t
  u32()
  {
    return static_cast<std::uint32_t>(littleEndian(4));
  }

  std::int32_t
  i32()
  {
    return static_cast<std::int32_t>(u32());
  }

  std::uint64_t
  u64()
  {
    return littleEndian(8);
  }

  float
  f32()
  {
    const std::uint32_t bits = u32();
    float number;
    std::memcpy(&number, &bits, sizeof(number));
    return number;
  }

  double
  f64()
  {
    const std::uint64_t bits = u64();
    double number;
    std::memcpy(&number, &bits, sizeof(number));
    return number;
  }

  /** \brief Inverse of ByteWriter::varint. An encoding of more than 64 bits, or with a
   * redundant last byte, returns the largest number, which no field allows. */
  std::uint64_t
  varint();

  /** \brief Inverse of ByteWriter::signedVarint. An invalid varint returns the smallest
   * number, which no field allows. */
  std::int64_t
  signedVarint()
  {
    const std::uint64_t bits = varint();
    return static_cast<std::int64_t>((bits & 1) != 0 ? ~(bits >> 1) : bits >> 1);
  }

  /** \brief Appends bytes to a text, up to the end of the input. */
  void
  text(std::uint64_t size, std::string& text)
  {
    for (std::uint64_t i = 0; i < size && failure() == Failure::None; ++i)
      text.push_back(static_cast<char>(u8()));
  }

  /** \brief Appends bytes to a vector. Memory is allocated as bytes arrive, not for the
   * requested size; a large request fails at once if the buffer can tell that it has
   * fewer bytes. */
  void
  read(std::size_t size, std::vector<std::uint8_t>& bytes);

  /** \brief Skips bytes, without reading them if the buffer can seek. */
  void
  skip(std::size_t size);

  /** \brief Bytes skipped without being read. */
  std::size_t
  skipped() const
  {
    return skipped_;
  }

  /** \brief Appends every byte read from now on to a vector; null stops it. */
  void
  recordTo(std::vector<std::uint8_t>* bytes)
  {
    record_ = bytes;
  }

  /** \brief Why a read failed, if one did. */
  Failure
  failure() const
  {
    return failure_;
  }

  /** \brief Bytes read or skipped so far. */
  std::size_t
  consumed() const
  {
    return consumed_;
  }

private:
  /** \brief False if the buffer can seek and has fewer bytes left. */
  bool
  mayHold(std::size_t size);

  bool
  seekForward(std::size_t size);

  void
  fail(Failure failure)
  {
    if (failure_ == Failure::None)
      failure_ = failure;
  }

  std::uint64_t
  littleEndian(unsigned int size)
  {
    std::uint64_t number = 0;
    for (unsigned int i = 0; i < size; ++i)
      number |= static_cast<std::uint64_t>(u8()) << (8 * i);
    return number;
  }

  std::streambuf& buffer_;
  std::size_t remaining_;
  std::size_t consumed_ = 0;
  std::size_t skipped_ = 0;
  Failure failure_ = Failure::None;
  std::vector<std::uint8_t>* record_ = nullptr;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
