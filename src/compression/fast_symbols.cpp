#include "fast_symbols.h"

#include "block_octants.h"
#include "nibble_rans.h"
#include "symbol_moment.h"
#include "voxel_block.h"

#include <algorithm>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pcl_ext {
namespace io {

namespace {

// Voxels with a mean below 2 are coded in pairs, as 0, 1, 2 or more.
constexpr unsigned int pair_moments =
    2 * symbol_moment::fraction * symbol_moment::deviation_count;
constexpr unsigned int pair_escape = 3;
// Symbols 0..14 of the other models are steps, 15 is any other one.
constexpr unsigned int escape = 15;

/** \brief The moments after the steps 0..2, for those that are coded in pairs. */
constexpr std::array<std::uint16_t, pair_moments * 4>
makePairMoments()
{
  std::array<std::uint16_t, pair_moments * 4> after{};
  for (unsigned int moment = 0; moment < pair_moments; ++moment)
    for (unsigned int step = 0; step < pair_escape; ++step)
      after[moment * 4 + step] =
          symbol_moment::next(static_cast<std::uint16_t>(moment), step);
  return after;
}

constexpr auto pair_moments_after = makePairMoments();

constexpr unsigned int
pairClass(std::uint16_t moment)
{
  constexpr unsigned int eighth = symbol_moment::deviation_count;
  return (moment >= 4 * eighth ? 1u : 0u) + (moment >= 10 * eighth ? 1u : 0u);
}

/** \brief Appends those of eight voxels that a mask names; room for eight is needed. */
inline void
appendVoxels(std::uint32_t*& row, std::uint32_t first, unsigned int mask)
{
  for (unsigned int k = 0; k < 8; ++k)
    row[k] = first + child_masks.children[mask][k];
  row += child_masks.count[mask];
}

/** \brief Which of eight moments are those of pairs, and which are none. */
struct MomentMasks {
  unsigned int pairs;
  unsigned int none;
};

inline MomentMasks
momentMasks(const std::uint16_t* moments)
{
#if defined(__SSE2__)
  const __m128i eight = _mm_loadu_si128(reinterpret_cast<const __m128i*>(moments));
  const __m128i above =
      _mm_subs_epu16(eight, _mm_set1_epi16(static_cast<short>(pair_moments - 1)));
  const __m128i pairs = _mm_cmpeq_epi16(above, _mm_setzero_si128());
  const __m128i none = _mm_cmpeq_epi16(eight, _mm_set1_epi16(-1));
  const auto both =
      static_cast<unsigned int>(_mm_movemask_epi8(_mm_packs_epi16(pairs, none)));
  return {both & 0xff, both >> 8};
#else
  MomentMasks masks{0, 0};
  for (unsigned int k = 0; k < 8; ++k) {
    masks.pairs |= (moments[k] < pair_moments ? 1u : 0u) << k;
    masks.none |= (moments[k] == FastHistory::no_moment ? 1u : 0u) << k;
  }
  return masks;
#endif
}

} // namespace

void
FastSymbols::encode(NibbleEncoder& coder,
                    FastModels& models,
                    const FastFrame& frame,
                    std::vector<std::uint16_t>& moments,
                    unsigned int bits,
                    const std::vector<std::uint16_t>& symbols)
{
  unsigned int has_zeros = 0;
  for (const std::uint16_t symbol : symbols)
    has_zeros |= symbol == 0 ? 1u : 0u;
  coder.expect(1);
  setOrigin(coder.codeBits(1, 1 - has_zeros), bits);
  sortIntoRows(frame, moments);
  code(coder, models, frame, moments.data(), symbols.data());
}

bool
FastSymbols::decode(NibbleDecoder& coder,
                    FastModels& models,
                    const FastFrame& frame,
                    std::vector<std::uint16_t>& moments,
                    unsigned int bits,
                    std::vector<std::uint16_t>& symbols)
{
  setOrigin(coder.codeBits(1, 0), bits);
  sortIntoRows(frame, moments);
  symbols.resize(frame.voxel_count);
  if (!code(coder, models, frame, moments.data(), symbols.data()))
    return false;
  // An encoder lowers the numbers where there is no 0.
  return origin_ == 1 || std::find(symbols.begin(), symbols.end(), 0) != symbols.end();
}

template <class Coder, class Symbol>
bool
FastSymbols::code(Coder& coder,
                  FastModels& models,
                  const FastFrame& frame,
                  std::uint16_t* moments,
                  Symbol* symbols)
{
  return codePairs(coder, models, moments, symbols) &&
         codeKnown(coder, models, moments, symbols) &&
         codeNew(coder, models, frame.is_i_frame, moments, symbols) &&
         codeEscapes(coder, models, pairs_, moments, symbols) &&
         codeEscapes(coder, models, known_, moments, symbols) &&
         highest_seen_ <= highest_step_ && codeBitsWithinSteps(coder, symbols);
}

void
FastSymbols::forget(std::vector<std::uint16_t>& moments)
{
  for (std::size_t i = 0; i < places_.size(); ++i)
    moments[places_[i]] = before_[i];
}

void
FastSymbols::sortIntoRows(const FastFrame& frame,
                          const std::vector<std::uint16_t>& moments)
{
  const std::size_t count = frame.voxel_count;
  places_.resize(count);
  before_.resize(count + 7); // looked at in eights
  for (std::size_t i = 0; i < count; ++i) {
    places_[i] = frame.numbers[frame.block_of[i]] * block_cells + frame.cell_of[i];
    before_[i] = moments[places_[i]];
  }
  for (Row* row : {&pairs_, &known_, &new_}) {
    if (row->voxels.size() < count + 8) {
      row->voxels.resize(count + count / 4 + 8);
      row->escapes.resize(count + count / 4 + 8);
    }
    row->escape_count = 0;
  }
  if (wide_.size() < count + 1)
    wide_.resize(count + count / 4 + 1);
  wide_count_ = 0;
  highest_seen_ = 0;
  std::uint32_t* pairs = pairs_.voxels.data();
  std::uint32_t* known = known_.voxels.data();
  std::uint32_t* without = new_.voxels.data();
  for (std::size_t i = 0; i < count; i += 8) {
    const unsigned int all = count - i < 8 ? (1u << (count - i)) - 1 : 0xff;
    const MomentMasks masks = momentMasks(before_.data() + i);
    const auto first = static_cast<std::uint32_t>(i);
    appendVoxels(pairs, first, masks.pairs & all);
    appendVoxels(without, first, masks.none & all);
    appendVoxels(known, first, ~(masks.pairs | masks.none) & all);
  }
  pairs_.count = static_cast<std::size_t>(pairs - pairs_.voxels.data());
  known_.count = static_cast<std::size_t>(known - known_.voxels.data());
  new_.count = static_cast<std::size_t>(without - new_.voxels.data());
  // One without a partner goes last in the next row.
  if (pairs_.count % 2 != 0)
    known_.voxels[known_.count++] = pairs_.voxels[--pairs_.count];
}

void
FastSymbols::setOrigin(unsigned int origin, unsigned int bits)
{
  origin_ = origin;
  top_ = (1u << bits) - 1 - origin_;
  const bool has_steps = top_ >= symbol_steps::exact;
  highest_step_ = has_steps ? symbol_steps::stepOf(top_) + 1 : top_;
  top_step_ = has_steps ? highest_step_ : symbol_steps::highest + 1;
}

unsigned int
FastSymbols::stepOf(unsigned int value) const
{
  return value == top_ && value >= symbol_steps::exact ? top_step_
                                                       : symbol_steps::stepOf(value);
}

template <class Coder, class Symbol>
bool
FastSymbols::codePairs(Coder& coder_now,
                       FastModels& models,
                       std::uint16_t* moments,
                       Symbol* symbols)
{
  coder_now.expect(pairs_.count / 2);
  Coder coder = coder_now; // in registers
  const std::uint32_t* const voxels = pairs_.voxels.data();
  const VoxelPlace* const places = places_.data();
  const std::uint16_t* const before = before_.data();
  const unsigned int origin = origin_;
  std::uint64_t* escaped = pairs_.escapes.data();
  unsigned int highest = 0;
  for (std::size_t i = 0; i < pairs_.count; i += 2) {
    const std::uint32_t first = voxels[i];
    const std::uint32_t second = voxels[i + 1];
    const std::uint16_t first_moment = before[first];
    const std::uint16_t second_moment = before[second];
    unsigned int pair = 0;
    if (!Coder::is_decoder)
      pair = std::min(symbols[first] - origin, pair_escape) |
             std::min(symbols[second] - origin, pair_escape) << 2;
    const unsigned int context = pairClass(first_moment) * 3 + pairClass(second_moment);
    pair = coder.code(models.pair[context], pair);
    const unsigned int first_step = pair & 3;
    const unsigned int second_step = pair >> 2;
    moments[places[first]] = pair_moments_after[first_moment * 4u + first_step];
    moments[places[second]] = pair_moments_after[second_moment * 4u + second_step];
    *escaped = first;
    escaped += first_step == pair_escape ? 1 : 0;
    *escaped = second;
    escaped += second_step == pair_escape ? 1 : 0;
    if constexpr (Coder::is_decoder) {
      symbols[first] = static_cast<std::uint16_t>(first_step + origin);
      symbols[second] = static_cast<std::uint16_t>(second_step + origin);
      highest |= std::max(first_step % 3, second_step % 3);
    }
    if (coder.isOverrun())
      return false;
  }
  // 1 | 2 is more than 2 only where 2 is allowed or not anyway.
  highest_seen_ = std::min(highest, 2u);
  pairs_.escape_count = static_cast<std::size_t>(escaped - pairs_.escapes.data());
  coder_now = coder;
  return true;
}

template <class Coder, class Symbol>
bool
FastSymbols::codeKnown(Coder& coder_now,
                       FastModels& models,
                       std::uint16_t* moments,
                       Symbol* symbols)
{
  coder_now.expect(known_.count);
  Coder coder = coder_now;
  const std::uint32_t* const voxels = known_.voxels.data();
  const VoxelPlace* const places = places_.data();
  const std::uint16_t* const before = before_.data();
  const unsigned int origin = origin_;
  std::uint64_t* escaped = known_.escapes.data();
  Notes notes = this->notes();
  for (std::size_t i = 0; i < known_.count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const std::uint16_t moment = before[voxel];
    const symbol_moment::MeanClass mean =
        symbol_moment::mean_classes[symbol_moment::mean(moment)];
    const unsigned int context =
        mean.level * symbol_moment::spread_count +
        symbol_moment::spread(symbol_moment::deviation(moment));
    unsigned int symbol = 0;
    if (!Coder::is_decoder)
      symbol = std::min(stepOf(symbols[voxel] - origin) - mean.lowest, escape);
    symbol = coder.code(models.known_symbol[context], symbol);
    const unsigned int step = mean.lowest + symbol;
    const unsigned int is_escape = symbol == escape ? 1 : 0;
    moments[places[voxel]] = symbol_moment::next(moment, step);
    *escaped = voxel | std::uint64_t{mean.lowest} << 32;
    escaped += is_escape;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(step + origin);
    notes.add(voxel, step & (is_escape - 1));
    if (coder.isOverrun())
      return false;
  }
  known_.escape_count = static_cast<std::size_t>(escaped - known_.escapes.data());
  keep(notes);
  coder_now = coder;
  return true;
}

template <class Coder, class Symbol>
bool
FastSymbols::codeNew(Coder& coder_now,
                     FastModels& models,
                     bool is_i_frame,
                     std::uint16_t* moments,
                     Symbol* symbols)
{
  coder_now.expect(3 * new_.count);
  Coder coder = coder_now;
  const std::uint32_t* const voxels = new_.voxels.data();
  const VoxelPlace* const places = places_.data();
  const unsigned int origin = origin_;
  Notes notes = this->notes();
  auto& new_symbol = models.new_symbol[is_i_frame ? 1 : 0];
  // Over these voxels, as if they were one.
  std::uint16_t running = symbol_moment::first(2);
  for (std::size_t i = 0; i < new_.count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const symbol_moment::MeanClass mean =
        symbol_moment::mean_classes[symbol_moment::mean(running)];
    const unsigned int context =
        mean.level * symbol_moment::spread_count +
        symbol_moment::spread(symbol_moment::deviation(running));
    unsigned int step = Coder::is_decoder ? 0 : stepOf(symbols[voxel] - origin);
    const unsigned int symbol =
        coder.code(new_symbol[context], std::min(step - mean.lowest, escape));
    if (symbol == escape) {
      // Of a copy, so that the coder itself can stay in registers.
      Coder copy = coder;
      step = codeWholeStep(copy, models, step);
      coder = copy;
      if (step - mean.lowest < escape || step > symbol_steps::highest)
        return false;
    }
    else {
      step = mean.lowest + symbol;
    }
    moments[places[voxel]] = symbol_moment::first(step);
    running = symbol_moment::next(running, step);
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(step + origin);
    notes.add(voxel, step);
    if (coder.isOverrun())
      return false;
  }
  keep(notes);
  coder_now = coder;
  return true;
}

template <class Coder>
unsigned int
FastSymbols::codeWholeStep(Coder& coder, FastModels& models, unsigned int step)
{
  const unsigned int high = coder.code(models.escape_high, step >> 4);
  return high << 4 | coder.code(models.escape_low[high & 7], step & 15);
}

template <class Coder, class Symbol>
bool
FastSymbols::codeEscapes(
    Coder& coder, FastModels& models, Row& row, std::uint16_t* moments, Symbol* symbols)
{
  coder.expect(3 * row.escape_count);
  Notes notes = this->notes();
  for (std::size_t i = 0; i < row.escape_count; ++i) {
    const auto voxel = static_cast<std::uint32_t>(row.escapes[i]);
    const std::uint16_t moment = before_[voxel];
    unsigned int step = Coder::is_decoder ? 0 : stepOf(symbols[voxel] - origin_);
    // Which steps are none of these.
    auto lowest = static_cast<unsigned int>(row.escapes[i] >> 32);
    unsigned int end = lowest + escape;
    bool is_whole = true;
    if (&row == &pairs_) {
      end = pair_escape + escape;
      const unsigned int above = coder.code(models.pair_escape[pairClass(moment)],
                                            std::min(step - pair_escape, escape));
      is_whole = above == escape;
      step = is_whole ? step : pair_escape + above;
    }
    if (is_whole) {
      step = codeWholeStep(coder, models, step);
      if (Coder::is_decoder && step >= lowest && step < end)
        return false;
    }
    if (coder.isOverrun() || step > highest_step_)
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(step + origin_);
    moments[places_[voxel]] = symbol_moment::next(moment, step);
    notes.add(voxel, step);
  }
  keep(notes);
  return true;
}

template <class Coder, class Symbol>
bool
FastSymbols::codeBitsWithinSteps(Coder& coder_now, Symbol* symbols)
{
  coder_now.expect(wide_count_);
  Coder coder = coder_now;
  for (std::size_t i = 0; i < wide_count_; ++i) {
    Symbol& symbol = symbols[static_cast<std::uint32_t>(wide_[i])];
    const auto step = static_cast<unsigned int>(wide_[i] >> 32);
    unsigned int value = top_;
    if (step != top_step_) {
      const unsigned int bits = symbol_steps::bitsWithin(step);
      const unsigned int mask = (1u << bits) - 1;
      value = symbol_steps::lowestValue(step) |
              coder.codeBits(bits, (symbol - origin_) & mask);
      if (Coder::is_decoder && (value >= top_ || coder.isOverrun()))
        return false;
    }
    if constexpr (Coder::is_decoder)
      symbol = static_cast<std::uint16_t>(value + origin_);
  }
  coder_now = coder;
  return true;
}

} // namespace io
} // namespace pcl_ext
