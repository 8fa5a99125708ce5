// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/entropy_coder.h"
#include "codec/scan/number_symbols.h"
#include "codec/scan/symbol_table.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Most contexts of the symbols of a plane. */
constexpr std::size_t most_contexts = 256;

/** \brief Memory for the symbols of a plane and their tables, reused from one to the
 * next. */
struct SymbolWorkspace {
  std::vector<std::uint32_t> symbols;
  std::vector<SymbolCounts> counts; // of contexts
  std::deque<SymbolTable> tables;   // stay where they are
  std::array<const SymbolTable*, most_contexts> table_of_context;
  std::vector<std::uint32_t> ranges;
  std::vector<std::uint16_t> words;
  std::vector<std::uint8_t> copy;
};

/** \brief Takes the symbols of a plane. As their tables are sent before them, nothing is
 * written before finish(). Same interface as SymbolDecoding, so that what a plane
 * consists of is written once for both directions. */
class SymbolEncoding {
public:
  static constexpr bool is_decoder = false;

  /** \param[in,out] work must outlive it, and be used by one at a time */
  explicit SymbolEncoding(SymbolWorkspace& work)
  : work_(&work), next_(work.symbols.data())
  {}

  /** \brief Makes room for this many more numbers. */
  void
  reserve(std::size_t numbers);

  /** \brief Codes a number or a word.
   * \param[in] context below most_contexts
   * \param[in] value a number below first_word, or a word from there on
   * \return the value
   */
  PCL_EXT_ALWAYS_INLINE std::uint64_t
  code(std::size_t context, std::uint64_t value)
  {
    const bool is_word = value >= first_word;
    NumberParts parts = partsOf(static_cast<std::uint32_t>(value));
    if (is_word)
      parts.symbol =
          number_symbol_count + static_cast<unsigned int>(value - first_word);
    next_[0] = static_cast<std::uint32_t>(context << 8 | parts.symbol);
    next_[1] = low_bits | parts.low; // overwritten if there are none
    next_ += parts.symbol >= exact_numbers && !is_word ? 2 : 1;
    return value;
  }

  /** \brief As SymbolDecoding::isOverrun. */
  static constexpr bool
  isOverrun()
  {
    return false;
  }

  /** \brief Appends the bytes of the tables and of all symbols.
   * \param[in] context_count 1 to most_contexts
   */
  void
  finish(std::size_t context_count, std::vector<std::uint8_t>& bytes);

private:
  static constexpr std::uint32_t low_bits = std::uint32_t{1} << 31;

  void
  countSymbols(std::size_t context_count);

  void
  encodeSymbols(rans::ReverseEncoder& encoder) const;

  SymbolWorkspace* work_;
  std::uint32_t* next_;
};

/** \brief Decodes what SymbolEncoding wrote. */
class SymbolDecoding {
public:
  static constexpr bool is_decoder = true;

  /** \brief Reads the tables. Nothing may be decoded unless hasTables().
   * \param[in] context_count as that of the encoder
   * \param[in,out] work must outlive it, and be used by one at a time
   */
  SymbolDecoding(const std::uint8_t* begin,
                 const std::uint8_t* end,
                 std::size_t context_count,
                 SymbolWorkspace& work);

  void
  reserve(std::size_t)
  {}

  /** \brief Decodes a number or a word, see SymbolEncoding. */
  PCL_EXT_ALWAYS_INLINE std::uint64_t
  code(std::size_t context, std::uint64_t)
  {
    const unsigned int symbol = coder_.code(*work_->table_of_context[context], 0);
    if (symbol < exact_numbers)
      return symbol;
    if (symbol >= number_symbol_count)
      return first_word + (symbol - number_symbol_count);
    return numberOf(symbol, lowBits(lowBitsOf(symbol)));
  }

  bool
  hasTables() const
  {
    return has_tables_;
  }

  /** \brief Whether more bytes were read than there are, to be checked after each
   * number. */
  bool
  isOverrun() const
  {
    return coder_.isOverrun();
  }

  /** \brief Whether all bytes were read. */
  bool
  isAtEnd() const
  {
    return coder_.isAtEnd();
  }

private:
  bool
  readTables(std::size_t context_count);

  std::uint32_t
  lowBits(unsigned int count)
  {
    std::uint32_t bits = 0;
    for (; count > rans::probability_bits; count -= rans::probability_bits)
      bits =
          bits << rans::probability_bits | coder_.codeBits(rans::probability_bits, 0);
    return bits << count | coder_.codeBits(count, 0);
  }

  rans::NibbleDecoder coder_;
  SymbolWorkspace* work_;
  bool has_tables_;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
