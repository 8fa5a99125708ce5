#include "codec/fast/intensities.h"
#include "codec/fast/symbol_moment.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

// Four voxels with a low mean are coded together, as 0, 1, 2 or more.
constexpr unsigned int quad_moments =
    2 * symbol_moment::fraction * symbol_moment::deviation_count;
constexpr unsigned int quad_escape = 3;

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
Intensities::code(Coder& coder,
                  Models& models,
                  const Frame& frame,
                  std::uint16_t* moments,
                  Symbol* symbols)
{
  for (unsigned int i = 0; i < low_class_count; ++i)
    if (!codeQuads(coder, models, i, moments, symbols))
      return false;
  if (!codeKnown(coder, models, moments, symbols) ||
      !codeNew(coder, models, frame.is_i_frame, moments, symbols))
    return false;
  for (unsigned int i = 0; i < low_class_count; ++i)
    if (!codeHighQuadSteps(coder, models, i, moments, symbols))
      return false;
  return codeNotedSteps(coder, models, moments, symbols);
}

template <class Coder, class Symbol>
bool
Intensities::codeQuads(Coder& coder,
                       Models& models,
                       unsigned int low_class,
                       std::uint16_t* moments,
                       Symbol* symbols)
{
  Row& row = quads_[low_class];
  const std::size_t count = row.count / 4;
  coder.expect(count);
  std::uint8_t* const coded = coded_.data();
  const unsigned int origin = origin_;
  if (!Coder::is_decoder)
    for (std::size_t i = 0; i < count; ++i) {
      unsigned int quad = 0;
      for (unsigned int k = 0; k < 4; ++k)
        quad |= std::min(symbols[row.voxels[4 * i + k]] - origin, quad_escape) << 2 * k;
      coded[i] = static_cast<std::uint8_t>(quad);
    }
  if (!coder.codeRow(models.quad[low_class], coded, count))
    return false;
  std::uint32_t* const row_voxels = row.voxels.data();
  const std::uint32_t* voxels = row_voxels;
  // Behind which the loop always is.
  std::uint32_t* noted = row_voxels;
  const VoxelPlace* const places = places_;
  const std::uint16_t* const before = before_.data();
  const bool has_moments = low_class != without_moment;
  const std::uint16_t* const after =
      has_moments ? quad_moments_after.data() : first_moments.data();
  const unsigned int after_steps = has_moments ? 4 : 0;
  for (std::size_t i = 0; i < count; ++i, voxels += 4)
    for (unsigned int k = 0; k < 4; ++k) {
      const std::uint32_t voxel = voxels[k];
      const unsigned int step = coded[i] >> 2 * k & 3;
      moments[places[voxel]] = after[before[voxel] * after_steps + step];
      *noted = voxel;
      noted += (step + 1) >> 2;
      if constexpr (Coder::is_decoder)
        symbols[voxel] = static_cast<std::uint16_t>(step + origin);
    }
  row.noted = static_cast<std::size_t>(noted - row_voxels);
  return true;
}

unsigned int
Intensities::stepOf(unsigned int value) const
{
  return value == top_ && value >= symbol_steps::exact ? top_step_
                                                       : symbol_steps::stepOf(value);
}

template <class Coder, class Symbol>
bool
Intensities::codeKnown(Coder& coder,
                       Models& models,
                       std::uint16_t* moments,
                       Symbol* symbols)
{
  const std::size_t count = known_.count;
  coder.expect(count);
  std::uint32_t* const voxels = known_.voxels.data();
  const std::uint16_t* const before = before_.data();
  std::uint16_t* const known_moments = known_moments_.data();
  std::uint8_t* const contexts = contexts_.data();
  std::uint8_t* const coded = coded_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t moment = before[voxels[i]];
    known_moments[i] = moment;
    contexts[i] = static_cast<std::uint8_t>(symbol_moment::contextOf(moment));
    if (!Coder::is_decoder) {
      const unsigned int lowest = symbol_moment::lowestStep(moment);
      coded[i] = static_cast<std::uint8_t>(
          std::min(stepOf(symbols[voxels[i]] - origin_) - lowest, escape));
    }
  }
  if (!coder.codeRow(models.known_symbol.data(), contexts, coded, count))
    return false;
  learnKnown<Coder::is_decoder>(moments, symbols);
  return true;
}

/** \brief Makes the moments behind the symbols of voxels that have one, and in a decoder
 * the symbols, as far as they are coded. */
template <bool is_decoder, class Symbol>
void
Intensities::learnKnown(std::uint16_t* moments, Symbol* symbols)
{
  const std::size_t count = known_.count;
  std::uint32_t* const voxels = known_.voxels.data();
  const VoxelPlace* const places = places_;
  std::uint16_t* const known_moments = known_moments_.data();
  const std::uint8_t* const coded = coded_.data();
  std::uint8_t* const steps = contexts_.data(); // which are not needed any more
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t moment = known_moments[i];
    const auto step =
        static_cast<std::uint16_t>(symbol_moment::lowestStep(moment) + coded[i]);
    steps[i] = static_cast<std::uint8_t>(step);
    known_moments[i] = symbol_moment::next(moment, step);
  }
  const unsigned int origin = origin_;
  std::size_t noted = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const unsigned int step = steps[i];
    moments[places[voxel]] = known_moments[i];
    if constexpr (is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(step + origin);
    // Those with a 15 and those with bits within their step.
    voxels[noted] = voxel;
    noted += ((coded[i] + 1u) | step) >> 4 != 0 ? 1 : 0;
  }
  known_.noted = noted;
}

template <class Coder, class Symbol>
bool
Intensities::codeNew(Coder& coder_now,
                     Models& models,
                     bool is_i_frame,
                     std::uint16_t* moments,
                     Symbol* symbols)
{
  coder_now.expect(4 * new_.count);
  Coder coder = coder_now;
  const std::uint32_t* const voxels = new_.voxels.data();
  const VoxelPlace* const places = places_;
  auto& new_symbol = models.new_symbol[is_i_frame ? 1 : 0];
  std::size_t low = 0;
  // Over these voxels, as if they were one.
  std::uint16_t running = symbol_moment::first(2);
  for (std::size_t i = 0; i < new_.count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const unsigned int lowest = symbol_moment::lowestStep(running);
    unsigned int value = Coder::is_decoder ? 0 : symbols[voxel] - origin_;
    unsigned int step = Coder::is_decoder ? 0 : stepOf(value);
    const unsigned int symbol = coder.code(
        new_symbol[symbol_moment::contextOf(running)], std::min(step - lowest, escape));
    step = lowest + symbol;
    if (((symbol + 1) | step) >> 4 != 0) {
      // Of a copy, so that the coder itself can stay in registers.
      Coder copy = coder;
      if (symbol == escape && !codeWholeStep(copy, models, lowest, value, step))
        return false;
      if (!codeValue(copy, step, value))
        return false;
      coder = copy;
    }
    else {
      value = step;
    }
    moments[places[voxel]] = symbol_moment::first(step);
    running = symbol_moment::next(running, step);
    low += step < quad_escape ? 1 : 0;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
    if (coder.isOverrun())
      return false;
  }
  // Do they fit into quads, by and large?
  const Row& quads = quads_[without_moment];
  const std::size_t count = new_.count + quads.count;
  low += quads.count - quads.noted;
  if (count != 0)
    models.new_steps_are_low = low > count / 8 * 7;
  coder_now = coder;
  return true;
}

/** \brief Codes the step of a value, which is none of the fifteen from `lowest` on. */
template <class Coder>
bool
Intensities::codeWholeStep(Coder& coder,
                           Models& models,
                           unsigned int lowest,
                           unsigned int value,
                           unsigned int& step)
{
  step = Coder::is_decoder ? 0 : stepOf(value);
  const unsigned int high = coder.code(models.escape_high, step >> 4);
  step = high << 4 | coder.code(models.escape_low[high & 7], step & 15);
  return step - lowest >= escape;
}

/** \brief Codes the bits within a step; for a decoder they make the value. */
template <class Coder>
bool
Intensities::codeValue(Coder& coder, unsigned int step, unsigned int& value)
{
  if (step > highest_step_)
    return false;
  if (step == top_step_)
    value = top_;
  else if (step < symbol_steps::exact)
    value = step;
  else {
    const unsigned int bits = symbol_steps::bitsWithin(step);
    value = symbol_steps::lowestValue(step) |
            coder.codeBits(bits, value & ((1u << bits) - 1));
    return value < top_ && !coder.isOverrun();
  }
  return true;
}

template <class Coder, class Symbol>
bool
Intensities::codeHighQuadSteps(Coder& coder,
                               Models& models,
                               unsigned int low_class,
                               std::uint16_t* moments,
                               Symbol* symbols)
{
  const Row& row = quads_[low_class];
  coder.expect(4 * row.noted);
  for (std::size_t i = 0; i < row.noted; ++i) {
    const std::uint32_t voxel = row.voxels[i];
    unsigned int value = Coder::is_decoder ? 0 : symbols[voxel] - origin_;
    unsigned int step = Coder::is_decoder ? 0 : stepOf(value);
    const unsigned int above =
        coder.code(models.quad_escape[low_class], std::min(step - quad_escape, escape));
    step = quad_escape + above;
    if (above == escape && !codeWholeStep(coder, models, quad_escape, value, step))
      return false;
    if (!codeValue(coder, step, value) || step < quad_escape || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
    moments[places_[voxel]] = low_class == without_moment
                                  ? symbol_moment::first(step)
                                  : symbol_moment::next(before_[voxel], step);
  }
  return true;
}

/** \brief What remains of the voxels with a moment: steps that did not fit, and the bits
 * within steps. */
template <class Coder, class Symbol>
bool
Intensities::codeNotedSteps(Coder& coder,
                            Models& models,
                            std::uint16_t* moments,
                            Symbol* symbols)
{
  coder.expect(3 * known_.noted);
  for (std::size_t i = 0; i < known_.noted; ++i) {
    const std::uint32_t voxel = known_.voxels[i];
    const std::uint16_t moment = before_[voxel];
    const unsigned int lowest = symbol_moment::lowestStep(moment);
    unsigned int value = symbols[voxel] - origin_;
    // In a decoder it is the step so far.
    unsigned int step = Coder::is_decoder ? value : stepOf(value);
    if (step - lowest >= escape) {
      if (!codeWholeStep(coder, models, lowest, value, step))
        return false;
      moments[places_[voxel]] = symbol_moment::next(moment, step);
    }
    if (!codeValue(coder, step, value) || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
  }
  return true;
}

template bool
Intensities::code(
    NibbleEncoder&, Models&, const Frame&, std::uint16_t*, const std::uint16_t*);
template bool
Intensities::code(
    NibbleDecoder&, Models&, const Frame&, std::uint16_t*, std::uint16_t*);

} // namespace fast
} // namespace io
} // namespace pcl_ext
