#pragma once

#include "codec/fast/nibble_model.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Fixed probabilities of the 256 values of a byte. */
class ByteTable {
public:
  static constexpr std::size_t symbol_count = 256;
  using Weights = std::array<std::uint32_t, symbol_count>;

  /** \brief Sets the probabilities.
   * \param[in] weights of the values; their sum is 2^32 or a little less
   */
  void
  set(const Weights& weights);

  ProbabilityRange
  range(unsigned int symbol) const
  {
    return {ranges_[symbol] & 0xffff, ranges_[symbol] >> 16};
  }

  /** \brief The symbol of a slot. */
  unsigned int
  find(std::uint32_t slot) const
  {
    return symbols_[slot];
  }

private:
  static constexpr std::size_t fill_size = 16; ///< slots written at a time

  std::array<std::uint32_t, symbol_count> ranges_;
  std::array<std::uint8_t, probability_one + fill_size> symbols_;
};

/** \brief The probability of the table for a probability, of which 2^16 is 1: in units of
 * 2^-7, in coarser steps in the middle. */
constexpr unsigned int
tableProbability(unsigned int probability)
{
  const unsigned int fine = probability >> 9;
  return fine < 1 ? 1 : fine >= 8 && fine < 120 ? fine / 4 * 4 + 2 : fine;
}

/** \brief Table of the occupancy pattern of eight voxels that are occupied independently with
 * the same probability.
 * \param[in] probability 2^16 is 1
 */
const ByteTable&
occupancyTable(unsigned int probability);

/** \brief Counts of the numbers 0..3 among the four in a byte, in 16 bits each. */
constexpr std::array<std::uint64_t, ByteTable::symbol_count>
makeQuadCounts()
{
  std::array<std::uint64_t, ByteTable::symbol_count> counts{};
  for (unsigned int quad = 0; quad < counts.size(); ++quad)
    for (unsigned int k = 0; k < 8; k += 2)
      counts[quad] += std::uint64_t{1} << (16 * (quad >> k & 3));
  return counts;
}

inline constexpr auto quad_counts = makeQuadCounts();

/** \brief Adaptive probabilities of a quad: a byte of four numbers 0..3, the first one
 * lowest. All four have the same probabilities. */
class QuadModel {
public:
  static constexpr unsigned int number_count = 4;

  QuadModel();

  const ByteTable&
  table() const
  {
    return table_;
  }

  /** \brief Number of quads until the table changes. */
  std::uint32_t
  untilAdapts() const
  {
    return left_;
  }

  /** \brief Counts a quad, and adapts the probabilities at the end of a period. */
  void
  learn(unsigned int quad)
  {
    counts_ += quad_counts[quad];
    if (--left_ == 0)
      adapt();
  }

private:
  static constexpr unsigned int first_period_log2 = 3;
  static constexpr unsigned int last_period_log2 = 10;

  void
  adapt();

  void
  setTable();

  /** \brief Cumulative probabilities of the numbers, 2^16 is 1. */
  std::array<std::uint32_t, number_count + 1> starts_{{0, 45000, 58000, 63000, 65536}};
  std::uint64_t counts_ = 0;
  std::uint32_t period_log2_ = first_period_log2;
  std::uint32_t left_ = 1u << first_period_log2;
  ByteTable table_;
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
