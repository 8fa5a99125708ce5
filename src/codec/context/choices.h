// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief One of the alternatives of a choice: the index-th one of a class. */
struct Choice {
  std::size_t alternative_class = 0;
  std::uint32_t index = 0;
};

/** \brief Model of choices between alternatives of several classes, each of which has a
 * weight (doc/bitstream_context.md, "Choices"). An alternative's probability is its
 * share of the weight of all alternatives there are.
 * \tparam ClassCount number of classes
 */
template <std::size_t ClassCount>
class ChoiceModel {
public:
  /** \brief Numbers of alternatives of the classes of one choice, 64 at most in all. */
  using Counts = std::array<std::uint32_t, ClassCount>;

  /** \param[in] weights in the initial state, as at an I-frame, 1..1023 each */
  explicit ChoiceModel(const std::array<std::uint16_t, ClassCount>& weights)
  {
    for (std::size_t i = 0; i < ClassCount; ++i)
      weights_[i] = std::uint32_t{weights[i]} << fraction_bits;
  }

  /** \brief Weight of an alternative of a class, 1..1023. */
  std::uint32_t
  weight(std::size_t alternative_class) const
  {
    return weights_[alternative_class] >> fraction_bits;
  }

  /** \brief Weight of all alternatives, below 2^16. */
  std::uint32_t
  total(const Counts& counts) const
  {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < ClassCount; ++i)
      sum += weight(i) * counts[i];
    return sum;
  }

  /** \brief Adapts the weights to a choice: exponentiated gradient with steps of 1/16
   * (J. Kivinen, M. K. Warmuth, Exponentiated gradient versus gradient descent for
   * linear predictors, 1997).
   * \param[in] total of these counts
   */
  void
  learn(const Counts& counts, std::uint32_t total, std::size_t chosen_class)
  {
    const std::uint64_t reciprocal = (std::uint64_t{1} << 32) / total;
    for (std::size_t i = 0; i < ClassCount; ++i) {
      const auto share =
          static_cast<std::int64_t>(weight(i) * counts[i] * reciprocal >> 16);
      const std::int64_t error = (i == chosen_class ? 1 << 16 : 0) - share;
      const auto old = static_cast<std::int64_t>(weights_[i]);
      weights_[i] = static_cast<std::uint32_t>(
          std::clamp(old + ((old * error) >> 20), lightest, heaviest));
    }
  }

private:
  static constexpr unsigned int fraction_bits = 16;
  // So that each alternative has a unit of the range, and 64 of them less than 2^16.
  static constexpr std::int64_t lightest = 1 << 16;
  static constexpr std::int64_t heaviest = (1023 << 16) | 0xffff;

  std::array<std::uint32_t, ClassCount> weights_;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
