// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/entropy_coder.h"

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>

namespace pcl_ext {
namespace io {
namespace rans {

namespace {

constexpr std::size_t state_bytes = 4;

// The reciprocal of a width w is 2^43 / w, rounded up. Multiplying by it divides a
// number x below 2^19 w exactly by w, as the error is below x / 2^43 < 1 / w.
constexpr unsigned int reciprocal_bits = 43;

constexpr std::array<std::uint64_t, probability_one>
makeReciprocals()
{
  std::array<std::uint64_t, probability_one> reciprocals{};
  for (std::uint32_t width = 1; width < probability_one; ++width)
    reciprocals[width] = ((std::uint64_t{1} << reciprocal_bits) + width - 1) / width;
  return reciprocals;
}

constexpr auto reciprocals = makeReciprocals();

std::size_t
stateCount(Interleaving interleaving)
{
  return interleaving == Interleaving::One ? 1 : 4;
}

/** \brief The state after a symbol; words are written from the last to the first. */
inline std::uint32_t
pushed(std::uint32_t state, std::uint32_t range, std::uint16_t*& words)
{
  const std::uint32_t start = range & 0xffff;
  const std::uint32_t width = range >> 16;
  // Without a branch: the word is written in any case, and overwritten if not needed.
  words[-1] = static_cast<std::uint16_t>(state);
  std::uint32_t high = state >> 16;
  std::uint16_t* next_word = words - 1;
  replaceIfBelow(width << 3, high, state, next_word, words);
  state = high;
  words = next_word;
  const auto quotient =
      static_cast<std::uint32_t>(state * reciprocals[width] >> reciprocal_bits);
  return state + start + quotient * (probability_one - width);
}

} // namespace

void
NibbleEncoder::finish(Interleaving interleaving,
                      std::vector<std::uint16_t>& words,
                      std::vector<std::uint8_t>& bytes) const
{
  const std::uint32_t* const first = ranges_->data();
  const auto count = static_cast<std::size_t>(next_ - first);
  if (words.size() < count + 1)
    words.resize(count + count / 4 + 1);
  std::uint16_t* const words_end = words.data() + words.size();
  std::uint16_t* word = words_end;
  std::array<std::uint32_t, 4> states;
  states.fill(NibbleDecoder::lowest_state);
  std::size_t i = count;
  if (interleaving == Interleaving::One) {
    while (i > 0)
      states[0] = pushed(states[0], first[--i], word);
  }
  else {
    for (; i % 4 != 0; --i)
      states[(i - 1) % 4] = pushed(states[(i - 1) % 4], first[i - 1], word);
    for (; i > 0; i -= 4)
      for (std::size_t k = 4; k-- > 0;)
        states[k] = pushed(states[k], first[i - 4 + k], word);
  }
  for (std::size_t k = 0; k < stateCount(interleaving); ++k)
    for (unsigned int shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<std::uint8_t>(states[k] >> shift));
  const std::size_t size = bytes.size();
  bytes.resize(size + 2 * static_cast<std::size_t>(words_end - word));
  for (std::uint8_t* byte = bytes.data() + size; word != words_end; ++word) {
    *byte++ = static_cast<std::uint8_t>(*word);
    *byte++ = static_cast<std::uint8_t>(*word >> 8);
  }
}

NibbleDecoder::NibbleDecoder(const std::uint8_t* begin,
                             const std::uint8_t* end,
                             Interleaving interleaving,
                             std::vector<std::uint8_t>& copy)
: is_single_(interleaving == Interleaving::One)
{
  const auto size = static_cast<std::size_t>(end - begin);
  // Padding: each symbol between two calls of isOverrun may read a word.
  reserveAhead(copy, size + 2 * slack + 4);
  copy.assign(begin, end);
  copy.resize(size + 2 * slack + 4);
  next_ = copy.data();
  end_ = copy.data() + size;
  const std::array<std::uint32_t*, 4> states = {&first_, &second_, &third_, &fourth_};
  for (std::size_t k = 0; k < stateCount(interleaving); ++k) {
    if (static_cast<std::size_t>(end_ - next_) < state_bytes) {
      next_ = end_ + 1;
      return;
    }
    *states[k] = static_cast<std::uint32_t>(next_[0]) |
                 static_cast<std::uint32_t>(next_[1]) << 8 |
                 static_cast<std::uint32_t>(next_[2]) << 16 |
                 static_cast<std::uint32_t>(next_[3]) << 24;
    next_ += state_bytes;
    if (*states[k] < lowest_state || *states[k] >= lowest_state << 16) {
      next_ = end_ + 1;
      return;
    }
  }
}

bool
NibbleDecoder::isAtEnd() const
{
  return next_ == end_ && first_ == lowest_state && second_ == lowest_state &&
         third_ == lowest_state && fourth_ == lowest_state;
}

} // namespace rans
} // namespace io
} // namespace pcl_ext
