#pragma once

#include "codec/context/adaptive_bit.h"
#include "codec/context/bit_mixer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief One kind of decision that is coded as a bit, and what was learnt about it in
 * each of its contexts.
 * \tparam WayCount ways to see the surroundings of a decision. A coder that looks at one
 * context only uses the first; one that mixes uses all.
 */
template <std::size_t WayCount>
class DecisionModel {
public:
  /** \brief Surroundings of a decision. */
  struct Contexts {
    std::array<std::uint32_t, WayCount> ways;
    std::uint32_t weight_set = 0; ///< which weights mix the ways
  };

  /** \brief A model that has learnt nothing.
   * \param[in] is_mixing all ways are used
   * \param[in] slowest_shift see learningShifts; slower by half where ways are mixed, as
   * the weights follow what changes
   * \param[in] sizes number of contexts in each way
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

/** \brief Codes one decision with the probability of one context, and learns it.
 * \param[in] side BinaryRangeEncoder or BinaryRangeDecoder
 * \param[in] bit what was decided; the decoder finds it out
 * \return what was decided
 */
template <typename SideT>
bool
codeAdaptively(SideT& side,
               AdaptiveBit& prediction,
               const std::array<std::uint8_t, 17>& shifts,
               bool bit)
{
  const bool decision = side.code(bit, prediction.probability);
  prediction.learn(decision, shifts);
  return decision;
}

/** \brief Codes decisions with the probability of their first context.
 * \tparam SideT BinaryRangeEncoder or BinaryRangeDecoder
 */
template <typename SideT>
class SingleContextCoding {
public:
  static constexpr bool is_decoder = SideT::is_decoder;
  static constexpr bool is_mixing = false;

  explicit SingleContextCoding(const SideT& side) : side_(side) {}

  SideT&
  side()
  {
    return side_;
  }

  /** \brief Codes one decision and learns it.
   * \param[in] bit what was decided; the decoder finds it out
   * \return what was decided
   */
  template <std::size_t WayCount>
  bool
  code(DecisionModel<WayCount>& model,
       const typename DecisionModel<WayCount>::Contexts& contexts,
       bool bit)
  {
    return codeAdaptively(side_, model.bit(0, contexts.ways[0]), model.shifts(), bit);
  }

  /** \brief Codes a bit of which nothing is known. */
  bool
  codeRaw(bool bit)
  {
    return side_.code(bit, 0x8000);
  }

private:
  SideT side_;
};

/** \brief Codes decisions with the probabilities of all their contexts, mixed.
 * \tparam SideT BinaryRangeEncoder or BinaryRangeDecoder
 */
template <typename SideT>
class MixedContextCoding {
public:
  static constexpr bool is_decoder = SideT::is_decoder;
  static constexpr bool is_mixing = true;

  explicit MixedContextCoding(const SideT& side)
  : side_(side), tables_(&logisticTables())
  {}

  SideT&
  side()
  {
    return side_;
  }

  /** \brief As SingleContextCoding::code. */
  template <std::size_t WayCount>
  bool
  code(DecisionModel<WayCount>& model,
       const typename DecisionModel<WayCount>::Contexts& contexts,
       bool bit)
  {
    if constexpr (WayCount == 1)
      return codeAdaptively(side_, model.bit(0, contexts.ways[0]), model.shifts(), bit);
    else {
      std::array<std::int32_t, WayCount> stretched;
      for (std::size_t way = 0; way < WayCount; ++way)
        stretched[way] =
            tables_->stretch(model.bit(way, contexts.ways[way]).probability);
      MixerWeights<WayCount>& weights = model.weights(contexts.weight_set);
      const std::int32_t probability = tables_->squash(weights.mix(stretched));
      const bool decision = side_.code(bit, static_cast<std::uint32_t>(probability));
      weights.learn(stretched, (decision ? 1 << 16 : 0) - probability);
      for (std::size_t way = 0; way < WayCount; ++way)
        model.bit(way, contexts.ways[way]).learn(decision, model.shifts());
      return decision;
    }
  }

  bool
  codeRaw(bool bit)
  {
    return side_.code(bit, 0x8000);
  }

private:
  SideT side_;
  const LogisticTables* tables_;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
