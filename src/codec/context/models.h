#pragma once

#include "codec/context/bit_mixer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Adaptive probability that a bit is 1: fast at first, then slower
 * (doc/bitstream_context.md, "Adaptive bits"). */
struct AdaptiveBit {
  std::uint16_t probability = 0x8000; ///< of a 1, 2^16 is 1
  std::uint16_t count = 0;            ///< of bits so far, up to 16

  /** \brief Adapts to a bit.
   * \param[in] bit the bit
   * \param[in] shifts the rate after each number of bits, as 2^-shift; see learningShifts
   */
  void
  learn(bool bit, const std::array<std::uint8_t, 17>& shifts)
  {
    // The bounds prevent empty intervals in the range coder.
    constexpr std::int32_t least = 48;
    const std::int32_t target = bit ? 0x10000 - least : least;
    probability = static_cast<std::uint16_t>(
        probability +
        ((target - static_cast<std::int32_t>(probability)) >> shifts[count]));
    count = static_cast<std::uint16_t>(count + (count < shifts.size() - 1 ? 1 : 0));
  }
};

/** \brief Rates of adaptation as shifts: 1/2, 1/4, 1/8 for four bits, 1/16 for ten, then the
 * final one.
 * \param[in] slowest_shift of the final rate, 2^-slowest_shift; 4..7
 */
constexpr std::array<std::uint8_t, 17>
learningShifts(std::uint8_t slowest_shift)
{
  return {1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, slowest_shift};
}

/** \brief Model of one kind of binary decision: adaptive bits, selected by contexts.
 * \tparam WayCount number of contexts of a decision, each of which selects from its own row
 * of adaptive bits. Without mixing only the first is used.
 */
template <std::size_t WayCount>
class DecisionModel {
public:
  /** \brief The contexts of one decision. */
  struct Contexts {
    std::array<std::uint32_t, WayCount> ways; ///< index in each row
    std::uint32_t weight_set = 0;             ///< index of the weights for mixing
  };

  /** \brief A model in its initial state, as at an I-frame.
   * \param[in] is_mixing whether all contexts are used
   * \param[in] slowest_shift see learningShifts; one more is used with mixing, as the
   * weights adapt, too
   * \param[in] sizes number of contexts in each row
   * \param[in] weight_sets number of sets of weights
   */
  DecisionModel(bool is_mixing,
                std::uint8_t slowest_shift,
                const std::array<std::uint32_t, WayCount>& sizes,
                std::uint32_t weight_sets = 1)
  : shifts_(
        learningShifts(static_cast<std::uint8_t>(slowest_shift + (is_mixing ? 1 : 0))))
  {
    for (std::size_t way = 0; way < (is_mixing ? WayCount : 1); ++way)
      bits_[way].resize(sizes[way]);
    if (is_mixing && WayCount > 1)
      weights_.resize(weight_sets);
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

  MixerWeights<WayCount>&
  weights(std::uint32_t set)
  {
    return weights_[set];
  }

private:
  std::array<std::vector<AdaptiveBit>, WayCount> bits_;
  std::vector<MixerWeights<WayCount>> weights_;
  std::array<std::uint8_t, 17> shifts_;
};

/** \brief Codes one decision with the probability of one context, and adapts it.
 * \param[in,out] coder BinaryRangeEncoder or BinaryRangeDecoder
 * \param[in] bit the decision; not used by a decoder
 * \return the decision
 */
template <typename CoderT>
bool
codeAdaptively(CoderT& coder,
               AdaptiveBit& prediction,
               const std::array<std::uint8_t, 17>& shifts,
               bool bit)
{
  const bool decision = coder.code(bit, prediction.probability);
  prediction.learn(decision, shifts);
  return decision;
}

/** \brief Codes decisions with the probability of their first context.
 * \tparam CoderT BinaryRangeEncoder or BinaryRangeDecoder
 */
template <typename CoderT>
class SingleContextCoding {
public:
  static constexpr bool is_decoder = CoderT::is_decoder;
  static constexpr bool is_mixing = false;

  explicit SingleContextCoding(const CoderT& coder) : coder_(coder) {}

  CoderT&
  coder()
  {
    return coder_;
  }

  /** \brief Codes one decision and adapts its model.
   * \param[in] bit the decision; not used by a decoder
   * \return the decision
   */
  template <std::size_t WayCount>
  bool
  code(DecisionModel<WayCount>& model,
       const typename DecisionModel<WayCount>::Contexts& contexts,
       bool bit)
  {
    return codeAdaptively(coder_, model.bit(0, contexts.ways[0]), model.shifts(), bit);
  }

  /** \brief Codes a bit that bypasses the models, with probability 1/2. */
  bool
  codeBypass(bool bit)
  {
    return coder_.code(bit, 0x8000);
  }

private:
  CoderT coder_;
};

/** \brief Codes decisions with the probabilities of all their contexts, mixed.
 * \tparam CoderT BinaryRangeEncoder or BinaryRangeDecoder
 */
template <typename CoderT>
class MixedContextCoding {
public:
  static constexpr bool is_decoder = CoderT::is_decoder;
  static constexpr bool is_mixing = true;

  explicit MixedContextCoding(const CoderT& coder)
  : coder_(coder), tables_(&logisticTables())
  {}

  CoderT&
  coder()
  {
    return coder_;
  }

  /** \brief As SingleContextCoding::code. */
  template <std::size_t WayCount>
  bool
  code(DecisionModel<WayCount>& model,
       const typename DecisionModel<WayCount>::Contexts& contexts,
       bool bit)
  {
    if constexpr (WayCount == 1)
      return codeAdaptively(
          coder_, model.bit(0, contexts.ways[0]), model.shifts(), bit);
    else {
      std::array<std::int32_t, WayCount> stretched;
      for (std::size_t way = 0; way < WayCount; ++way)
        stretched[way] =
            tables_->stretch(model.bit(way, contexts.ways[way]).probability);
      MixerWeights<WayCount>& weights = model.weights(contexts.weight_set);
      const std::int32_t probability = tables_->squash(weights.mix(stretched));
      const bool decision = coder_.code(bit, static_cast<std::uint32_t>(probability));
      weights.learn(stretched, (decision ? 1 << 16 : 0) - probability);
      for (std::size_t way = 0; way < WayCount; ++way)
        model.bit(way, contexts.ways[way]).learn(decision, model.shifts());
      return decision;
    }
  }

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
} // namespace io
} // namespace pcl_ext
