#pragma once

#include "codec/fast/byte_table.h"
#include "codec/fast/nibble_model.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief How many rANS states take turns: one costs fewer bytes, four less time. */
enum class Interleaving { One, Four };

/** \brief The number of states for so many voxels or numbers. A state costs four bytes,
 * which below 1024 weigh more than the time. */
constexpr Interleaving
interleavingOf(std::size_t count)
{
  return count < 1024 ? Interleaving::One : Interleaving::Four;
}

/** \brief The memory that will be wanted behind a row: none that is not there. */
struct NothingWanted {
  std::array<const void*, 0>
  operator()(std::size_t) const
  {
    return {};
  }
};

/** \brief Nothing is done with the symbols of a row while it is coded. */
struct NoUse {
  void
  operator()(unsigned int) const
  {}
};

/** \brief Collects symbols in the order in which they are decoded. rANS codes the last
 * symbol first, so that bytes are made only when all are there.
 *
 * `code` has the face that NibbleDecoder's has: one function for both directions walks
 * through a frame.
 */
class NibbleEncoder {
public:
  static constexpr bool is_decoder = false;

  explicit NibbleEncoder(std::vector<std::uint32_t>& steps)
  : steps_(&steps), next_(steps.data()), end_(steps.data() + steps.size())
  {}

  /** \brief Makes room for this many more symbols. */
  void
  expect(std::size_t symbols)
  {
    if (static_cast<std::size_t>(end_ - next_) >= symbols)
      return;
    const auto used = static_cast<std::size_t>(next_ - steps_->data());
    steps_->resize(2 * used + symbols);
    next_ = steps_->data() + used;
    end_ = steps_->data() + steps_->size();
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

  unsigned int
  code(const ByteTable& table, unsigned int byte)
  {
    push(table.range(byte));
    return byte;
  }

  unsigned int
  code(QuadModel& model, unsigned int quad)
  {
    push(model.table().range(quad));
    model.learn(quad);
    return quad;
  }

  /** \brief Codes a number below 2^count as it is; count 1..12. */
  unsigned int
  codeBits(unsigned int count, unsigned int number)
  {
    const unsigned int shift = probability_bits - count;
    push({number << shift, 1u << shift});
    return number;
  }

  /** \brief Codes nibbles, each with the model that its context chooses.
   * \param[in] contexts one for each nibble
   * \param[in] wanted see NibbleDecoder
   */
  template <class Wanted = NothingWanted>
  bool
  codeRow(NibbleModel* models,
          const std::uint8_t* contexts,
          std::uint8_t* nibbles,
          std::size_t count,
          const Wanted& wanted = Wanted())
  {
    for (std::size_t i = 0; i < count; ++i) {
      for (const void* address : wanted(i))
        prefetch(address);
      code(models[contexts[i]], nibbles[i]);
    }
    return true;
  }

  /** \brief Codes bytes with one table.
   * \param[in,out] use see NibbleDecoder
   */
  template <class Use = NoUse>
  bool
  codeRow(const ByteTable& table,
          std::uint8_t* bytes,
          std::size_t count,
          Use&& use = Use())
  {
    for (std::size_t i = 0; i < count; ++i) {
      code(table, bytes[i]);
      use(bytes[i]);
    }
    return true;
  }

  /** \brief Codes bytes of four numbers. */
  bool
  codeRow(QuadModel& model, std::uint8_t* quads, std::size_t count)
  {
    for (std::size_t i = 0; i < count; ++i)
      code(model, quads[i]);
    return true;
  }

  /** \brief A place among the symbols; differences count symbols. */
  using Mark = std::size_t;

  Mark
  mark() const
  {
    return static_cast<Mark>(next_ - steps_->data());
  }

  /** \brief About how much the symbols behind a mark cost, in sixteenths of a bit. */
  std::uint64_t
  cost(Mark begin) const;

  /** \brief Removes symbols between two marks. */
  void
  erase(Mark begin, Mark end);

  /** \brief For the likeness with NibbleDecoder. */
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
  void
  push(ProbabilityRange range)
  {
    *next_++ = range.start | range.width << 16;
  }

  std::vector<std::uint32_t>* steps_;
  std::uint32_t* next_;
  std::uint32_t* end_;
};

/** \brief Reads what NibbleEncoder wrote. Copies are cheap: a loop works on its own.
 *
 * Behind the end it reads zeros, for `slack` symbols; a loop asks `isOverrun` at least
 * that often.
 */
class NibbleDecoder {
public:
  static constexpr bool is_decoder = true;
  /** \brief Symbols that may be decoded between two looks at isOverrun. */
  static constexpr std::size_t slack = 64;

  /** \brief Takes a copy of the bytes to read from.
   * \param[in,out] copy memory for it, which must outlive the decoder
   */
  NibbleDecoder(const std::uint8_t* begin,
                const std::uint8_t* end,
                Interleaving interleaving,
                std::vector<std::uint8_t>& copy);

  void
  expect(std::size_t)
  {}

  /** \brief Whether more bytes were read than there are, or a state cannot be. */
  bool
  isOverrun() const
  {
    return next_ > end_;
  }

  /** \brief Whether all bytes are used up, as an encoder leaves them. */
  bool
  isAtEnd() const;

  unsigned int
  code(NibbleModel& model, unsigned int)
  {
    const std::size_t symbol = model.find(slot());
    advance(model.range(symbol));
    model.learn(symbol);
    return static_cast<unsigned int>(symbol);
  }

  unsigned int
  code(BitModel& model, unsigned int)
  {
    const unsigned int bit = model.find(slot());
    advance(model.range(bit));
    model.learn(bit);
    return bit;
  }

  unsigned int
  code(const ByteTable& table, unsigned int)
  {
    const unsigned int byte = table.find(slot());
    advance(table.range(byte));
    return byte;
  }

  unsigned int
  code(QuadModel& model, unsigned int)
  {
    const unsigned int quad = code(model.table(), 0);
    model.learn(quad);
    return quad;
  }

  unsigned int
  codeBits(unsigned int count, unsigned int)
  {
    const unsigned int shift = probability_bits - count;
    const unsigned int number = slot() >> shift;
    advance({number << shift, 1u << shift});
    return number;
  }

  /** \brief Decodes nibbles, each with the model that its context chooses. All that the
   * contexts depend on is known before, so that four nibbles are under way at a time.
   * \param[in] contexts one for each nibble
   * \param[out] nibbles with room for `count`
   * \param[in] wanted for the index of each nibble the addresses of what will be wanted
   * behind the row: its way from memory costs nothing while states wait for each other
   * \return false if the bytes come to their end before
   */
  template <class Wanted = NothingWanted>
  bool
  codeRow(NibbleModel* models,
          const std::uint8_t* contexts,
          std::uint8_t* nibbles,
          std::size_t count,
          const Wanted& wanted = Wanted())
  {
    return decodeRow(nibbles, count, [=](NibbleDecoder& coder, std::size_t i) {
      for (const void* address : wanted(i))
        prefetch(address);
      return coder.code(models[contexts[i]], 0);
    });
  }

  /** \brief Decodes bytes with one table; see above.
   * \param[in,out] use is called with each byte, which costs little while states wait
   */
  template <class Use = NoUse>
  bool
  codeRow(const ByteTable& table,
          std::uint8_t* bytes,
          std::size_t count,
          Use&& use = Use())
  {
    auto use_now = use; // in registers
    const bool is_whole =
        decodeRow(bytes, count, [&table, &use_now](NibbleDecoder& coder, std::size_t) {
          const unsigned int byte = coder.code(table, 0);
          use_now(byte);
          return byte;
        });
    use = use_now;
    return is_whole;
  }

  /** \brief Decodes bytes of four numbers; see above. */
  bool
  codeRow(QuadModel& model, std::uint8_t* quads, std::size_t count)
  {
    while (count > 0) {
      const std::size_t alike = std::min<std::size_t>(count, model.untilAdapts());
      if (!codeRow(model.table(), quads, alike))
        return false;
      for (std::size_t i = 0; i < alike; ++i)
        model.learn(quads[i]);
      quads += alike;
      count -= alike;
    }
    return true;
  }

private:
  friend class NibbleEncoder;
  static constexpr std::uint32_t lowest_state = 1u << 15;

  std::uint32_t
  slot() const
  {
    return first_ & (probability_one - 1);
  }

  void
  advance(ProbabilityRange range)
  {
    std::uint32_t state =
        range.width * (first_ >> probability_bits) + slot() - range.start;
    const auto word = static_cast<std::uint32_t>(next_[0] | next_[1] << 8);
    const std::uint32_t refilled = state << 16 | word;
    const std::uint8_t* const behind = next_ + 2;
#if defined(__GNUC__) && defined(__x86_64__)
    // g++ makes a branch of it that is taken in no order, or with masks twice as many
    // instructions, for which the states wait.
    asm("cmp %[lowest], %[state]\n\t"
        "cmovb %[behind], %[next]\n\t"
        "cmovb %[refilled], %[state]"
        : [state] "+&r"(state), [next] "+&r"(next_)
        : [behind] "r"(behind), [refilled] "r"(refilled), [lowest] "i"(lowest_state)
        : "cc");
#else
    const bool is_low = state < lowest_state;
    next_ = is_low ? behind : next_;
    state = is_low ? refilled : state;
#endif
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
   * \param[in] decode_one decodes the i-th
   */
  template <class DecodeOne>
  bool
  decodeRow(std::uint8_t* symbols, std::size_t count, DecodeOne decode_one);

  // The states in the order in which they come next.
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
  // As many at a time as there are states, which so need not change places.
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

} // namespace fast
} // namespace io
} // namespace pcl_ext
