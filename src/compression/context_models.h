#pragma once

#include "adaptive_bit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief One kind of decision that is coded as a bit, and what was learnt about it in
 * each of its contexts.
 * \tparam ContextCount ways to see the surroundings of one decision; the first is the
 * one that a coder uses that looks at one context only
 */
template <std::size_t ContextCount>
class DecisionModel {
public:
  /** \brief The context of a decision in each of the ways to see it. */
  using Contexts = std::array<std::uint32_t, ContextCount>;

  /** \brief A model that has learnt nothing.
   * \param[in] sizes contexts that there are in each way to see a decision
   * \param[in] slowest_shift see learningShifts
   */
  DecisionModel(const std::array<std::uint32_t, ContextCount>& sizes,
                std::uint8_t slowest_shift)
  : shifts_(learningShifts(slowest_shift))
  {
    for (std::size_t i = 0; i < ContextCount; ++i)
      bits_[i].resize(sizes[i]);
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

private:
  std::array<std::vector<AdaptiveBit>, ContextCount> bits_;
  std::array<std::uint8_t, 17> shifts_;
};

/** \brief Codes decisions with the probability of their first context.
 * \tparam SideT BinaryRangeEncoder or BinaryRangeDecoder
 */
template <typename SideT>
class SingleContextCoding {
public:
  static constexpr bool is_decoder = SideT::is_decoder;
  static constexpr bool is_mixing = false;

  explicit SingleContextCoding(SideT& side) : side_(side) {}

  /** \brief Codes one decision and learns it.
   * \param[in] bit what was decided; the decoder finds it out
   * \return what was decided
   */
  template <std::size_t ContextCount>
  bool
  code(DecisionModel<ContextCount>& model,
       const typename DecisionModel<ContextCount>::Contexts& contexts,
       bool bit)
  {
    AdaptiveBit& prediction = model.bit(0, contexts[0]);
    const bool decision = side_.code(bit, prediction.probability);
    prediction.learn(decision, model.shifts());
    return decision;
  }

  /** \brief Codes a bit of which nothing is known. */
  bool
  codeRaw(bool bit)
  {
    return side_.code(bit, 0x8000);
  }

private:
  SideT& side_;
};

} // namespace io
} // namespace pcl_ext
