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

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Numbers of a plane are below it, so that no sum of three of their distances
 * wraps. */
constexpr std::uint32_t number_end = std::uint32_t{1} << 30;

/** \brief In the place of a number: a pixel without a point. */
constexpr std::uint32_t no_number = ~std::uint32_t{0};

/** \brief Words of that, and of at_sensor, which may be in the place of a depth. */
constexpr std::uint64_t no_number_word = first_word;
constexpr std::uint64_t at_sensor_word = first_word + 1;

/** \brief Word in front of the depth of a point beside its ray, and contexts of that
 * depth and of the steps that follow it. */
constexpr std::uint64_t beside_word = first_word + 2;

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

/** \brief How a gradient compares with the errors around, by the octave of one more than
 * it and the class of these. */
constexpr auto gradient_relations = [] {
  std::array<std::array<std::uint8_t, error_contexts>, 32> relations{};
  for (std::size_t gradient = 1; gradient < relations.size(); ++gradient)
    for (std::size_t error_class = 0; error_class < error_contexts; ++error_class) {
      const std::size_t error = (std::max<std::size_t>(error_class, 1) - 1) / 2;
      relations[gradient][error_class] = gradient + 2 < error    ? 1
                                         : gradient <= error     ? 2
                                         : gradient == error + 1 ? 3
                                                                 : 4;
    }
  return relations;
}();

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
    moveTo(0);
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
    if constexpr (!CodingT::is_decoder)
      around_source_ = cheaperSource();
    coding.reserve(1);
    const std::uint64_t source = coding.code(run_context, around_source_);
    if (source > from_mean)
      return false;
    around_source_ = static_cast<Source>(source);
    best_ = around_source_;
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
  enum Source : std::uint8_t { from_edge, from_mean, from_past, source_count };

  /** \brief Numbers around a pixel, or what is in their places. */
  struct Around {
    std::uint32_t left;
    std::uint32_t up;
    std::uint32_t up_left;
    std::uint32_t up_right;
  };

  /** \brief A pixel's context, and what its number is expected to be. */
  struct Expectation {
    std::uint32_t number;
    std::size_t context;
  };

  static std::uint32_t
  distance(std::uint32_t a, std::uint32_t b)
  {
    return a > b ? a - b : b - a;
  }

  static bool
  areNumbers(const Around& around)
  {
    // Whatever else is there has higher bits.
    return isNumber(around.left | around.up | around.up_left | around.up_right);
  }

  static bool
  isNothing(const Around& around)
  {
    return !isNumber(around.left) && !isNumber(around.up) &&
           !isNumber(around.up_left) && !isNumber(around.up_right);
  }

  /** \brief The same with numbers in the upper corners, with left and up there. */
  static Around
  completed(Around around)
  {
    if (!isNumber(around.up_left))
      around.up_left = (around.left + around.up) / 2;
    if (!isNumber(around.up_right))
      around.up_right = around.up;
    return around;
  }

  /** \brief Half octaves of an error. */
  static std::size_t
  errorClass(std::uint32_t error)
  {
    const std::uint32_t odd = 2 * std::min(error, number_end / 4) + 1;
    const unsigned int octave = highestBit(odd);
    const unsigned int half = 2 * odd >> octave & 1;
    return std::min<std::size_t>(2 * octave + half, error_contexts - 1);
  }

  /** \brief The number in one of the sources, between left and up but for the past. */
  static std::uint32_t
  expectFrom(Source source, const Around& around, std::uint32_t past)
  {
    if (source == from_past)
      return past;
    const auto left = static_cast<std::int32_t>(around.left);
    const auto up = static_cast<std::int32_t>(around.up);
    const auto corner = static_cast<std::int32_t>(around.up_left);
    const auto right = static_cast<std::int32_t>(around.up_right);
    const std::int32_t number = source == from_edge
                                    ? left + up - corner
                                    : (left + up) / 2 + ((right - corner) >> 2);
    return static_cast<std::uint32_t>(
        std::max(std::min(left, up), std::min(std::max(left, up), number)));
  }

  /** \brief What a number is expected to be with left or up missing. */
  std::uint32_t
  expectOutside(const Around& around) const
  {
    return isNumber(around.left)       ? around.left
           : isNumber(around.up)       ? around.up
           : isNumber(around.up_right) ? around.up_right
                                       : last_;
  }

  /** \brief The context of a pixel with numbers around it.
   * \param[in] error how far those were from what was expected, in all
   */
  static std::size_t
  contextOf(const Around& around, std::uint32_t error)
  {
    const std::uint32_t gradient = distance(around.left, around.up_left) +
                                   distance(around.up, around.up_left) +
                                   distance(around.up_right, around.up);
    const std::size_t error_class = errorClass(error);
    const std::size_t relation =
        gradient_relations[highestBit(gradient + 1)][error_class];
    return missing_contexts + relation * error_contexts + error_class;
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

  /** \brief About how many bits the distance of two numbers takes. */
  static std::uint32_t
  costOf(std::uint32_t a, std::uint32_t b)
  {
    return highestBit(2 * distance(a, b) + 1);
  }

  /** \brief Edge or mean: that from which the numbers of some rows are less far. */
  Source
  cheaperSource() const
  {
    constexpr std::uint32_t rows = 8; // one of so many
    std::array<std::uint64_t, 2> costs{};
    for (std::uint32_t row = std::min(plane_.height, rows) - 1; row < plane_.height;
         row += rows) {
      const std::uint32_t* const numbers =
          plane_.numbers.data() + std::size_t{row} * plane_.width;
      for (std::uint32_t column = 2; column + 1 < plane_.width; ++column) {
        const std::uint32_t* const at = numbers + column;
        const std::uint32_t* const up = row > 0 ? at - plane_.width : at;
        const Around around = row > 0 ? Around{at[-1], up[0], up[-1], up[1]}
                                      : Around{at[-1], at[-2], at[-1], at[-1]};
        if (areNumbers(around) && isNumber(*at))
          for (const Source source : {from_edge, from_mean})
            costs[source] += costOf(expectFrom(source, around, no_number), *at);
      }
    }
    return costs[from_mean] < costs[from_edge] ? from_mean : from_edge;
  }

  /** \brief Learns what a number would have cost from around, and from the past. Which
   * is better is told by the numbers before, so that nothing waits for this one. */
  void
  learn(const Around& around, std::uint32_t past, std::uint32_t number)
  {
    best_ = costs_[from_past] < costs_[around_source_] ? from_past : around_source_;
    for (const Source source : {around_source_, from_past})
      costs_[source] +=
          64 * costOf(expectFrom(source, around, past), number) - costs_[source] / 64;
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
    std::uint32_t end = std::max(first, run_end_); // a run before has looked so far
    while (end < plane_.width && (end + 1 == plane_.width || !isNumber(above[end + 1])))
      ++end;
    run_end_ = end;
    std::uint32_t run = 0;
    if constexpr (!CodingT::is_decoder) {
      while (first + run < end && numbers[first + run] == filler)
        ++run;
    }
    const std::uint64_t coded =
        coding.code(run_context, first + run == end ? 0 : run + 1);
    // One of all pixels is coded as 0.
    if (CodingT::is_decoder && coded > end - first)
      return no_number;
    run = coded == 0 ? end - first : static_cast<std::uint32_t>(coded - 1);
    std::fill(errors_.begin() + first, errors_.begin() + first + run, 0);
    if constexpr (CodingT::is_decoder)
      std::fill(numbers + first, numbers + first + run, filler);
    return run;
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
    run_end_ = 0;
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
      std::uint32_t error = 0;
      if (is_depths || isNumber(number)) {
        const std::uint32_t past_number = past != nullptr ? past[column] : no_number;
        const bool is_inside =
            areNumbers(around) || (isNumber(around.left) && isNumber(around.up));
        const Around inside = areNumbers(around) ? around : completed(around);
        const bool has_past = isNumber(past_number);
        Expectation expected;
        expected.number =
            is_inside
                ? expectFrom(has_past ? best_ : around_source_, inside, past_number)
                : expectOutside(around);
        expected.context =
            is_inside && (past == nullptr || has_past)
                ? contextOf(inside, left_error + errors_[column] + errors_[column + 1])
                : contextOfMissing(around, past_number);
        number = codeNumber<is_depths>(coding, expected, number, begin + column);
        if constexpr (CodingT::is_decoder) {
          if (coding.isOverrun() || (number >= number_end && number < at_sensor))
            return false;
          numbers[column] = number;
        }
        if (isNumber(number)) {
          last_ = number;
          error = distance(number, expected.number);
          if (is_inside && has_past && column % 4 == 0)
            learn(inside, past_number, number);
        }
      }
      left_error = error;
      around.left = number;
      errors_[column] = error;
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
             const Expectation& expected,
             std::uint32_t number,
             std::size_t pixel)
  {
    std::uint64_t value = 0;
    if constexpr (!CodingT::is_decoder) {
      value = isNumber(number) ? offOf(number, expected.number)
                               : no_number_word + (no_number - number);
      if (is_depths && pixel == next_beside_pixel_)
        value = beside_word;
    }
    value = coding.code(expected.context, value);
    if (value < first_word)
      return numberAt(value, expected.number);
    if (!is_depths)
      return number_end;
    return value == beside_word
               ? codeBeside(coding, expected.number, number, pixel)
               : no_number - static_cast<std::uint32_t>(value - no_number_word);
  }

  /** \brief What is coded of a number. */
  static std::uint64_t
  offOf(std::uint32_t number, std::uint32_t expected)
  {
    return zigzag(static_cast<std::int32_t>(number - expected));
  }

  /** \brief Inverse of offOf(); number_end: not a number. */
  static std::uint32_t
  numberAt(std::uint64_t off, std::uint32_t expected)
  {
    if (off >= first_word)
      return number_end;
    const std::uint32_t number =
        expected +
        static_cast<std::uint32_t>(unzigzag(static_cast<std::uint32_t>(off)));
    return std::min(number, number_end);
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
          return numberAt(
              coding.code(first_beside_context + context, offOf(value, near)), near);
        };
    number = code(0, expected, number);
    if constexpr (CodingT::is_decoder)
      beside_->push_back({static_cast<std::uint32_t>(pixel), {}});
    auto& steps = (*beside_)[next_beside_].steps;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t step = code(
          1 + axis, zero_steps, zero_steps + static_cast<std::uint32_t>(steps[axis]));
      if (step == number_end)
        return number_end;
      if constexpr (CodingT::is_decoder)
        steps[axis] = static_cast<std::int32_t>(step - zero_steps);
    }
    moveTo(next_beside_ + 1);
    return number;
  }

  /** \brief Goes to a point beside its ray. */
  void
  moveTo(std::size_t beside)
  {
    next_beside_ = beside;
    next_beside_pixel_ =
        beside < beside_->size() ? (*beside_)[beside].pixel : ~std::size_t{0};
  }

  const Plane plane_;
  BesideT* beside_ = nullptr;
  std::size_t next_beside_ = 0;
  std::size_t next_beside_pixel_ = ~std::size_t{0};
  const std::uint32_t* past_;
  std::vector<std::uint32_t> errors_;  // of the row above, then of the current one
  std::vector<std::uint32_t> nothing_; // the row above the first one
  std::uint32_t run_end_ = 0;          // up to where a run of the row may go
  std::array<std::uint32_t, source_count> costs_{};
  Source around_source_ = from_edge; // or from_mean
  Source best_ = from_edge;          // of that and the past
  std::uint32_t last_;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
