#include "fast_symbols.h"

#include "symbol_moment.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

namespace {

// Four voxels with a low mean are coded together, as 0, 1, 2 or more.
constexpr unsigned int quad_moments =
    2 * symbol_moment::fraction * symbol_moment::deviation_count;
constexpr unsigned int quad_escape = 3;
// Symbols 0..14 of the other models are steps, 15 is any other one.
constexpr unsigned int escape = 15;

/** \brief The moments after the steps 0..2, for those that are coded in quads. */
constexpr std::array<std::uint16_t, quad_moments * 4>
makeQuadMoments()
{
  std::array<std::uint16_t, quad_moments * 4> after{};
  for (unsigned int moment = 0; moment < quad_moments; ++moment)
    for (unsigned int step = 0; step < quad_escape; ++step)
      after[moment * 4 + step] =
          symbol_moment::next(static_cast<std::uint16_t>(moment), step);
  return after;
}

constexpr auto quad_moments_after = makeQuadMoments();

/** \brief The same for those without a moment. */
constexpr std::array<std::uint16_t, 4> first_moments = {
    symbol_moment::first(0), symbol_moment::first(1), symbol_moment::first(2), 0};

} // namespace

template <class Coder, class Symbol>
bool
FastSymbols::code(Coder& coder,
                  FastModels& models,
                  const FastFrame& frame,
                  std::uint16_t* moments,
                  Symbol* symbols)
{
  for (unsigned int i = 0; i < low_class_count; ++i)
    if (!codeQuads(coder, models, i, moments, symbols))
      return false;
  if (!codeKnown(coder, models, moments, symbols) ||
      !codeNew(coder, models, frame.is_i_frame, moments, symbols))
    return false;
  for (const Row& row : quads_)
    if (!codeEscapes(coder, models, row, moments, symbols))
      return false;
  return codeEscapes(coder, models, known_, moments, symbols) &&
         codeBitsWithinSteps(coder, symbols);
}

template <class Coder, class Symbol>
bool
FastSymbols::codeQuads(Coder& coder_now,
                       FastModels& models,
                       unsigned int low_class,
                       std::uint16_t* moments,
                       Symbol* symbols)
{
  Row& row = quads_[low_class];
  QuadModel& model = models.quad[low_class];
  coder_now.expect(row.count / 4);
  Coder coder = coder_now; // in registers
  const std::uint32_t* voxels = row.voxels.data();
  const VoxelPlace* const places = places_;
  const std::uint16_t* const before = before_.data();
  const unsigned int origin = origin_;
  const bool has_moments = low_class != without_moment;
  const std::uint16_t* const after =
      has_moments ? quad_moments_after.data() : first_moments.data();
  const unsigned int after_steps = has_moments ? 4 : 0;
  std::uint64_t* escaped = row.escapes.data();
  for (std::size_t i = 0; i < row.count / 4; ++i, voxels += 4) {
    unsigned int quad = 0;
    if (!Coder::is_decoder)
      for (unsigned int k = 0; k < 4; ++k)
        quad |= std::min(symbols[voxels[k]] - origin, quad_escape) << 2 * k;
    quad = coder.code(model, quad);
    for (unsigned int k = 0; k < 4; ++k) {
      const std::uint32_t voxel = voxels[k];
      const unsigned int step = quad >> 2 * k & 3;
      moments[places[voxel]] = after[before[voxel] * after_steps + step];
      *escaped = voxel;
      escaped += (step + 1) >> 2;
      if constexpr (Coder::is_decoder)
        symbols[voxel] = static_cast<std::uint16_t>(step + origin);
    }
    if (coder.isOverrun())
      return false;
  }
  row.escape_count = static_cast<std::size_t>(escaped - row.escapes.data());
  coder_now = coder;
  return true;
}

unsigned int
FastSymbols::stepOf(unsigned int value) const
{
  return value == top_ && value >= symbol_steps::exact ? top_step_
                                                       : symbol_steps::stepOf(value);
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
  const VoxelPlace* const places = places_;
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
  const VoxelPlace* const places = places_;
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
    Coder& coder, FastModels& models, const Row& row, std::uint16_t* moments, Symbol* symbols)
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
    if (&row != &known_) {
      const auto low_class = static_cast<std::size_t>(&row - quads_.data());
      end = quad_escape + escape;
      const unsigned int above = coder.code(models.quad_escape[low_class],
                                            std::min(step - quad_escape, escape));
      is_whole = above == escape;
      step = is_whole ? step : quad_escape + above;
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
    moments[places_[voxel]] = moment == FastHistory::no_moment
                                  ? symbol_moment::first(step)
                                  : symbol_moment::next(moment, step);
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
    if (step > highest_step_)
      return false;
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

template bool
FastSymbols::code(
    NibbleEncoder&, FastModels&, const FastFrame&, std::uint16_t*, const std::uint16_t*);
template bool
FastSymbols::code(
    NibbleDecoder&, FastModels&, const FastFrame&, std::uint16_t*, std::uint16_t*);

} // namespace io
} // namespace pcl_ext
