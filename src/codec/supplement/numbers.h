// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/entropy_coder.h"
#include "codec/rans/nibble_model.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Codes numbers of 0 or more: small ones as a nibble of the model of their
 * context, larger ones after an escape (doc/bitstream_supplement.md, "Numbers"). Loops
 * use a copy, which stays in registers.
 * \tparam Coder rans::NibbleEncoder or rans::NibbleDecoder
 */
template <class Coder>
class NumberCoding {
public:
  static constexpr bool is_decoder = Coder::is_decoder;

  /** \param[in,out] lengths model of the lengths of large numbers */
  NumberCoding(const Coder& coder, rans::NibbleModel& lengths)
  : coder_(coder), lengths_(&lengths)
  {}

  const Coder&
  coder() const
  {
    return coder_;
  }

  /** \brief Makes room for this many more symbols: 8 for a call of code() or
   * codeBits(), 1 for codeBit(). */
  PCL_EXT_ALWAYS_INLINE void
  reserve(std::size_t symbols)
  {
    coder_.reserve(symbols);
  }

  /** \brief Codes a number.
   * \param[in,out] model of its context
   * \param[in] number below 2^31; not used by a decoder
   * \return the number; of forged bytes below 2^33
   */
  PCL_EXT_ALWAYS_INLINE std::uint64_t
  code(rans::NibbleModel& model, std::uint32_t number)
  {
    const unsigned int symbol = coder_.code(model, std::min(number, rans::escape));
    if (symbol < rans::escape)
      return symbol;
    // A copy, as what is passed by reference does not stay in registers.
    NumberCoding copy = *this;
    const std::uint64_t coded = rans::escape + copy.codeLarge(number - rans::escape);
    *this = copy;
    return coded;
  }

  /** \brief Codes a number below 2^count as it is; count 0..64. */
  PCL_EXT_ALWAYS_INLINE std::uint64_t
  codeBits(std::uint64_t number, unsigned int count)
  {
    std::uint64_t coded = 0;
    while (count > 0) {
      const unsigned int part = std::min(count, rans::probability_bits);
      count -= part;
      const auto target =
          static_cast<unsigned int>(number >> count & ((1u << part) - 1));
      coded = coded << part | coder_.codeBits(part, target);
    }
    return coded;
  }

  /** \brief Codes a nibble. */
  PCL_EXT_ALWAYS_INLINE unsigned int
  codeNibble(rans::NibbleModel& model, unsigned int nibble)
  {
    return coder_.code(model, nibble);
  }

  /** \brief Codes a bit. */
  PCL_EXT_ALWAYS_INLINE bool
  codeBit(rans::BitModel& model, bool bit)
  {
    return coder_.code(model, bit ? 1u : 0u) != 0;
  }

  /** \brief Whether more bytes were read than there are. To be asked at least every
   * eight calls of code() and codeBits(), or every 63 of codeBit(). */
  bool
  isOverrun() const
  {
    return coder_.isOverrun();
  }

private:
  /** \brief Codes the bits of a number's successor: how many they are, then those below
   * the highest one. */
  PCL_EXT_NEVER_INLINE std::uint64_t
  codeLarge(std::uint32_t number)
  {
    const std::uint32_t target = number + 1;
    const unsigned int target_length = Coder::is_decoder ? 0 : highestBit(target);
    unsigned int length = 2 * coder_.code(*lengths_, target_length / 2);
    length += coder_.codeBits(1, target_length & 1);
    const auto high = std::uint64_t{1} << length;
    return (high | codeBits(target & (high - 1), length)) - 1;
  }

  Coder coder_;
  rans::NibbleModel* lengths_;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
