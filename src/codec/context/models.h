// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/context/bit_mixer.h"
#include "codec/context/choices.h"
#include "simd/bit_operations.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Adaptive probability that a bit is 1: fast at first, then slower
 * (doc/bitstream_context.md, "Adaptive bits"). */
class AdaptiveBit {
public:
  /** \brief Probability of a 1; 2^16 is 1. */
  std::uint32_t
  probability() const
  {
    return state_ >> 16;
  }

  /** \brief Adapts to a bit.
   * \param[in] bit the bit
   * \param[in] shifts the rate after each number of bits, as 2^-shift; see
   * learningShifts
   */
  PCL_EXT_ALWAYS_INLINE void
  learn(bool bit, const std::array<std::uint8_t, 17>& shifts)
  {
    // The bounds prevent empty intervals in the range coder.
    constexpr std::int32_t least = 48;
    const std::int32_t target = bit ? 0x10000 - least : least;
    const std::uint32_t count = state_ & 0xffff;
    const std::int32_t step =
        (target - static_cast<std::int32_t>(probability())) >> shifts[count];
    state_ += (static_cast<std::uint32_t>(step) << 16) +
              (count < shifts.size() - 1 ? 1u : 0u);
  }

private:
  // The probability, and below it the number of bits so far, up to 16. In one word,
  // which is read and written once.
  std::uint32_t state_ = 0x80000000;
};

/** \brief Rates of adaptation as shifts: 1/2, 1/4, 1/8 for four bits, 1/16 for ten,
 * then the final one.
 * \param[in] slowest_shift of the final rate, 2^-slowest_shift; 4..7
 */
constexpr std::array<std::uint8_t, 17>
learningShifts(std::uint8_t slowest_shift)
{
  return {1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, slowest_shift};
}

/** \brief Model of one kind of binary decision: adaptive bits, selected by contexts.
 * \tparam WayCount number of contexts of a decision, each of which selects from its own
 * row of adaptive bits
 * \tparam BalancedWayCount number of these that effort balanced uses, the first ones
 */
template <std::size_t WayCount, std::size_t BalancedWayCount = 1>
class DecisionModel {
public:
  /** \brief Number of contexts that an effort uses. */
  static constexpr std::size_t
  wayCount(bool is_small)
  {
    return is_small ? WayCount : BalancedWayCount;
  }

  /** \brief The contexts of one decision. */
  struct Contexts {
    std::array<std::uint32_t, WayCount> ways; ///< index in each row
    std::uint32_t weight_set = 0;             ///< index of the weights for mixing
  };

  /** \brief A model in its initial state, as at an I-frame.
   * \param[in] is_small whether all contexts are used
   * \param[in] slowest_shift see learningShifts
   * \param[in] sizes number of contexts in each row
   * \param[in] weight_sets number of sets of weights
   */
  DecisionModel(bool is_small,
                std::uint8_t slowest_shift,
                const std::array<std::uint32_t, WayCount>& sizes,
                std::uint32_t weight_sets = 1)
  : shifts_(learningShifts(slowest_shift))
  {
    const std::size_t ways = wayCount(is_small);
    for (std::size_t way = 0; way < ways; ++way)
      bits_[way].resize(sizes[way]);
    if (ways > 1)
      weights_.assign(weight_sets * ways, startingWeight(ways));
  }

  AdaptiveBit&
  bit(std::size_t way, std::uint32_t context)
  {
    return bits_[way][context];
  }

  const std::array<std::uint8_t, 17>&
  shifts() const
  {
    return shifts_;
  }

  /** \brief The first of the weights of a set, one for each way that is used. */
  std::int32_t*
  weights(std::uint32_t set, std::size_t ways)
  {
    return weights_.data() + set * ways;
  }

  /** \brief Bytes of memory besides the object. */
  std::size_t
  memoryBytes() const
  {
    std::size_t bytes = weights_.size() * sizeof(weights_[0]);
    for (const std::vector<AdaptiveBit>& bits : bits_)
      bytes += bits.size() * sizeof(bits[0]);
    return bytes;
  }

private:
  std::array<std::vector<AdaptiveBit>, WayCount> bits_;
  std::vector<std::int32_t> weights_;
  std::array<std::uint8_t, 17> shifts_;
};

/** \brief Codes one decision with the probability of one context, and adapts it.
 * \param[in,out] coder BinaryRangeEncoder or BinaryRangeDecoder
 * \param[in] bit the decision; not used by a decoder
 * \return the decision
 */
template <typename CoderT>
PCL_EXT_ALWAYS_INLINE bool
codeAdaptively(CoderT& coder,
               AdaptiveBit& prediction,
               const std::array<std::uint8_t, 17>& shifts,
               bool bit)
{
  const bool decision = coder.code(bit, prediction.probability());
  prediction.learn(decision, shifts);
  return decision;
}

/** \brief Codes decisions with the probabilities of their contexts, mixed if an effort
 * uses several.
 * \tparam CoderT BinaryRangeEncoder or BinaryRangeDecoder
 * \tparam IsSmall effort small; else balanced
 */
template <typename CoderT, bool IsSmall>
class DecisionCoding {
public:
  static constexpr bool is_decoder = CoderT::is_decoder;
  static constexpr bool is_small = IsSmall;

  explicit DecisionCoding(const CoderT& coder)
  : coder_(coder), tables_(&logisticTables())
  {}

  CoderT&
  coder()
  {
    return coder_;
  }

  /** \brief Codes one decision and adapts its model.
   * \param[in] bit the decision; not used by a decoder
   * \return the decision
   */
  template <typename ModelT>
  PCL_EXT_ALWAYS_INLINE bool
  code(ModelT& model, const typename ModelT::Contexts& contexts, bool bit)
  {
    constexpr std::size_t ways = ModelT::wayCount(IsSmall);
    if constexpr (ways == 1)
      return codeFirst(model, contexts.ways[0], bit);
    else {
      std::array<std::int32_t, ways> stretched;
      for (std::size_t way = 0; way < ways; ++way)
        stretched[way] =
            tables_->stretch(model.bit(way, contexts.ways[way]).probability());
      std::int32_t* const weights = model.weights(contexts.weight_set, ways);
      const std::int32_t probability = tables_->squash(mix(weights, stretched));
      const bool decision = coder_.code(bit, static_cast<std::uint32_t>(probability));
      adaptWeights(weights, stretched, (decision ? 1 << 16 : 0) - probability);
      for (std::size_t way = 0; way < ways; ++way)
        model.bit(way, contexts.ways[way]).learn(decision, model.shifts());
      return decision;
    }
  }

  /** \brief Codes one decision with the first of its contexts alone, and adapts
   * that. */
  template <typename ModelT>
  PCL_EXT_ALWAYS_INLINE bool
  codeFirst(ModelT& model, std::uint32_t context, bool bit)
  {
    return codeAdaptively(coder_, model.bit(0, context), model.shifts(), bit);
  }

  /** \brief Codes a choice and adapts its model.
   * \param[in] counts numbers of alternatives of the classes, not all 0
   * \param[in] choice what is chosen; not used by a decoder
   * \return what is chosen
   */
  template <std::size_t ClassCount>
  Choice
  codeChoice(ChoiceModel<ClassCount>& model,
             const std::array<std::uint32_t, ClassCount>& counts,
             Choice choice)
  {
    const std::uint32_t total = model.total(counts);
    const std::uint32_t unit = coder_.beginShare(total);
    std::uint32_t begin = 0;
    std::size_t chosen = 0;
    for (;; ++chosen) {
      const std::uint32_t size = model.weight(chosen) * counts[chosen];
      if (is_decoder ? unit < begin + size : chosen == choice.alternative_class)
        break;
      begin += size;
    }
    const std::uint32_t weight = model.weight(chosen);
    const std::uint32_t index = is_decoder ? (unit - begin) / weight : choice.index;
    begin += weight * index;
    coder_.endShare(begin, weight, begin + weight == total);
    model.learn(counts, total, chosen);
    return {chosen, index};
  }

  /** \brief Codes a bit that bypasses the models, with probability 1/2. */
  bool
  codeBypass(bool bit)
  {
    return coder_.code(bit, 0x8000);
  }

private:
  CoderT coder_;
  const LogisticTables* tables_;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
