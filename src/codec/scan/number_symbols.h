// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Numbers below this are symbols of their own; above them there are two symbols
 * an octave, and the bits below these two are sent as they are. */
constexpr std::uint32_t exact_numbers = 16;
constexpr unsigned int exact_bits = 4;

/** \brief Number of symbols of numbers below 2^32. */
constexpr unsigned int number_symbol_count = exact_numbers + 2 * (32 - exact_bits);

/** \brief A number in parts. */
struct NumberParts {
  unsigned int symbol;
  std::uint32_t low; ///< bits below the two highest ones, if there are such
};

/** \brief What is coded is a number, below this, or from this on a word, which has a
 * symbol of its own: no point, at the sensor, beside its ray. */
constexpr std::uint64_t first_word = std::uint64_t{1} << 32;

/** \brief Splits a number. Without branches, which would be taken at random. */
inline NumberParts
partsOf(std::uint32_t number)
{
  const unsigned int octave = highestBit(number | (exact_numbers - 1));
  const unsigned int bits = octave - 1;
  const unsigned int symbol =
      exact_numbers + 2 * (octave - exact_bits) + (number >> bits & 1);
  const bool is_exact = number < exact_numbers;
  return {is_exact ? number : symbol, number & ((std::uint32_t{1} << bits) - 1)};
}

/** \brief Number of low bits of a symbol's numbers. */
constexpr unsigned int
lowBitsOf(unsigned int symbol)
{
  return symbol < exact_numbers ? 0 : (symbol - exact_numbers) / 2 + exact_bits - 1;
}

/** \brief Puts the parts together.
 * \param[in] symbol at least exact_numbers
 * \param[in] low below 2^lowBitsOf(symbol)
 */
constexpr std::uint32_t
numberOf(unsigned int symbol, std::uint32_t low)
{
  return (2 + (symbol & 1)) << lowBitsOf(symbol) | low;
}

/** \brief 0, -1, 1, -2, ... as 0, 1, 2, 3, ... */
constexpr std::uint32_t
zigzag(std::int32_t number)
{
  const auto bits = static_cast<std::uint32_t>(number);
  return number < 0 ? ~(bits << 1) : bits << 1;
}

/** \brief Inverse of zigzag(). */
constexpr std::int32_t
unzigzag(std::uint32_t number)
{
  return static_cast<std::int32_t>((number & 1) != 0 ? ~(number >> 1) : number >> 1);
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
