// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/classed_row.h"

#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

namespace {

/** \brief Codes the bits of a number below its highest 1, up to 15 of them. */
template <class Coder>
unsigned int
codeLowBits(Coder& coder, unsigned int bits, unsigned int number)
{
  const unsigned int low = std::min(bits, 8u);
  const unsigned int high = bits - low;
  unsigned int value = 1;
  if (high > 0)
    value = value << high | coder.codeBits(high, number >> low & ((1u << high) - 1));
  if (low > 0)
    value = value << low | coder.codeBits(low, number & ((1u << low) - 1));
  return value;
}

} // namespace

template <class Coder>
bool
ClassedRow::code(Coder& coder_now,
                 Models& models,
                 const std::vector<std::uint8_t>& classes,
                 std::uint16_t* numbers)
{
  coder_now.reserve(4 * classes.size());
  Coder coder = coder_now;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    unsigned int number = numbers[i];
    const unsigned int symbol =
        coder.code(models.number[classes[i]], std::min(number, escape));
    if (symbol == escape) {
      // An Elias gamma code whose length has a model.
      Coder copy = coder;
      unsigned int above = number - escape + 1;
      unsigned int bits = Coder::is_decoder ? 0 : highestBit(above);
      bits = copy.code(models.length, bits);
      above = codeLowBits(copy, bits, above);
      number = above + escape - 1;
      coder = copy;
      if (number > 0xffff)
        return false;
    }
    else {
      number = symbol;
    }
    numbers[i] = static_cast<std::uint16_t>(number);
    if (coder.isOverrun())
      return false;
  }
  coder_now = coder;
  return true;
}

void
ClassedRow::encode(bool is_first,
                   const std::vector<std::uint16_t>& numbers,
                   const std::vector<std::uint8_t>& classes,
                   std::vector<std::uint8_t>& bytes)
{
  if (is_first)
    models_ = Models();
  work_.numbers.assign(numbers.begin(), numbers.end());
  NibbleEncoder coder(work_.ranges);
  code(coder, models_, classes, work_.numbers.data());
  coder.finish(interleavingOf(numbers.size()), work_.words, bytes);
}

bool
ClassedRow::decode(const std::uint8_t* begin,
                   const std::uint8_t* end,
                   bool is_first,
                   const std::vector<std::uint8_t>& classes,
                   std::vector<std::uint16_t>& numbers)
{
  next_models_ = is_first ? Models() : models_;
  numbers.resize(classes.size());
  NibbleDecoder coder(begin, end, interleavingOf(classes.size()), work_.bytes);
  return !coder.isOverrun() && code(coder, next_models_, classes, numbers.data()) &&
         coder.isAtEnd();
}

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
