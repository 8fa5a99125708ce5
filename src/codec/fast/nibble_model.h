#pragma once

#include "simd/bit_operations.h"

#include <array>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief What is coded has a probability in multiples of 2^-12. */
constexpr unsigned int probability_bits = 12;
constexpr std::uint32_t probability_one = 1u << probability_bits;

/** \brief Where any number is coded with one nibble, 0..14 are themselves; this stands for
 * all others, which follow in another way. */
constexpr unsigned int escape = 15;

/** \brief The share of the probabilities that a symbol owns: `start` up to, not
 * including, `start + width`. */
struct ProbabilityRange {
  std::uint32_t start;
  std::uint32_t width; ///< above 0
};

/** \brief Adaptive probabilities of the sixteen values of a nibble.
 *
 * The symbols are counted, and after the first 4, the next 8, the next 16 and then each
 * 32 the probabilities move towards what was counted: half of the way, then a quarter.
 * Between that they stand, which is what makes it fast. Whole numbers of 16 bits only:
 * the SSE2 and the plain way give the same.
 */
class alignas(64) NibbleModel {
public:
  static constexpr unsigned int symbol_count = 16;

  /** \brief All symbols alike. */
  NibbleModel()
  {
    for (std::uint32_t i = 0; i <= symbol_count; ++i)
      bounds_[i] = static_cast<std::uint16_t>(i * (fine_one / symbol_count));
  }

  /** \brief Starts with given probabilities.
   * \param[in] weights of the sixteen symbols, their sum 1..2^26
   */
  explicit NibbleModel(const std::array<std::uint32_t, symbol_count>& weights)
  {
    std::uint32_t sum = 0;
    for (const std::uint32_t weight : weights)
      sum += weight;
    std::uint64_t below = 0;
    for (unsigned int i = 0; i < symbol_count; ++i) {
      bounds_[i] = static_cast<std::uint16_t>(i * least_width + shared * below / sum);
      below += weights[i];
    }
    bounds_[symbol_count] = fine_one;
  }

  ProbabilityRange
  range(std::size_t symbol) const
  {
    const std::uint32_t start = std::uint32_t{bounds_[symbol]} >> fine_bits;
    return {start, (std::uint32_t{bounds_[symbol + 1]} >> fine_bits) - start};
  }

  /** \brief The symbol whose range a number below 2^12 lies in. */
  std::size_t
  find(std::uint32_t slot) const
  {
#if defined(__SSE2__)
    // The lowest symbol that ends behind the slot. The sign of a difference tells that
    // with an instruction less on the way than a comparison, as 15 ends at 2^15, which
    // is no positive number; and each one counts, for a state waits for all of them.
    constexpr std::uint32_t beyond = (1u << 15) + (1u << fine_bits);
    const __m128i place =
        _mm_set1_epi16(static_cast<short>((slot << fine_bits) + beyond));
    const __m128i low = _mm_sub_epi16(_mm_load_si128(ends()), place);
    const __m128i high = _mm_sub_epi16(_mm_load_si128(ends() + 1), place);
    const auto behind =
        static_cast<unsigned int>(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
    return lowestBit(behind);
#else
    const std::uint32_t fine = (slot << fine_bits) + ((1u << fine_bits) - 1);
    std::size_t symbol = symbol_count - 1;
    while (bounds_[symbol] > fine)
      --symbol;
    return symbol;
#endif
  }

  /** \brief Counts a symbol, and adapts when it is time. */
  void
  learn(std::size_t symbol)
  {
    ++counts_[symbol];
    if (--left_ == 0)
      adapt();
  }

private:
  // Probabilities are kept in multiples of 2^-15.
  static constexpr unsigned int fine_bits = 3;
  static constexpr std::uint32_t fine_one = 1u << 15;
  // No symbol's range gets narrower: it is 1 in multiples of 2^-12.
  static constexpr std::uint32_t least_width = 1u << fine_bits;
  static constexpr std::uint32_t shared = fine_one - symbol_count * least_width;

  void
  adapt();

#if defined(__SSE2__)
  const __m128i*
  ends() const
  {
    return reinterpret_cast<const __m128i*>(bounds_.data() + 1);
  }
#endif

  std::uint8_t left_ = 4;
  std::uint8_t period_log2_ = 2;
  [[maybe_unused]] std::array<std::uint8_t, 12> unused_{}; // the ends are aligned
  /** \brief Where each symbol starts, which is where the one below it ends. */
  std::array<std::uint16_t, symbol_count + 1> bounds_;
  std::array<std::uint8_t, symbol_count> counts_{};
};

inline void
NibbleModel::adapt()
{
  const unsigned int shift = period_log2_ < 4 ? 1 : 2;
  const unsigned int unit = shared >> period_log2_;
#if defined(__SSE2__)
  constexpr short w = least_width;
  auto* const ends = reinterpret_cast<__m128i*>(bounds_.data() + 1);
  auto* const counts = reinterpret_cast<__m128i*>(counts_.data());
  // Sums of the counts up to each, in bytes; they are at most 32. Where 15 ends is its
  // own goal.
  __m128i sums = _mm_load_si128(counts);
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 1));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 2));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 4));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 8));
  const __m128i zero = _mm_setzero_si128();
  const __m128i units = _mm_set1_epi16(static_cast<short>(unit));
  const __m128i least =
      _mm_set_epi16(8 * w, 7 * w, 6 * w, 5 * w, 4 * w, 3 * w, 2 * w, w);
  const __m128i shifts = _mm_cvtsi32_si128(static_cast<int>(shift));
  const auto move = [&](__m128i end, __m128i count, __m128i floor) {
    const __m128i goal = _mm_add_epi16(_mm_mullo_epi16(count, units), floor);
    return _mm_add_epi16(end, _mm_sra_epi16(_mm_sub_epi16(goal, end), shifts));
  };
  _mm_store_si128(ends,
                  move(_mm_load_si128(ends), _mm_unpacklo_epi8(sums, zero), least));
  _mm_store_si128(ends + 1,
                  move(_mm_load_si128(ends + 1),
                       _mm_unpackhi_epi8(sums, zero),
                       _mm_add_epi16(least, _mm_set1_epi16(8 * w))));
  _mm_store_si128(counts, zero);
#else
  unsigned int below = 0;
  for (std::uint32_t i = 0; i < symbol_count; ++i) {
    const std::uint32_t goal = i * least_width + below * unit;
    const std::int32_t way = static_cast<std::int32_t>(goal) - bounds_[i];
    bounds_[i] = static_cast<std::uint16_t>(bounds_[i] + (way >> shift));
    below += counts_[i];
    counts_[i] = 0;
  }
#endif
  period_log2_ = static_cast<std::uint8_t>(period_log2_ + (period_log2_ < 5 ? 1 : 0));
  left_ = static_cast<std::uint8_t>(1u << period_log2_);
}

/** \brief Adaptive probability of a bit. */
class BitModel {
public:
  BitModel() = default;

  /** \param[in] share_of_ones 2^16 is 1; held between 2^-7 and 1 - 2^-7 */
  explicit BitModel(std::uint32_t share_of_ones)
  : ones_(static_cast<std::uint16_t>(share_of_ones < least  ? least
                                     : share_of_ones > most ? most
                                                            : share_of_ones))
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

  /** \brief Moves 1/16 of the way. */
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

} // namespace fast
} // namespace io
} // namespace pcl_ext
