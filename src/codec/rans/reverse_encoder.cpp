// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/reverse_encoder.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

namespace {

constexpr std::array<std::uint64_t, probability_one>
makeReciprocals()
{
  std::array<std::uint64_t, probability_one> reciprocals{};
  for (std::uint32_t width = 1; width < probability_one; ++width)
    reciprocals[width] = ((std::uint64_t{1} << reciprocal_bits) + width - 1) / width;
  return reciprocals;
}

} // namespace

const std::array<std::uint64_t, probability_one> reciprocals = makeReciprocals();

ReverseEncoder::ReverseEncoder(std::size_t count,
                               Interleaving interleaving,
                               std::vector<std::uint16_t>& words)
: left_(count), last_state_(interleaving == Interleaving::One ? 0 : 3)
{
  if (words.size() < count + 1)
    words.resize(count + count / 4 + 1);
  states_.fill(lowest_state);
  word_ = words_end_ = words.data() + words.size();
}

void
ReverseEncoder::push(const std::uint32_t* ranges, std::size_t count)
{
  if (last_state_ == 0) {
    while (count > 0)
      push(ranges[--count]);
    return;
  }
  while (count > 0 && left_ % 4 != 0)
    push(ranges[--count]);
  std::array<std::uint32_t, 4> states = states_; // in registers
  std::uint16_t* word = word_;
  for (; count >= 4; count -= 4, left_ -= 4)
    for (std::size_t k = 4; k-- > 0;)
      states[k] = pushed(states[k], ranges[count - 4 + k], word);
  states_ = states;
  word_ = word;
  while (count > 0)
    push(ranges[--count]);
}

void
ReverseEncoder::finish(std::vector<std::uint8_t>& bytes) const
{
  for (std::size_t k = 0; k <= last_state_; ++k)
    for (unsigned int shift = 0; shift < 8 * state_bytes; shift += 8)
      bytes.push_back(static_cast<std::uint8_t>(states_[k] >> shift));
  const std::size_t size = bytes.size();
  bytes.resize(size + 2 * static_cast<std::size_t>(words_end_ - word_));
  std::uint8_t* byte = bytes.data() + size;
  for (const std::uint16_t* word = word_; word != words_end_; ++word) {
    *byte++ = static_cast<std::uint8_t>(*word);
    *byte++ = static_cast<std::uint8_t>(*word >> 8);
  }
}

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
