// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"
#include "simd/bit_operations.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Number of interleaved rANS states: one takes fewer bytes, four less time
 * (doc/implementation_notes.md, "Four rANS states"). */
enum class Interleaving { One, Four };

/** \brief Each 2^43 / width, rounded up. Multiplying by it divides a number x below
 * 2^19 * width exactly by the width, as the error is below x / 2^43 < 1 / width. */
extern const std::array<std::uint64_t, probability_one> reciprocals;
constexpr unsigned int reciprocal_bits = 43;

/** \brief A range of probabilities in one number. */
constexpr std::uint32_t
packed(ProbabilityRange range)
{
  return range.start | range.width << 16;
}

/** \brief Encodes symbols, the last one first. Loops use a copy, which stays in
 * registers. */
class ReverseEncoder {
public:
  static constexpr std::size_t state_bytes = 4;
  static constexpr std::uint32_t lowest_state = std::uint32_t{1} << 15;

  /** \param[in] count of symbols
   * \param[in,out] words memory, which must outlive the encoder
   */
  ReverseEncoder(std::size_t count,
                 Interleaving interleaving,
                 std::vector<std::uint16_t>& words);

  /** \brief Encodes the symbol before the last one.
   * \param[in] range packed()
   */
  void
  push(std::uint32_t range)
  {
    std::uint32_t& state = states_[--left_ & last_state_];
    state = pushed(state, range, word_);
  }

  /** \brief Encodes symbols, the last one first. */
  void
  push(const std::uint32_t* ranges, std::size_t count);

  /** \brief Appends the bytes of all symbols. */
  void
  finish(std::vector<std::uint8_t>& bytes) const;

private:
  /** \brief The state after a symbol. */
  static std::uint32_t
  pushed(std::uint32_t state, std::uint32_t range, std::uint16_t*& word)
  {
    const std::uint32_t start = range & 0xffff;
    const std::uint32_t width = range >> 16;
    // Without a branch: the word is written in any case, and overwritten if not needed.
    word[-1] = static_cast<std::uint16_t>(state);
    std::uint32_t high = state >> 16;
    std::uint16_t* next_word = word - 1;
    replaceIfBelow(width << 3, high, state, next_word, word);
    state = high;
    word = next_word;
    const auto quotient =
        static_cast<std::uint32_t>(state * reciprocals[width] >> reciprocal_bits);
    return state + start + quotient * (probability_one - width);
  }

  std::array<std::uint32_t, 4> states_;
  std::size_t left_;
  std::size_t last_state_; // index
  std::uint16_t* word_;    // written last; they begin with the last one
  std::uint16_t* words_end_;
};

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
