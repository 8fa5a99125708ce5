// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/context/local_expectation.h"
#include "codec/context/models.h"
#include "codec/depth_split.h"

#include <algorithm>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Models of intensity symbols (doc/bitstream_context.md, "Symbols"). */
struct IntensityContexts {
  static constexpr std::uint32_t longest_residual = 32;
  // Bits of what follows the longest residual, and the highest symbol of points.
  static constexpr std::uint32_t longest_escape = 17;
  static constexpr std::uint32_t longest_excess = 32;

  // Numbers of classes of what a symbol is expected to be.
  static constexpr std::uint32_t levels = 48;
  static constexpr std::uint32_t classes = 8; ///< at a level, and without one
  static constexpr std::uint32_t local_levels = 36;
  static constexpr std::uint32_t local_errors = 4;
  static constexpr std::uint32_t averages = 24;
  static constexpr std::uint32_t scales = 16;
  static constexpr std::uint32_t widths = 8;
  static constexpr std::uint32_t distances = 21; ///< on either side
  /** \brief Bits of a symbol, highest first, whose values select contexts. */
  static constexpr std::uint32_t prefixes = 16;
  /** \brief First node of the lengths below the expected one. */
  static constexpr std::uint32_t shorter = 96;
  static constexpr std::uint32_t nodes = 112;
  /** \brief Encoder only: frames coded without neighbours before these are tried
   * again. */
  static constexpr unsigned int frames_without = 7;
  // Rows of a context for each node: of records, of local expectations, of the rest.
  static constexpr std::uint32_t first_local = levels * classes;
  static constexpr std::uint32_t first_running =
      first_local + local_levels * local_errors;

  explicit IntensityContexts(bool is_small)
  : symbol(is_small,
           6,
           {(first_running + classes) * nodes,
            2 * scales * widths * 2 * distances,
            LocalModels::shapes * averages * nodes,
            (first_local + local_levels * classes) * nodes},
           2 * nodes)
  , residual(is_small,
             5,
             {DepthSplit::class_count * longest_residual,
              768 * longest_residual,
              512 * longest_residual},
             8)
  , escape(is_small, 5, {longest_excess})
  {}

  /** \brief Class of a number: itself below 4, then four classes an octave. */
  static std::uint32_t
  classOf(std::uint32_t number, std::uint32_t class_count)
  {
    if (number < 4)
      return number;
    const unsigned int height = highestBit(number);
    return std::min(4 * (height - 1) + (number >> (height - 2) & 3), class_count - 1);
  }

  /** \brief Class of what neighbours let expect. */
  static std::uint32_t
  localLevel(const LocalExpectation& local)
  {
    return static_cast<std::uint32_t>(local.logarithm() - LocalExpectation::least) /
           (octave / 2);
  }

  /** \brief Class of the error of that. */
  static std::uint32_t
  localErrorClass(std::uint32_t error)
  {
    return error < 18 ? 0 : error < 36 ? 1 : error < 64 ? 2 : 3;
  }

  /** \brief First node of the symbols of a length. */
  static std::uint32_t
  nodeOf(std::uint32_t length)
  {
    return length < 5 ? (1u << length) / 2 : (std::min(length, 8u) - 4) * prefixes;
  }

  /** \brief Bytes of memory besides the object. */
  std::size_t
  memoryBytes() const
  {
    return symbol.memoryBytes() + residual.memoryBytes() + escape.memoryBytes();
  }

  LocalModels local;          ///< what neighbours let expect
  DecisionModel<4, 2> symbol; ///< a symbol reaches the middle of an interval
  DecisionModel<3> residual;  ///< a residual is above the value so far
  DecisionModel<1> escape;    ///< number of bits of an escape or excess
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
