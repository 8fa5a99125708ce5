#include "codec/fast/intensities.h"

#include "codec/fast/symbol_moment.h"
#include "voxels/child_masks.h"

#include <algorithm>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

// Means below these, in eighths, have a class of low ones each.
constexpr std::array<unsigned int, 3> class_ends = {4, 10, 16};

/** \brief Appends those of eight voxels that a mask names; room for eight is needed. */
inline void
appendVoxels(std::uint32_t*& row, std::uint32_t first, unsigned int mask)
{
  const auto& children = child_masks.children[mask];
#if defined(__SSE2__)
  const __m128i zero = _mm_setzero_si128();
  const __m128i firsts = _mm_set1_epi32(static_cast<int>(first));
  const __m128i bytes =
      _mm_loadl_epi64(reinterpret_cast<const __m128i*>(children.data()));
  const __m128i words = _mm_unpacklo_epi8(bytes, zero);
  auto* const eight = reinterpret_cast<__m128i*>(row);
  _mm_storeu_si128(eight, _mm_add_epi32(_mm_unpacklo_epi16(words, zero), firsts));
  _mm_storeu_si128(eight + 1, _mm_add_epi32(_mm_unpackhi_epi16(words, zero), firsts));
#else
  for (unsigned int k = 0; k < 8; ++k)
    row[k] = first + children[k];
#endif
  row += child_masks.count[mask];
}

/** \brief Which of eight moments are below the ends of the low classes, and which are
 * none. */
using MomentMasks = std::array<unsigned int, 4>;

inline MomentMasks
momentMasks(const std::uint16_t* moments)
{
  constexpr unsigned int eighth = symbol_moment::deviation_count;
#if defined(__SSE2__)
  const __m128i eight = _mm_loadu_si128(reinterpret_cast<const __m128i*>(moments));
  const auto below = [&](unsigned int end) {
    const auto last = static_cast<short>(end * eighth - 1);
    return _mm_cmpeq_epi16(_mm_subs_epu16(eight, _mm_set1_epi16(last)),
                           _mm_setzero_si128());
  };
  const auto bits = [](__m128i low, __m128i high) {
    return static_cast<unsigned int>(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
  };
  const __m128i none = _mm_cmpeq_epi16(eight, _mm_set1_epi16(-1));
  const unsigned int low = bits(below(class_ends[0]), below(class_ends[1]));
  const unsigned int high = bits(below(class_ends[2]), none);
  return {low & 0xff, low >> 8, high & 0xff, high >> 8};
#else
  MomentMasks masks{};
  for (unsigned int k = 0; k < 8; ++k) {
    for (std::size_t i = 0; i < class_ends.size(); ++i)
      masks[i] |= (moments[k] < class_ends[i] * eighth ? 1u : 0u) << k;
    masks[3] |= (moments[k] == History::no_moment ? 1u : 0u) << k;
  }
  return masks;
#endif
}

} // namespace

void
Intensities::encode(NibbleEncoder& coder,
                    Models& models,
                    const Frame& frame,
                    Moments& moments,
                    unsigned int bits,
                    const std::vector<std::uint16_t>& symbols)
{
  const NibbleEncoder::Mark start = coder.mark();
  models_before_ = models;
  encodeExpected(coder, models, frame, moments, bits, symbols);
  // Symbols for which expectations cost more than they save take more than one of the
  // coder's own each.
  const NibbleEncoder::Mark end = coder.mark();
  if (4 * (end - start) < 5 * symbols.size())
    return;
  const std::uint64_t expected_cost = coder.cost(start);
  forget(frame, moments);
  models = models_before_;
  coder.expect(1 + 3 * symbols.size());
  coder.codeBits(1, 1);
  codePlain(coder, models, bits, symbols.size(), symbols.data());
  // What an I-frame teaches of its voxels saves more than a little in the frames behind it.
  const std::uint64_t plain_cost = coder.cost(end);
  if (frame.is_i_frame ? 16 * plain_cost < 15 * expected_cost
                       : plain_cost < expected_cost) {
    coder.erase(start, end);
    return;
  }
  coder.erase(end, coder.mark());
  models = models_before_;
  coder.erase(start, end);
  encodeExpected(coder, models, frame, moments, bits, symbols);
}

void
Intensities::encodeExpected(NibbleEncoder& coder,
                            Models& models,
                            const Frame& frame,
                            Moments& moments,
                            unsigned int bits,
                            const std::vector<std::uint16_t>& symbols)
{
  unsigned int has_zeros = 0;
  for (const std::uint16_t symbol : symbols)
    has_zeros |= symbol == 0 ? 1u : 0u;
  coder.expect(2);
  coder.codeBits(1, 0);
  setOrigin(coder.codeBits(1, 1 - has_zeros), bits);
  sortIntoRows(frame, moments);
  splitNewVoxels(!frame.is_i_frame && models.new_steps_are_low);
  code(coder, models, frame, moments.data(), symbols.data());
}

/** \brief Symbols as their high eight bits, whose frequencies are learnt, and low bits.
 */
template <class Coder, class Symbol>
bool
Intensities::codePlain(
    Coder& coder, Models& models, unsigned int bits, std::size_t count, Symbol* symbols)
{
  const unsigned int low_bits = bits > 8 ? bits - 8 : 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Three symbols of the coder each at most.
    if (i % 16 == 0 && coder.isOverrun())
      return false;
    const auto symbol = Coder::is_decoder ? 0u : static_cast<unsigned int>(symbols[i]);
    const unsigned int high = symbol >> low_bits;
    const unsigned int low_nibble = coder.code(models.plain.low[0], high & 15);
    const unsigned int high_nibble =
        coder.code(models.plain.high[low_nibble], high >> 4);
    unsigned int decoded = (high_nibble << 4 | low_nibble) << low_bits;
    if (low_bits > 0)
      decoded |= coder.codeBits(low_bits, symbol & ((1u << low_bits) - 1));
    if constexpr (Coder::is_decoder) {
      if (decoded >> bits != 0)
        return false;
      symbols[i] = static_cast<std::uint16_t>(decoded);
    }
  }
  return true;
}

bool
Intensities::decode(NibbleDecoder& coder,
                    Models& models,
                    const Frame& frame,
                    Moments& moments,
                    unsigned int bits,
                    std::vector<std::uint16_t>& symbols)
{
  symbols.resize(frame.voxel_count);
  const bool is_plain = coder.codeBits(1, 0) != 0;
  if (!is_plain)
    setOrigin(coder.codeBits(1, 0), bits);
  sortIntoRows(frame, moments);
  if (is_plain)
    return codePlain(coder, models, bits, frame.voxel_count, symbols.data());
  splitNewVoxels(!frame.is_i_frame && models.new_steps_are_low);
  return code(coder, models, frame, moments.data(), symbols.data()) &&
         areSymbols(symbols);
}

/** \brief Whether symbols are what an encoder of this origin can have had. */
bool
Intensities::areSymbols(const std::vector<std::uint16_t>& symbols) const
{
  const auto highest = static_cast<std::uint16_t>(top_ + origin_);
  // Comparisons rather than extremes: SSE2 has none of unsigned numbers.
  std::uint16_t is_any_zero = 0;
  std::uint16_t is_any_above = 0;
  for (const std::uint16_t symbol : symbols) {
    is_any_zero = static_cast<std::uint16_t>(is_any_zero | (symbol == 0 ? 1 : 0));
    is_any_above =
        static_cast<std::uint16_t>(is_any_above | (symbol > highest ? 1 : 0));
  }
  // Without a 0 the numbers would have been lowered.
  return is_any_above == 0 && (origin_ == 1 || is_any_zero != 0);
}

void
Intensities::forget(const Frame& frame, Moments& moments)
{
  for (std::size_t i = 0; i < frame.voxel_count; ++i)
    moments[frame.places[i]] = before_[i];
}

void
Intensities::sortIntoRows(const Frame& frame, const Moments& moments)
{
  const std::size_t count = frame.voxel_count;
  places_ = frame.places.data();
  ensureSize(before_, count + 7); // looked at in eights
  // Here, where no moment has changed yet: there may be no memory.
  ensureSize(contexts_, count);
  ensureSize(coded_, count);
  ensureSize(known_moments_, count);
  std::uint16_t* const before = before_.data();
  for (std::size_t i = 0; i < count; ++i)
    before[i] = moments[places_[i]];
  const auto start = [&](Row& row) {
    ensureSize(row.voxels, count + 8);
    row.noted = 0;
    return row.voxels.data();
  };
  const auto end = [](Row& row, const std::uint32_t* last) {
    row.count = static_cast<std::size_t>(last - row.voxels.data());
  };
  std::array<std::uint32_t*, low_class_count> low;
  for (unsigned int i = 0; i < low_class_count; ++i)
    low[i] = start(quads_[i]);
  std::uint32_t* known = start(known_);
  start(new_);
  for (std::size_t i = 0; i < count; i += 8) {
    const unsigned int all = count - i < 8 ? (1u << (count - i)) - 1 : 0xff;
    const MomentMasks masks = momentMasks(before + i);
    const auto first = static_cast<std::uint32_t>(i);
    appendVoxels(low[0], first, masks[0] & all);
    appendVoxels(low[1], first, masks[1] & ~masks[0] & all);
    appendVoxels(low[2], first, masks[2] & ~masks[1] & all);
    appendVoxels(low[without_moment], first, masks[without_moment] & all);
    appendVoxels(known, first, ~(masks[2] | masks[without_moment]) & all);
  }
  for (unsigned int i = 0; i < low_class_count; ++i) {
    end(quads_[i], low[i]);
    // Those that are no whole quad go last in the next row.
    for (; i != without_moment && quads_[i].count % 4 != 0; --quads_[i].count)
      *known++ = *--low[i];
  }
  end(known_, known);
}

/** \brief Decides which of the voxels without a moment are coded four at a time. */
void
Intensities::splitNewVoxels(bool in_quads)
{
  Row& quads = quads_[without_moment];
  const std::size_t kept = in_quads ? quads.count / 4 * 4 : 0;
  new_.count = quads.count - kept;
  std::copy_n(quads.voxels.begin() + static_cast<std::ptrdiff_t>(kept),
              new_.count,
              new_.voxels.begin());
  quads.count = kept;
}

void
Intensities::setOrigin(unsigned int origin, unsigned int bits)
{
  origin_ = origin;
  top_ = (1u << bits) - 1 - origin_;
  const bool has_steps = top_ >= symbol_steps::exact;
  highest_step_ = has_steps ? symbol_steps::stepOf(top_) + 1 : top_;
  top_step_ = has_steps ? highest_step_ : symbol_steps::highest + 1;
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
