// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/entropy_coder.h"

#include "bytes/reserve_ahead.h"

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

namespace {

constexpr std::size_t state_bytes = ReverseEncoder::state_bytes;

std::size_t
stateCount(Interleaving interleaving)
{
  return interleaving == Interleaving::One ? 1 : 4;
}

} // namespace

void
NibbleEncoder::finish(Interleaving interleaving,
                      std::vector<std::uint16_t>& words,
                      std::vector<std::uint8_t>& bytes) const
{
  ReverseEncoder encoder(size(), interleaving, words);
  encoder.push(ranges_->data(), size());
  encoder.finish(bytes);
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
} // namespace pcl_ext::PCL_EXT_ABI::io
