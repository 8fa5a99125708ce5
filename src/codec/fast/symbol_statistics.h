// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Bins of intensity values; above 15 there are eight an octave, and low bits
 * select the value within the bin. The highest value of all, at which sensors saturate,
 * has a bin of its own.
 *
 *     values      0..15  16..31  32..63  64..127  ...  the highest one
 *     bins        0..15  16..23  24..31  32..39   ...  one more than it would have else
 *     low bits    0      1       2       3        ...  0
 */
namespace intensity_bins {

constexpr unsigned int exact = 16;
constexpr unsigned int highest = 113; ///< the highest bin

/** \brief Number of low bits of a bin, 0..12. */
constexpr unsigned int
lowBits(unsigned int bin)
{
  return bin < exact ? 0 : (bin - exact) / 8 + 1;
}

/** \brief Lowest value in a bin. */
constexpr unsigned int
lowestValue(unsigned int bin)
{
  return bin < exact ? bin : (8 + bin % 8) << lowBits(bin);
}

/** \brief The bin of a value other than the highest value of all. */
inline unsigned int
binOf(unsigned int value)
{
  if (value < exact)
    return value;
  const unsigned int octave = highestBit(value);
  return exact + (octave - 4) * 8 + (value >> (octave - 3) & 7);
}

} // namespace intensity_bins

/** \brief Running mean and mean deviation of the bins of a voxel in 16 bits: the mean
 * in the higher ten, the deviation in the lower six, both in eighths. */
namespace symbol_statistics {

constexpr int fraction = 8; ///< 1, in eighths
constexpr unsigned int deviation_bits = 6;
constexpr unsigned int deviation_count = 1u << deviation_bits;
constexpr unsigned int mean_count = 1024;

/** \brief Statistics of a voxel without symbols; no others have this mean. */
constexpr std::uint16_t none = 0xffff;

// In the functions below a Number is a type of 16 bits or more. With std::int16_t, and
// only with it, compilers vectorise a loop over many voxels for eight of them at a
// time.

template <class Number = int>
constexpr Number
mean(std::uint16_t statistics)
{
  return static_cast<Number>(statistics / deviation_count);
}

template <class Number = int>
constexpr Number
deviation(std::uint16_t statistics)
{
  return static_cast<Number>(statistics % deviation_count);
}

template <class Number>
constexpr Number
least(Number a, Number b)
{
  return a < b ? a : b;
}

/** \brief The statistics after a voxel's first symbol. */
template <class Number = int>
constexpr std::uint16_t
first(unsigned int bin)
{
  const auto eighths = static_cast<Number>(bin * fraction);
  const auto deviation = least(static_cast<Number>(fraction + bin), Number{40});
  return static_cast<std::uint16_t>((eighths << deviation_bits) + deviation);
}

/** \brief The statistics after a further symbol; both adapt at a rate of 1/4. */
template <class Number = int>
constexpr std::uint16_t
next(std::uint16_t statistics, unsigned int bin)
{
  const auto old_mean = mean<Number>(statistics);
  const auto eighths = static_cast<Number>(bin * fraction);
  const auto above = static_cast<Number>(eighths - old_mean);
  const auto below = static_cast<Number>(old_mean - eighths);
  const Number distance = least(above > below ? above : below, Number{63});
  const auto excess = static_cast<Number>(distance - deviation<Number>(statistics) + 2);
  const auto mean_step = static_cast<Number>(static_cast<Number>(above + 2) >> 2);
  const auto further = static_cast<std::uint16_t>(
      statistics + mean_step * (1 << deviation_bits) + (excess >> 2));
  return statistics == none ? first<Number>(bin) : further;
}

/** \brief The bin of symbol 0 in the model of a voxel. The fifteen bins of the model
 * are 0..14 up to a mean of 7, then those around the mean. */
template <class Number = int>
constexpr std::uint16_t
lowestBin(std::uint16_t statistics)
{
  const auto above =
      static_cast<Number>(mean<Number>(statistics) - (7 * fraction - fraction / 2));
  const Number clamped = above > 0 ? above : Number{0};
  const auto lowest = static_cast<std::uint16_t>(clamped / fraction);
  return statistics == none ? std::uint16_t{0} : lowest;
}

/** \brief Context of a voxel with these statistics, 0..124, or 125 without. */
template <class Number = int>
constexpr std::uint16_t
contextOf(std::uint16_t statistics)
{
  const auto fine = static_cast<Number>(mean<Number>(statistics) >> 1);
  const auto coarse = static_cast<Number>((mean<Number>(statistics) >> 2) + 6);
  const Number level = least(least(fine, coarse), Number{24});
  const auto size = deviation<Number>(statistics);
  const auto spread =
      static_cast<Number>((size >= 4) + (size >= 9) + (size >= 16) + (size >= 28));
  const Number is_none = statistics == none;
  return static_cast<std::uint16_t>(level * 5 + spread + is_none);
}

/** \brief As contextOf and lowestBin of statistics other than `none`; faster for a
 * single voxel. */
class Tables {
public:
  constexpr Tables()
  {
    for (unsigned int i = 0; i < mean_count - 1; ++i) {
      const auto statistics = static_cast<std::uint16_t>(i << deviation_bits);
      of_mean_[i] = static_cast<std::uint8_t>(symbol_statistics::contextOf(statistics));
      lowest_bin_[i] =
          static_cast<std::uint8_t>(symbol_statistics::lowestBin(statistics));
    }
    for (unsigned int i = 0; i < deviation_count; ++i)
      of_deviation_[i] = static_cast<std::uint8_t>(
          symbol_statistics::contextOf(static_cast<std::uint16_t>(i)));
  }

  unsigned int
  contextOf(std::uint16_t statistics) const
  {
    return contextOf(mean(statistics), deviation(statistics));
  }

  unsigned int
  contextOf(int mean, int deviation) const
  {
    return unsigned{of_mean_[static_cast<std::size_t>(mean)]} +
           of_deviation_[static_cast<std::size_t>(deviation)];
  }

  unsigned int
  lowestBin(std::uint16_t statistics) const
  {
    return lowestBinOf(mean(statistics));
  }

  unsigned int
  lowestBinOf(int mean) const
  {
    return lowest_bin_[static_cast<std::size_t>(mean)];
  }

private:
  // Parts of the context, whose sum it is.
  std::array<std::uint8_t, mean_count> of_mean_{};
  std::array<std::uint8_t, deviation_count> of_deviation_{};
  std::array<std::uint8_t, mean_count> lowest_bin_{};
};

inline constexpr Tables tables;

/** \brief Running statistics of an I-frame, as of `first` and `next`. Not in 16 bits,
 * since each voxel waits for the statistics after the one before it: that is 6 % of an
 * encoder's time. */
class Running {
public:
  explicit Running(unsigned int first_bin)
  : mean_(mean(first(first_bin))), deviation_(deviation(first(first_bin)))
  {}

  unsigned int
  contextOf() const
  {
    return tables.contextOf(mean_, deviation_);
  }

  unsigned int
  lowestBin() const
  {
    return tables.lowestBinOf(mean_);
  }

  void
  add(unsigned int bin)
  {
    const int above = static_cast<int>(bin) * fraction - mean_;
    const int distance = least(above > 0 ? above : -above, 63);
    mean_ += (above + 2) >> 2;
    deviation_ += (distance - deviation_ + 2) >> 2;
  }

private:
  int mean_;
  int deviation_;
};

} // namespace symbol_statistics

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
