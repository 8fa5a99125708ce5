// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/scan/number_symbols.h"
#include "codec/scan/scan_frame.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace pcl_ext {
namespace io {
namespace scan {

/** \brief Numbers of a plane are below it, so that no sum of three of their distances
 * wraps. */
constexpr std::uint32_t number_end = std::uint32_t{1} << 30;

/** \brief In the place of a number: a pixel without a point. */
constexpr std::uint32_t no_number = ~std::uint32_t{0};

/** \brief Symbols of that, and of at_sensor, which may be in the place of a depth. */
constexpr unsigned int no_number_symbol = number_symbol_count;
constexpr unsigned int at_sensor_symbol = no_number_symbol + 1;

/** \brief Symbol in front of the depth of a point beside its ray, and contexts of that
 * depth and of the steps that follow it. */
constexpr unsigned int beside_symbol = at_sensor_symbol + 1;

constexpr bool
isNumber(std::uint32_t number)
{
  return number < number_end;
}

/** \brief Contexts of a pixel. Where numbers are missing around it, they tell which ones,
 * and whether there was one in the frame before; else how much those around differ, and
 * how far they were from what was expected. */
constexpr std::size_t missing_contexts = 3 * 16;
constexpr std::size_t error_contexts = 24;
constexpr std::size_t gradient_contexts = 5;
constexpr std::size_t beside_contexts = 4;
/** \brief The number of 0 steps; there are fewer in either direction. */
constexpr std::uint32_t zero_steps = number_end / 2;
constexpr std::size_t first_beside_context =
    missing_contexts + error_contexts * gradient_contexts;
constexpr std::size_t run_context = first_beside_context + beside_contexts;
constexpr std::size_t plane_contexts = run_context + 1;

/** \brief An image of numbers, row after row. */
struct Plane {
  std::uint32_t width;
  std::uint32_t height;
  std::vector<std::uint32_t>& numbers; ///< or no_number, at_sensor
};

/** \brief Codes the numbers of a plane, for either direction. */
template <class CodingT>
class PlanePass {
public:
  using BesideT = std::conditional_t<CodingT::is_decoder,
                                     std::vector<PointBesideRay>,
                                     const std::vector<PointBesideRay>>;

  /** \param[in] first what the first number is expected to be
   * \param[in] past the plane of the frame before, of the same size; null: none
   */
  PlanePass(const Plane& plane, std::uint32_t first, const std::uint32_t* past)
  : plane_(plane)
  , past_(past)
  , errors_(plane.width + std::size_t{1})
  , nothing_(plane.width + std::size_t{1}, no_number)
  , last_(first)
  {}

  /** \brief Codes depths, and which pixels have one.
   * \param[in,out] beside points that are beside their rays, by pixel; a
   * std::vector<PointBesideRay>, which the decoder appends to
   * \return false if what was decoded is no plane
   */
  bool
  codeDepths(CodingT& coding, BesideT& beside)
  {
    beside_ = &beside;
    return run<true>(coding) && (CodingT::is_decoder || next_beside_ == beside.size());
  }

  /** \brief Codes the values of pixels that have one; the others stay what they are.
   * \return false if what was decoded is no plane
   */
  bool
  codeValues(CodingT& coding)
  {
    return run<false>(coding);
  }

private:
  template <bool is_depths>
  bool
  run(CodingT& coding)
  {
    for (std::uint32_t row = 0; row < plane_.height; ++row) {
      // Row by row, so that a forged size takes no more memory than there are bytes for.
      if (CodingT::is_decoder && is_depths)
        plane_.numbers.resize((row + std::size_t{1}) * plane_.width);
      if (!codeRow<is_depths>(coding, row))
        return false;
    }
    return true;
  }

  /** \brief What a number is expected from. */
  enum Source : std::size_t { from_edge, from_mean, from_past, source_count };

  /** \brief Numbers around a pixel, or no_number. */
  struct Around {
    std::uint32_t left;
    std::uint32_t up;
    std::uint32_t up_left;
    std::uint32_t up_right;
  };

  static std::uint32_t
  distance(std::uint32_t a, std::uint32_t b)
  {
    return a > b ? a - b : b - a;
  }

  /** \brief Half octaves of an error. */
  static std::size_t
  errorClass(std::uint32_t error)
  {
    const std::uint32_t odd = 2 * std::min(error, number_end / 4) + 1;
    const unsigned int octave = highestBit(odd);
    const unsigned int half = (2 * odd >> octave) & 1;
    return std::min<std::size_t>(2 * octave + half, error_contexts - 1);
  }

  static std::size_t
  contextOf(std::uint32_t gradient, std::uint32_t error)
  {
    const unsigned int of_gradient = highestBit(gradient + 1);
    const unsigned int of_error = highestBit(error + 1);
    const std::size_t relation = gradient == 0                 ? 0
                                 : of_gradient + 2 < of_error  ? 1
                                 : of_gradient < of_error + 1  ? 2
                                 : of_gradient == of_error + 1 ? 3
                                                               : 4;
    return missing_contexts + relation * error_contexts + errorClass(error);
  }

  /** \brief What a number is expected to be, with left and up there.
   * \param[out] gradient how much those around differ
   */
  static std::array<std::uint32_t, source_count>
  expect(const Around& around, std::uint32_t past, std::uint32_t& gradient)
  {
    const std::uint32_t low = std::min(around.left, around.up);
    const std::uint32_t high = std::max(around.left, around.up);
    const std::uint32_t mean = (low + high) / 2;
    const std::uint32_t corner = isNumber(around.up_left) ? around.up_left : mean;
    const std::uint32_t right = isNumber(around.up_right) ? around.up_right : around.up;
    gradient = distance(around.left, corner) + distance(around.up, corner) +
               distance(right, around.up);
    const std::uint32_t edge = corner >= high  ? low
                               : corner <= low ? high
                                               : low + high - corner;
    const std::int32_t slope = static_cast<std::int32_t>(right - corner) >> 2;
    const std::int32_t sloped = std::clamp(static_cast<std::int32_t>(mean) + slope,
                                           static_cast<std::int32_t>(low),
                                           static_cast<std::int32_t>(high));
    return {edge, static_cast<std::uint32_t>(sloped), past};
  }

  Source
  bestSource(bool has_past) const
  {
    const Source best = costs_[from_mean] < costs_[from_edge] ? from_mean : from_edge;
    return has_past && costs_[from_past] < costs_[best] ? from_past : best;
  }

  void
  learn(const std::array<std::uint32_t, source_count>& expected,
        bool has_past,
        std::uint32_t number)
  {
    for (std::size_t source = 0; source < (has_past ? 3u : 2u); ++source) {
      const std::uint32_t cost = highestBit(2 * distance(expected[source], number) + 1);
      costs_[source] += 64 * cost - costs_[source] / 64;
    }
  }

  static bool
  isNothing(const Around& around)
  {
    return !isNumber(around.left) && !isNumber(around.up) &&
           !isNumber(around.up_left) && !isNumber(around.up_right);
  }

  /** \brief Codes how many pixels have no number where those around have none, either:
   * 0 for all until there is one in the row above, or else one more.
   * \param[in] left pixels of the run are as that one
   * \return how many
   */
  std::uint32_t
  codeRun(CodingT& coding,
          std::uint32_t left,
          const std::uint32_t* above,
          std::uint32_t* numbers,
          std::uint32_t first)
  {
    const std::uint32_t filler = left == at_sensor ? at_sensor : no_number;
    std::uint32_t end = first;
    while (end < plane_.width && (end + 1 == plane_.width || !isNumber(above[end + 1])))
      ++end;
    std::uint32_t run = 0;
    if constexpr (!CodingT::is_decoder) {
      while (first + run < end && numbers[first + run] == filler)
        ++run;
    }
    NumberParts parts = partsOf(first + run == end ? 0 : run + 1);
    parts.symbol = coding.code(run_context, parts.symbol);
    if (parts.symbol >= number_symbol_count)
      return no_number;
    std::uint32_t coded = parts.symbol;
    if (coded >= exact_numbers)
      coded =
          numberOf(parts.symbol, coding.codeBits(lowBitsOf(parts.symbol), parts.low));
    run = coded == 0 ? end - first : coded - 1;
    // One of all pixels is coded as 0.
    if (CodingT::is_decoder && coded > end - first)
      return no_number;
    std::fill(errors_.begin() + first, errors_.begin() + first + run, 0);
    if constexpr (CodingT::is_decoder)
      std::fill(numbers + first, numbers + first + run, filler);
    return run;
  }

  /** \brief A pixel's context, and what its number is expected to be. */
  struct Expectation {
    std::array<std::uint32_t, source_count> all;
    std::uint32_t number;
    std::size_t context;
    bool is_inside; // left and up are there
  };

  Expectation
  expectAt(const Around& around,
           std::uint32_t past,
           std::uint32_t left_error,
           std::size_t column) const
  {
    Expectation expectation;
    expectation.is_inside = isNumber(around.left) && isNumber(around.up);
    if (expectation.is_inside) {
      std::uint32_t gradient;
      expectation.all = expect(around, past, gradient);
      expectation.number = expectation.all[bestSource(isNumber(past))];
      expectation.context =
          past_ != nullptr && !isNumber(past)
              ? contextOfMissing(around, past)
              : contextOf(gradient, left_error + errors_[column] + errors_[column + 1]);
      return expectation;
    }
    expectation.number = isNumber(around.left)       ? around.left
                         : isNumber(around.up)       ? around.up
                         : isNumber(around.up_right) ? around.up_right
                                                     : last_;
    expectation.context = contextOfMissing(around, past);
    return expectation;
  }

  /** \brief The context of a pixel that may well have no number: as some around it have
   * none, or it had none in the frame before. */
  std::size_t
  contextOfMissing(const Around& around, std::uint32_t past) const
  {
    const std::size_t past_context = past_ == nullptr ? 0 : isNumber(past) ? 1 : 2;
    return 16 * past_context | (isNumber(around.left) ? 1u : 0u) |
           (isNumber(around.up) ? 2u : 0u) | (isNumber(around.up_left) ? 4u : 0u) |
           (isNumber(around.up_right) ? 8u : 0u);
  }

  template <bool is_depths>
  bool
  codeRow(CodingT& coding_now, std::uint32_t row)
  {
    const std::size_t begin = std::size_t{row} * plane_.width;
    std::uint32_t* const numbers = plane_.numbers.data() + begin;
    const std::uint32_t* const above =
        row > 0 ? numbers - plane_.width : nothing_.data();
    const std::uint32_t* const past = past_ != nullptr ? past_ + begin : nullptr;
    // A point has the length of a run before it, and five numbers beside its ray.
    const std::size_t most = !is_depths ? 1 : beside_->empty() ? 2 : 6;
    coding_now.reserve(most * plane_.width);
    CodingT coding = coding_now; // in registers
    Around around{no_number, no_number, no_number, above[0]};
    std::uint32_t left_error = 0;
    for (std::uint32_t column = 0; column < plane_.width; ++column) {
      around.up_left = around.up;
      around.up = around.up_right;
      around.up_right = column + 1 < plane_.width ? above[column + 1] : no_number;
      if (!is_depths && plane_.height == 1 && column > 1) {
        // There is no row above: what is further to the left is in its place.
        around.up = numbers[column - 2];
        around.up_left = around.left;
        around.up_right = around.left;
        errors_[column] = errors_[column - 2];
      }
      if (is_depths && isNothing(around)) {
        const std::uint32_t run = codeRun(coding, around.left, above, numbers, column);
        if (coding.isOverrun() || run > plane_.width - column)
          return false;
        column += run;
        if (column == plane_.width)
          break;
        around.left = run > 0 ? numbers[column - 1] : around.left;
        left_error = run > 0 ? 0 : left_error;
        around.up_right = column + 1 < plane_.width ? above[column + 1] : no_number;
      }
      std::uint32_t number = numbers[column];
      if (is_depths || isNumber(number)) {
        const std::uint32_t past_number = past != nullptr ? past[column] : no_number;
        const Expectation expected = expectAt(around, past_number, left_error, column);
        number = codeNumber<is_depths>(
            coding, expected.context, expected.number, number, begin + column);
        if constexpr (CodingT::is_decoder) {
          if (coding.isOverrun() || (number >= number_end && number < at_sensor))
            return false;
          numbers[column] = number;
        }
        left_error = 0;
        if (isNumber(number)) {
          last_ = number;
          left_error = distance(number, expected.number);
          if (expected.is_inside)
            learn(expected.all, isNumber(past_number), number);
        }
      }
      else {
        left_error = 0;
      }
      around.left = number;
      errors_[column] = left_error;
    }
    coding_now = coding;
    return true;
  }

  /** \brief Codes a number, or with is_depths what may be in its place.
   * \return what was coded; number_end: not a number
   */
  template <bool is_depths>
  std::uint32_t
  codeNumber(CodingT& coding,
             std::size_t context,
             std::uint32_t expected,
             std::uint32_t number,
             std::size_t pixel)
  {
    NumberParts parts{no_number_symbol + (no_number - number), 0, 0};
    if (!CodingT::is_decoder && isNumber(number)) {
      parts = partsOf(zigzag(static_cast<std::int32_t>(number - expected)));
      if (is_depths && isBeside(pixel))
        parts.symbol = beside_symbol;
    }
    parts.symbol = coding.code(context, parts.symbol);
    if (parts.symbol < number_symbol_count)
      return numberFrom(coding, expected, parts);
    if (!is_depths)
      return number_end;
    return parts.symbol == beside_symbol
               ? codeBeside(coding, expected, number, pixel)
               : no_number - (parts.symbol - no_number_symbol);
  }

  /** \brief Codes the low bits of a number whose symbol was coded.
   * \return the number; number_end: not a number
   */
  static std::uint32_t
  numberFrom(CodingT& coding, std::uint32_t expected, NumberParts parts)
  {
    std::uint32_t size = parts.symbol;
    if (size >= exact_numbers)
      size =
          numberOf(parts.symbol, coding.codeBits(lowBitsOf(parts.symbol), parts.low));
    const std::uint32_t number = expected + static_cast<std::uint32_t>(unzigzag(size));
    return isNumber(number) ? number : number_end;
  }

  bool
  isBeside(std::size_t pixel) const
  {
    return next_beside_ < beside_->size() && (*beside_)[next_beside_].pixel == pixel;
  }

  /** \brief Codes the depth of a point beside its ray, and how far it is from there. */
  PCL_EXT_NEVER_INLINE std::uint32_t
  codeBeside(CodingT& coding,
             std::uint32_t expected,
             std::uint32_t number,
             std::size_t pixel)
  {
    const auto code =
        [&coding](std::size_t context, std::uint32_t near, std::uint32_t value) {
          NumberParts parts = partsOf(zigzag(static_cast<std::int32_t>(value - near)));
          parts.symbol = coding.code(first_beside_context + context, parts.symbol);
          return parts.symbol < number_symbol_count ? numberFrom(coding, near, parts)
                                                    : number_end;
        };
    number = code(0, expected, number);
    if constexpr (CodingT::is_decoder)
      beside_->push_back({static_cast<std::uint32_t>(pixel), {}});
    auto& steps = (*beside_)[next_beside_++].steps;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t step = code(
          1 + axis, zero_steps, zero_steps + static_cast<std::uint32_t>(steps[axis]));
      if (step == number_end)
        return number_end;
      if constexpr (CodingT::is_decoder)
        steps[axis] = static_cast<std::int32_t>(step - zero_steps);
    }
    return number;
  }

  const Plane plane_;
  BesideT* beside_ = nullptr;
  std::size_t next_beside_ = 0;
  const std::uint32_t* past_;
  std::vector<std::uint32_t> errors_;  // of the row above, then of the current one
  std::vector<std::uint32_t> nothing_; // the row above the first one
  std::array<std::uint32_t, source_count> costs_{};
  std::uint32_t last_;
};

} // namespace scan
} // namespace io
} // namespace pcl_ext
