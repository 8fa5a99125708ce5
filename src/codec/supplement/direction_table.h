// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Bins of the direction from the viewpoint to a voxel. */
struct Direction {
  static constexpr unsigned int azimuth_bins = 8192;
  static constexpr unsigned int elevation_bins = 4096;

  unsigned int azimuth = 0;
  unsigned int elevation = 0;
};

/** \brief Largest integer whose square is at most `number`, which is below 2^50: the next
 * integer is further from the root than a double's rounding error. */
inline std::int64_t
integerRoot(std::int64_t number)
{
  return static_cast<std::int64_t>(std::sqrt(static_cast<double>(number)));
}

/** \brief The direction of a voxel (doc/bitstream_supplement.md, "Fields").
 * \param[in] x, y, z position relative to the viewpoint, voxels, below 2^24
 */
inline Direction
directionOf(std::int64_t x, std::int64_t y, std::int64_t z)
{
  constexpr std::int64_t quarter = Direction::azimuth_bins / 4;
  constexpr std::int64_t middle = Direction::elevation_bins / 2;
  const std::int64_t width = std::abs(x);
  const std::int64_t height = std::abs(y);
  const std::int64_t sum = std::max<std::int64_t>(width + height, 1);
  const std::int64_t turn = height * quarter / sum;
  const std::int64_t half = x < 0 ? 2 * quarter - turn : turn;
  const std::int64_t azimuth = y < 0 ? 4 * quarter - half : half;
  const std::int64_t level = std::abs(z) + integerRoot(x * x + y * y);
  const std::int64_t rise = std::abs(z) * middle / std::max<std::int64_t>(level, 1);
  const std::int64_t elevation = z < 0 ? middle - rise : middle + rise;
  return {static_cast<unsigned int>(azimuth % Direction::azimuth_bins),
          static_cast<unsigned int>(
              std::min<std::int64_t>(elevation, Direction::elevation_bins - 1))};
}

/** \brief The last number of each bin of a direction. */
template <unsigned int bin_count>
class DirectionTable {
public:
  /** \brief Expects what the bins at and beside one had.
   * \param[out] expected in between, by distance
   * \return false if no bin near it has a number
   */
  bool
  expect(unsigned int bin, std::uint64_t& expected) const
  {
    if (isSet(bin)) {
      expected = numbers_[bin];
      return true;
    }
    const unsigned int below = distanceBelow(bin);
    const unsigned int above = distanceAbove(bin);
    if (below == none && above == none)
      return false;
    const std::uint64_t low = below == none ? 0 : numbers_[(bin - below) % bin_count];
    const std::uint64_t high = above == none ? 0 : numbers_[(bin + above) % bin_count];
    const auto difference = static_cast<std::int64_t>(high - low);
    constexpr std::int64_t far = std::int64_t{1} << 52;
    if (below != none && above != none && difference < far && difference > -far)
      expected = low + static_cast<std::uint64_t>(
                           difference * static_cast<std::int64_t>(below) /
                           static_cast<std::int64_t>(below + above));
    else
      expected = above == none || (below != none && below <= above) ? low : high;
    return true;
  }

  void
  set(unsigned int bin, std::uint64_t number)
  {
    numbers_[bin] = number;
    set_[bin / 64] |= std::uint64_t{1} << bin % 64;
  }

private:
  static constexpr unsigned int none = 0;
  static constexpr unsigned int words = bin_count / 64;
  /** \brief How many words to either side are looked at, besides that of the bin. */
  static constexpr unsigned int reach = 2;

  bool
  isSet(unsigned int bin) const
  {
    return (set_[bin / 64] >> bin % 64 & 1) != 0;
  }

  /** \brief Bins to the next one below that has a number; the lowest follows the
   * highest. */
  unsigned int
  distanceBelow(unsigned int bin) const
  {
    const unsigned int word = bin / 64;
    std::uint64_t bits = set_[word] & ((std::uint64_t{1} << bin % 64) - 1);
    for (unsigned int i = 0;; bits = set_[(word + words - ++i) % words]) {
      if (bits != 0)
        return bin % 64 + 64 * i - highestBit64(bits);
      if (i == reach)
        return none;
    }
  }

  unsigned int
  distanceAbove(unsigned int bin) const
  {
    const unsigned int word = bin / 64;
    std::uint64_t bits = set_[word] & ~std::uint64_t{1} << bin % 64;
    for (unsigned int i = 0;; bits = set_[(word + ++i) % words]) {
      if (bits != 0)
        return 64 * i + lowestBit(bits) - bin % 64;
      if (i == reach)
        return none;
    }
  }

  static unsigned int
  highestBit64(std::uint64_t bits)
  {
    const auto high = static_cast<std::uint32_t>(bits >> 32);
    return high != 0 ? 32 + highestBit(high)
                     : highestBit(static_cast<std::uint32_t>(bits));
  }

  std::array<std::uint64_t, bin_count> numbers_{};
  std::array<std::uint64_t, words> set_{};
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
