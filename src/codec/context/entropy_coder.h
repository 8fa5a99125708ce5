// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Encodes bits of given probability: a range coder with two symbols
 * (G. N. N. Martin, Range encoding, 1979; doc/bitstream_context.md, "Range coder").
 *
 * code() has the same signature as in BinaryRangeDecoder, so that the stages of a frame
 * are written once for both directions.
 */
class BinaryRangeEncoder {
public:
  static constexpr bool is_decoder = false;

  /** \brief Starts a row of bits.
   * \param[in,out] bytes where to append
   */
  explicit BinaryRangeEncoder(std::vector<std::uint8_t>& bytes)
  : bytes_(&bytes), begin_(bytes.size())
  {}

  /** \brief Writes a bit.
   * \param[in] bit the bit
   * \param[in] probability of a 1, in units of 2^-16, 1..2^16 - 1
   * \return the bit
   */
  PCL_EXT_ALWAYS_INLINE bool
  code(bool bit, std::uint32_t probability)
  {
    const auto bound = static_cast<std::uint32_t>(
        static_cast<std::uint64_t>(range_) * probability >> 16);
    low_ += bit ? 0 : bound;
    range_ = bit ? bound : range_ - bound;
    if (range_ < least_range) {
      writeWord();
      range_ <<= 16;
    }
    return bit;
  }

  /** \brief Divides the interval into units, of which an alternative is given some.
   * \param[in] total number of units, 1..2^16
   * \return a unit of the alternative that is decoded; 0 in an encoder
   */
  std::uint32_t
  beginShare(std::uint32_t total)
  {
    unit_ = range_ / total;
    return 0;
  }

  /** \brief Writes an alternative after beginShare().
   * \param[in] begin its first unit
   * \param[in] size number of its units, not 0
   * \param[in] is_last no units follow; what remains of the interval belongs to it, too
   */
  void
  endShare(std::uint32_t begin, std::uint32_t size, bool is_last)
  {
    low_ += std::uint64_t{unit_} * begin;
    range_ = is_last ? range_ - unit_ * begin : unit_ * size;
    if (range_ < least_range) {
      writeWord();
      range_ <<= 16;
    }
  }

  /** \brief Number of bytes that further bits change by a carry only; the decoder
   * counts the same. */
  std::size_t
  settledBytes() const
  {
    return bytes_->size() - begin_;
  }

  /** \brief Ends the row with as few bytes as identify its interval. Trailing zeros are
   * omitted, as the decoder reads zeros beyond the end. */
  void
  finish()
  {
    // The number with the most trailing zero bits in [low, low + range).
    const std::uint64_t end = low_ + range_;
    for (unsigned int bits = 32;; --bits) {
      const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
      const std::uint64_t number = (low_ + mask) & ~mask;
      if (number < end) {
        low_ = number;
        break;
      }
    }
    writeWord();
    writeWord();
    while (bytes_->size() > begin_ && bytes_->back() == 0)
      bytes_->pop_back();
  }

private:
  static constexpr std::uint32_t least_range = std::uint32_t{1} << 16;

  void
  writeWord()
  {
    constexpr std::uint64_t carry = std::uint64_t{1} << 32;
    if (low_ >= carry) {
      // The coded number is below 1, so the carry ends within this row.
      for (std::size_t i = bytes_->size(); ++(*bytes_)[--i] == 0;) {
      }
      low_ -= carry;
    }
    bytes_->push_back(static_cast<std::uint8_t>(low_ >> 24));
    bytes_->push_back(static_cast<std::uint8_t>(low_ >> 16));
    low_ = (low_ & 0xffff) << 16;
  }

  std::vector<std::uint8_t>* bytes_;
  std::size_t begin_;
  std::uint64_t low_ = 0; // 32 bits and the carry
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t unit_ = 0; // between beginShare() and endShare()
};

/** \brief Decodes what BinaryRangeEncoder wrote. Never reads beyond the end. */
class BinaryRangeDecoder {
public:
  static constexpr bool is_decoder = true;

  /** \brief Reads a row of bits.
   * \param[in] begin first byte
   * \param[in] end end of the row, beyond which zeros are decoded
   */
  BinaryRangeDecoder(const std::uint8_t* begin, const std::uint8_t* end)
  : next_(begin), end_(end)
  {
    readWord();
    readWord();
  }

  /** \brief Reads a bit.
   * \param[in] probability of a 1, as given to the encoder
   */
  PCL_EXT_ALWAYS_INLINE bool
  code(bool /*bit*/, std::uint32_t probability)
  {
    const auto bound = static_cast<std::uint32_t>(
        static_cast<std::uint64_t>(range_) * probability >> 16);
    const bool bit = code_ < bound;
    code_ -= bit ? 0 : bound;
    range_ = bit ? bound : range_ - bound;
    if (range_ < least_range) {
      readWord();
      range_ <<= 16;
    }
    return bit;
  }

  /** \brief As BinaryRangeEncoder::beginShare. */
  std::uint32_t
  beginShare(std::uint32_t total)
  {
    unit_ = range_ / total;
    return std::min(code_ / unit_, total - 1);
  }

  /** \brief As BinaryRangeEncoder::endShare, of the alternative whose unit was
   * returned. */
  void
  endShare(std::uint32_t begin, std::uint32_t size, bool is_last)
  {
    code_ -= unit_ * begin;
    range_ = is_last ? range_ - unit_ * begin : unit_ * size;
    if (range_ < least_range) {
      readWord();
      range_ <<= 16;
    }
  }

  /** \brief As BinaryRangeEncoder::settledBytes. */
  std::size_t
  settledBytes() const
  {
    return 2 * words_ - 4;
  }

  /** \brief True if all bytes were read. */
  bool
  isAtEnd() const
  {
    return next_ == end_;
  }

private:
  static constexpr std::uint32_t least_range = std::uint32_t{1} << 16;

  void
  readWord()
  {
    ++words_;
    for (int i = 0; i < 2; ++i)
      code_ = code_ << 8 | (next_ != end_ ? *next_++ : 0u);
  }

  const std::uint8_t* next_;
  const std::uint8_t* end_;
  std::size_t words_ = 0; // of 16 bits, read so far
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t unit_ = 0; // between beginShare() and endShare()
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
