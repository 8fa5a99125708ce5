// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"
#include "simd/symbol_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Probabilities of symbols are multiples of 2^-12. */
constexpr unsigned int probability_bits = 12;
constexpr std::uint32_t probability_one = 1u << probability_bits;

/** \brief Symbol of a nibble that stands for all numbers above 14, which are then coded
 * in another way. */
constexpr unsigned int escape = 15;

/** \brief The slots of a symbol among 2^12: from `start` to before `start + width`. */
struct ProbabilityRange {
  std::uint32_t start;
  std::uint32_t width; ///< above 0
};

/** \brief Adaptive probabilities of the sixteen values of a nibble.
 *
 * The symbols are counted. After the first 4, the next 8, the next 16 and then after
 * every 32 symbols the probabilities adapt to the counts, at a rate of 1/2, in the end
 * 1/4.
 */
class alignas(64) NibbleModel {
public:
  static constexpr unsigned int symbol_count = 16;

  /** \brief Starts with equal probabilities. */
  NibbleModel()
  {
    for (std::uint32_t i = 0; i <= symbol_count; ++i)
      bounds_[i] = static_cast<std::uint16_t>(i * (fine_one / symbol_count));
  }

  ProbabilityRange
  range(std::size_t symbol) const
  {
    // Both bounds at once: two loads take longer.
    std::uint32_t both;
    std::memcpy(&both, bounds_.data() + symbol, sizeof(both));
    const std::uint32_t low = both % (1u << 16);
    const std::uint32_t high = both >> 16;
    const std::uint32_t start = (is_big_endian ? high : low) >> fine_bits;
    const std::uint32_t end = (is_big_endian ? low : high) >> fine_bits;
    return {start, end - start};
  }

  /** \brief The symbol of a slot. */
  std::size_t
  find(std::uint32_t slot) const
  {
    return firstAbove<fine_bits, (1u << fine_bits) - 1>(bounds_.data() + 1, slot);
  }

  /** \brief Counts a symbol, and adapts at the end of a period. */
  void
  learn(std::size_t symbol)
  {
    ++counts_[symbol];
    if (--left_ == 0)
      adapt();
  }

private:
  // Probabilities are stored in units of 2^-15.
  static constexpr unsigned int fine_bits = 3;
  static constexpr std::uint32_t fine_one = 1u << 15;
  // The narrowest range: one slot.
  static constexpr std::uint32_t least_width = 1u << fine_bits;
  static constexpr std::uint32_t shared = fine_one - symbol_count * least_width;

  PCL_EXT_NEVER_INLINE void
  adapt()
  {
    const unsigned int shift = period_log2_ < 5 ? 1 : 2;
    moveEnds(
        bounds_.data() + 1, counts_.data(), least_width, shared >> period_log2_, shift);
    period_log2_ = static_cast<std::uint8_t>(period_log2_ + (period_log2_ < 5 ? 1 : 0));
    left_ = static_cast<std::uint8_t>(1u << period_log2_);
  }

  std::uint8_t left_ = 4;
  std::uint8_t period_log2_ = 2;
  [[maybe_unused]] std::array<std::uint8_t, 12> unused_{}; // aligns bounds_[1]
  /** \brief Start of each symbol, which is the end of the one below it. */
  std::array<std::uint16_t, symbol_count + 1> bounds_;
  std::array<std::uint8_t, symbol_count> counts_{};
};

/** \brief Adaptive probability of a bit. */
class BitModel {
public:
  BitModel() = default;

  /** \param[in] probability of a 1, 2^16 is 1; clamped to 2^-7 .. 1 - 2^-7 */
  explicit BitModel(std::uint32_t probability)
  : ones_(static_cast<std::uint16_t>(probability < least  ? least
                                     : probability > most ? most
                                                          : probability))
  {}

  ProbabilityRange
  range(unsigned int bit) const
  {
    const std::uint32_t zeros = probability_one - (ones_ >> 4);
    return bit != 0 ? ProbabilityRange{zeros, probability_one - zeros}
                    : ProbabilityRange{0, zeros};
  }

  unsigned int
  find(std::uint32_t slot) const
  {
    return slot >= probability_one - (ones_ >> 4) ? 1 : 0;
  }

  /** \brief Adapts to a bit at a rate of 1/16. */
  void
  learn(unsigned int bit)
  {
    const std::int32_t goal = bit != 0 ? most : least;
    ones_ = static_cast<std::uint16_t>(ones_ + ((goal - ones_) >> 4));
  }

private:
  static constexpr std::uint32_t least = 1u << 9;
  static constexpr std::uint32_t most = (1u << 16) - least;

  std::uint16_t ones_ = 1u << 15;
};

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
