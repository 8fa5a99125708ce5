// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/byte_table.h"
#include "codec/rans/nibble_model.h"
#include "codec/rans/reverse_encoder.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief The interleaving of a row of so many elements. In a short row the bytes of
 * three more states matter more than time. */
constexpr Interleaving
interleavingOf(std::size_t element_count)
{
  return element_count < 1024 ? Interleaving::One : Interleaving::Four;
}

/** \brief Prefetches nothing while a row is coded. */
struct NoPrefetch {
  std::array<const void*, 0>
  operator()(std::size_t) const
  {
    return {};
  }
};

/** \brief Does nothing with the symbols of a row while it is coded. */
struct NoVisit {
  void
  operator()(unsigned int) const
  {}
};

/** \brief Collects symbols in the order of decoding. rANS encodes the last symbol
 * first, so that finish() generates the bytes.
 *
 * Same interface as NibbleDecoder, so that the stages of a frame are written once for
 * both directions.
 */
class NibbleEncoder {
public:
  static constexpr bool is_decoder = false;

  /** \param[in,out] ranges memory for the symbols, which must outlive the encoder */
  explicit NibbleEncoder(std::vector<std::uint32_t>& ranges)
  : ranges_(&ranges), next_(ranges.data()), end_(ranges.data() + ranges.size())
  {}

  /** \brief Makes room for this many more symbols. */
  void
  reserve(std::size_t symbols)
  {
    if (static_cast<std::size_t>(end_ - next_) < symbols)
      *this = grown(*this, symbols);
  }

  unsigned int
  code(NibbleModel& model, unsigned int symbol)
  {
    push(model.range(symbol));
    model.learn(symbol);
    return symbol;
  }

  unsigned int
  code(BitModel& model, unsigned int bit)
  {
    push(model.range(bit));
    model.learn(bit);
    return bit;
  }

  /** \brief Codes a symbol whose probabilities are fixed.
   * \param[in] table a SlotTable
   */
  template <class TableT>
  unsigned int
  code(const TableT& table, unsigned int symbol)
  {
    push(table.range(symbol));
    return symbol;
  }

  /** \brief Codes a number below 2^count that bypasses the models; count 1..12. */
  unsigned int
  codeBits(unsigned int count, unsigned int number)
  {
    const unsigned int shift = probability_bits - count;
    push({number << shift, 1u << shift});
    return number;
  }

  /** \brief Codes nibbles, each with the model of its context.
   * \param[in] contexts one for each nibble
   * \param[in] prefetched see NibbleDecoder
   */
  template <class Context, class Prefetched = NoPrefetch>
  bool
  codeRow(NibbleModel* models,
          const Context* contexts,
          std::uint8_t* nibbles,
          std::size_t count,
          const Prefetched& prefetched = Prefetched())
  {
    NibbleEncoder coder = *this; // in registers
    for (std::size_t i = 0; i < count; ++i) {
      for (const void* address : prefetched(i))
        prefetch(address);
      coder.code(models[contexts[i]], nibbles[i]);
    }
    *this = coder;
    return true;
  }

  /** \brief Codes bytes with one table.
   * \param[in,out] visit see NibbleDecoder
   */
  template <class Visit = NoVisit>
  bool
  codeRow(const ByteTable& table,
          std::uint8_t* bytes,
          std::size_t count,
          Visit&& visit = Visit())
  {
    for (std::size_t i = 0; i < count; ++i) {
      code(table, bytes[i]);
      visit(bytes[i]);
    }
    return true;
  }

  /** \brief Number of symbols so far. */
  std::size_t
  size() const
  {
    return static_cast<std::size_t>(next_ - ranges_->data());
  }

  /** \brief Those of all symbols, packed(). */
  const std::uint32_t*
  ranges() const
  {
    return ranges_->data();
  }

  /** \brief As NibbleDecoder::isOverrun. */
  static constexpr bool
  isOverrun()
  {
    return false;
  }

  /** \brief Appends the bytes of all symbols. */
  void
  finish(Interleaving interleaving,
         std::vector<std::uint16_t>& words,
         std::vector<std::uint8_t>& bytes) const;

private:
  /** \brief An encoder with room for more symbols. By value, so that loops can keep
   * theirs in registers. */
  PCL_EXT_NEVER_INLINE static NibbleEncoder
  grown(NibbleEncoder encoder, std::size_t symbols)
  {
    std::vector<std::uint32_t>& ranges = *encoder.ranges_;
    const auto used = static_cast<std::size_t>(encoder.next_ - ranges.data());
    // Large ones grow by less, as for a moment there are both.
    constexpr std::size_t large = std::size_t{1} << 20;
    ranges.resize(used + (used < large ? used : used / 8) + symbols);
    encoder.next_ = ranges.data() + used;
    encoder.end_ = ranges.data() + ranges.size();
    return encoder;
  }

  void
  push(ProbabilityRange range)
  {
    *next_++ = packed(range);
  }

  std::vector<std::uint32_t>* ranges_;
  std::uint32_t* next_;
  std::uint32_t* end_;
};

/** \brief Takes symbols without coding them, so that a stage updates the history with a
 * frame that is known. Models do not learn. Same interface as NibbleEncoder. */
class SymbolSink {
public:
  static constexpr bool is_decoder = false;

  void
  reserve(std::size_t)
  {}

  template <class ModelT>
  unsigned int
  code(const ModelT&, unsigned int symbol)
  {
    return symbol;
  }

  unsigned int
  codeBits(unsigned int, unsigned int number)
  {
    return number;
  }

  template <class Context, class Prefetched = NoPrefetch>
  bool
  codeRow(const NibbleModel*,
          const Context*,
          const std::uint8_t*,
          std::size_t,
          const Prefetched& = Prefetched())
  {
    return true;
  }

  template <class Visit = NoVisit>
  bool
  codeRow(const ByteTable&,
          const std::uint8_t* bytes,
          std::size_t count,
          Visit&& visit = Visit())
  {
    for (std::size_t i = 0; i < count; ++i)
      visit(bytes[i]);
    return true;
  }

  static constexpr bool
  isOverrun()
  {
    return false;
  }
};

/** \brief Decodes what NibbleEncoder wrote. Loops use a copy, which stays in registers.
 *
 * After the end it reads zeros, for at most `slack` symbols: loops have to check
 * `isOverrun` that often.
 */
class NibbleDecoder {
public:
  static constexpr bool is_decoder = true;
  /** \brief Symbols that may be decoded between two calls of isOverrun. */
  static constexpr std::size_t slack = 64;

  /** \brief Copies the bytes to decode.
   * \param[in,out] copy memory for them, which must outlive the decoder
   */
  NibbleDecoder(const std::uint8_t* begin,
                const std::uint8_t* end,
                Interleaving interleaving,
                std::vector<std::uint8_t>& copy);

  void
  reserve(std::size_t)
  {}

  /** \brief Whether more bytes were read than there are, or an initial state is
   * invalid. */
  bool
  isOverrun() const
  {
    return next_ > end_;
  }

  /** \brief Whether all bytes were read and the states are those that an encoder starts
   * with. */
  bool
  isAtEnd() const;

  PCL_EXT_ALWAYS_INLINE unsigned int
  code(NibbleModel& model, unsigned int)
  {
    const std::size_t symbol = model.find(slot());
    advance(model.range(symbol));
    model.learn(symbol);
    return static_cast<unsigned int>(symbol);
  }

  /** \brief Decodes a nibble that is mostly 0: it takes less time to predict that than
   * to find the nibble. */
  PCL_EXT_ALWAYS_INLINE unsigned int
  decodeMostlyZero(NibbleModel& model)
  {
    const ProbabilityRange zero = model.range(0);
    if (slot() >= zero.width)
      return code(model, 0);
    advance(zero);
    model.learn(0);
    return 0;
  }

  PCL_EXT_ALWAYS_INLINE unsigned int
  code(BitModel& model, unsigned int)
  {
    const unsigned int bit = model.find(slot());
    advance(model.range(bit));
    model.learn(bit);
    return bit;
  }

  template <class TableT>
  PCL_EXT_ALWAYS_INLINE unsigned int
  code(const TableT& table, unsigned int)
  {
    const unsigned int symbol = table.find(slot());
    advance(table.range(symbol));
    return symbol;
  }

  unsigned int
  codeBits(unsigned int count, unsigned int)
  {
    const unsigned int shift = probability_bits - count;
    const unsigned int number = slot() >> shift;
    advance({number << shift, 1u << shift});
    return number;
  }

  /** \brief Decodes nibbles, each with the model of its context. As no context depends
   * on a nibble of the row, four nibbles are decoded at a time.
   * \param[in] contexts one for each nibble
   * \param[out] nibbles `count` of them
   * \param[in] prefetched returns the addresses to prefetch with the i-th nibble
   * (doc/implementation_notes.md, "Prefetching")
   * \return false if there are too few bytes
   */
  template <class Context, class Prefetched = NoPrefetch>
  bool
  codeRow(NibbleModel* models,
          const Context* contexts,
          std::uint8_t* nibbles,
          std::size_t count,
          const Prefetched& prefetched = Prefetched())
  {
    return decodeRow(nibbles, count, [=](NibbleDecoder& coder, std::size_t i) {
      for (const void* address : prefetched(i))
        prefetch(address);
      return coder.code(models[contexts[i]], 0);
    });
  }

  /** \brief Decodes bytes with one table; see above.
   * \param[in,out] visit called with each byte, while the next state is computed
   */
  template <class Visit = NoVisit>
  bool
  codeRow(const ByteTable& table,
          std::uint8_t* bytes,
          std::size_t count,
          Visit&& visit = Visit())
  {
    auto local_visit = visit; // in registers
    const bool is_whole = decodeRow(
        bytes, count, [&table, &local_visit](NibbleDecoder& coder, std::size_t) {
          const unsigned int byte = coder.code(table, 0);
          local_visit(byte);
          return byte;
        });
    visit = local_visit;
    return is_whole;
  }

private:
  friend class NibbleEncoder;
  static constexpr std::uint32_t lowest_state = ReverseEncoder::lowest_state;

  std::uint32_t
  slot() const
  {
    return first_ & (probability_one - 1);
  }

  PCL_EXT_ALWAYS_INLINE void
  advance(ProbabilityRange range)
  {
    std::uint32_t state =
        range.width * (first_ >> probability_bits) + slot() - range.start;
    const auto word = static_cast<std::uint32_t>(next_[0] | next_[1] << 8);
    replaceIfBelow(lowest_state, state, state << 16 | word, next_, next_ + 2);
    if (is_single_) {
      first_ = state;
      return;
    }
    first_ = second_;
    second_ = third_;
    third_ = fourth_;
    fourth_ = state;
  }

  /** \brief Decodes symbols that do not depend on each other.
   * \param[in] decode_one decodes the i-th symbol
   */
  template <class DecodeOne>
  bool
  decodeRow(std::uint8_t* symbols, std::size_t count, DecodeOne decode_one);

  // The states, the next one first.
  std::uint32_t first_ = lowest_state;
  std::uint32_t second_ = lowest_state;
  std::uint32_t third_ = lowest_state;
  std::uint32_t fourth_ = lowest_state;
  bool is_single_;
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

template <class DecodeOne>
inline bool
NibbleDecoder::decodeRow(std::uint8_t* symbols, std::size_t count, DecodeOne decode_one)
{
  NibbleDecoder coder = *this; // in registers
  std::size_t i = 0;
  // As many at a time as there are states, so that no registers are rotated.
  if (!coder.is_single_)
    for (; i + 4 <= count && !coder.isOverrun(); i += 4) {
      symbols[i] = static_cast<std::uint8_t>(decode_one(coder, i));
      symbols[i + 1] = static_cast<std::uint8_t>(decode_one(coder, i + 1));
      symbols[i + 2] = static_cast<std::uint8_t>(decode_one(coder, i + 2));
      symbols[i + 3] = static_cast<std::uint8_t>(decode_one(coder, i + 3));
    }
  for (; i < count && !coder.isOverrun(); ++i)
    symbols[i] = static_cast<std::uint8_t>(decode_one(coder, i));
  *this = coder;
  return !coder.isOverrun();
}

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
