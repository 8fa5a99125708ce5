#include "codec/fast/expected_intensities.h"

#include "codec/fast/entropy_coder.h"
#include "codec/fast/symbol_statistics.h"

#include <algorithm>
#include <array>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

// In a quad 0..2 are bins, and 3 stands for all higher ones.
constexpr unsigned int quad_escape = 3;

/** \brief Upper bound of the statistics of voxels that are coded in quads. */
constexpr unsigned int quad_statistics_end =
    2 * symbol_statistics::fraction * symbol_statistics::deviation_count;

/** \brief Next statistics of voxels that are coded in quads, by statistics and bin 0..2. */
constexpr std::array<std::uint16_t, quad_statistics_end * 4>
makeNextQuadStatistics()
{
  std::array<std::uint16_t, quad_statistics_end * 4> next{};
  for (unsigned int before = 0; before < quad_statistics_end; ++before)
    for (unsigned int bin = 0; bin < quad_escape; ++bin)
      next[before * 4 + bin] =
          symbol_statistics::next(static_cast<std::uint16_t>(before), bin);
  return next;
}

constexpr auto next_quad_statistics = makeNextQuadStatistics();

/** \brief The same for voxels without statistics. */
constexpr std::array<std::uint16_t, 4> first_quad_statistics = {
    symbol_statistics::first(0),
    symbol_statistics::first(1),
    symbol_statistics::first(2),
    0};

} // namespace

void
ExpectedIntensities::begin(const Frame& frame, const StatisticsTable& statistics)
{
  places_ = frame.places.data();
  ensureSize(contexts_, frame.voxel_count);
  ensureSize(coded_, frame.voxel_count);
  ensureSize(known_statistics_, frame.voxel_count);
  rows_.sort(frame, statistics);
}

void
ExpectedIntensities::restore(const Frame& frame, StatisticsTable& statistics) const
{
  for (std::size_t i = 0; i < frame.voxel_count; ++i)
    statistics[frame.places[i]] = rows_.before[i];
}

bool
ExpectedIntensities::areValid(const std::vector<std::uint16_t>& symbols) const
{
  const auto highest = static_cast<std::uint16_t>(top_ + origin_);
  // By comparisons, as SSE2 has no minimum and maximum of unsigned numbers.
  std::uint16_t is_any_zero = 0;
  std::uint16_t is_any_above = 0;
  for (const std::uint16_t symbol : symbols) {
    is_any_zero = static_cast<std::uint16_t>(is_any_zero | (symbol == 0 ? 1 : 0));
    is_any_above =
        static_cast<std::uint16_t>(is_any_above | (symbol > highest ? 1 : 0));
  }
  // An encoder chooses origin 0 only if there is a 0.
  return is_any_above == 0 && (origin_ == 1 || is_any_zero != 0);
}

void
ExpectedIntensities::setRange(unsigned int origin, unsigned int bits)
{
  origin_ = origin;
  top_ = (1u << bits) - 1 - origin;
  const bool has_low_bits = top_ >= intensity_bins::exact;
  highest_bin_ = has_low_bits ? intensity_bins::binOf(top_) + 1 : top_;
  top_bin_ = has_low_bits ? highest_bin_ : intensity_bins::highest + 1;
}

template <class Coder, class Symbol>
bool
ExpectedIntensities::code(Coder& coder,
                          Models& models,
                          const Frame& frame,
                          unsigned int origin,
                          unsigned int bits,
                          StatisticsTable& all_statistics,
                          Symbol* symbols)
{
  setRange(origin, bits);
  rows_.splitFresh(!frame.is_i_frame && models.new_bins_are_low);
  std::uint16_t* const statistics = all_statistics.data();
  for (std::size_t i = 0; i < IntensityRows::low_class_count; ++i)
    if (!codeQuads(coder, models, i, statistics, symbols))
      return false;
  if (!codeKnown(coder, models, statistics, symbols) ||
      !codeFresh(coder, models, frame.is_i_frame, statistics, symbols))
    return false;
  for (std::size_t i = 0; i < IntensityRows::low_class_count; ++i)
    if (!codeHighQuadBins(coder, models, i, statistics, symbols))
      return false;
  return codeNotedBins(coder, models, statistics, symbols);
}

template <class Coder, class Symbol>
bool
ExpectedIntensities::codeQuads(Coder& coder,
                               Models& models,
                               std::size_t low_class,
                               std::uint16_t* statistics,
                               Symbol* symbols)
{
  Row& row = rows_.quads[low_class];
  const std::size_t count = row.count / 4;
  coder.reserve(count);
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
  // Overwrites coded voxels of the row.
  std::uint32_t* noted = row_voxels;
  const VoxelPlace* const places = places_;
  const std::uint16_t* const before = rows_.before.data();
  const bool has_statistics = low_class != IntensityRows::without_statistics;
  const std::uint16_t* const after =
      has_statistics ? next_quad_statistics.data() : first_quad_statistics.data();
  const unsigned int bins_per_statistics = has_statistics ? 4 : 0;
  for (std::size_t i = 0; i < count; ++i, voxels += 4)
    for (unsigned int k = 0; k < 4; ++k) {
      const std::uint32_t voxel = voxels[k];
      const unsigned int bin = coded[i] >> 2 * k & 3;
      statistics[places[voxel]] = after[before[voxel] * bins_per_statistics + bin];
      *noted = voxel;
      noted += (bin + 1) >> 2;
      if constexpr (Coder::is_decoder)
        symbols[voxel] = static_cast<std::uint16_t>(bin + origin);
    }
  row.noted = static_cast<std::size_t>(noted - row_voxels);
  return true;
}

unsigned int
ExpectedIntensities::binOf(unsigned int value) const
{
  return value == top_ && value >= intensity_bins::exact ? top_bin_
                                                         : intensity_bins::binOf(value);
}

template <class Coder, class Symbol>
bool
ExpectedIntensities::codeKnown(Coder& coder,
                               Models& models,
                               std::uint16_t* statistics,
                               Symbol* symbols)
{
  const std::size_t count = rows_.known.count;
  coder.reserve(count);
  std::uint32_t* const voxels = rows_.known.voxels.data();
  const std::uint16_t* const before = rows_.before.data();
  std::uint16_t* const known_statistics = known_statistics_.data();
  std::uint8_t* const contexts = contexts_.data();
  std::uint8_t* const coded = coded_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t voxel_statistics = before[voxels[i]];
    known_statistics[i] = voxel_statistics;
    contexts[i] =
        static_cast<std::uint8_t>(symbol_statistics::contextOf(voxel_statistics));
    if (!Coder::is_decoder) {
      const unsigned int lowest = symbol_statistics::lowestBin(voxel_statistics);
      coded[i] = static_cast<std::uint8_t>(
          std::min(binOf(symbols[voxels[i]] - origin_) - lowest, escape));
    }
  }
  if (!coder.codeRow(models.known_symbol.data(), contexts, coded, count))
    return false;
  learnKnown<Coder::is_decoder>(statistics, symbols);
  return true;
}

/** \brief Updates the statistics of voxels that have some and, in a decoder, sets their
 * symbols, as far as they are coded. */
template <bool is_decoder, class Symbol>
void
ExpectedIntensities::learnKnown(std::uint16_t* statistics, Symbol* symbols)
{
  const std::size_t count = rows_.known.count;
  std::uint32_t* const voxels = rows_.known.voxels.data();
  const VoxelPlace* const places = places_;
  std::uint16_t* const known_statistics = known_statistics_.data();
  const std::uint8_t* const coded = coded_.data();
  std::uint8_t* const bins = contexts_.data(); // the contexts are not needed any more
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t voxel_statistics = known_statistics[i];
    const auto bin = static_cast<std::uint16_t>(
        symbol_statistics::lowestBin(voxel_statistics) + coded[i]);
    bins[i] = static_cast<std::uint8_t>(bin);
    known_statistics[i] = symbol_statistics::next(voxel_statistics, bin);
  }
  const unsigned int origin = origin_;
  std::size_t noted = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const unsigned int bin = bins[i];
    statistics[places[voxel]] = known_statistics[i];
    if constexpr (is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(bin + origin);
    // Voxels with an escaped bin or with low bits.
    voxels[noted] = voxel;
    noted += ((coded[i] + 1u) | bin) >> 4 != 0 ? 1 : 0;
  }
  rows_.known.noted = noted;
}

template <class Coder, class Symbol>
bool
ExpectedIntensities::codeFresh(Coder& coder_now,
                               Models& models,
                               bool is_i_frame,
                               std::uint16_t* statistics,
                               Symbol* symbols)
{
  coder_now.reserve(4 * rows_.fresh.count);
  Coder coder = coder_now;
  const std::uint32_t* const voxels = rows_.fresh.voxels.data();
  const VoxelPlace* const places = places_;
  auto& new_symbol = models.new_symbol[is_i_frame ? 1 : 0];
  std::size_t low = 0;
  // Common statistics of these voxels.
  std::uint16_t running = symbol_statistics::first(2);
  for (std::size_t i = 0; i < rows_.fresh.count; ++i) {
    const std::uint32_t voxel = voxels[i];
    const unsigned int lowest = symbol_statistics::lowestBin(running);
    unsigned int value = Coder::is_decoder ? 0 : symbols[voxel] - origin_;
    unsigned int bin = Coder::is_decoder ? 0 : binOf(value);
    const unsigned int symbol =
        coder.code(new_symbol[symbol_statistics::contextOf(running)],
                   std::min(bin - lowest, escape));
    bin = lowest + symbol;
    if (((symbol + 1) | bin) >> 4 != 0) {
      // By a copy, so that the coder itself stays in registers.
      Coder copy = coder;
      if (symbol == escape && !codeWholeBin(copy, models, lowest, value, bin))
        return false;
      if (!codeValue(copy, bin, value))
        return false;
      coder = copy;
    }
    else {
      value = bin;
    }
    statistics[places[voxel]] = symbol_statistics::first(bin);
    running = symbol_statistics::next(running, bin);
    low += bin < quad_escape ? 1 : 0;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
    if (coder.isOverrun())
      return false;
  }
  // Decides whether such voxels of the next frame are coded in quads.
  const Row& quads = rows_.quads[IntensityRows::without_statistics];
  const std::size_t count = rows_.fresh.count + quads.count;
  low += quads.count - quads.noted;
  if (count != 0)
    models.new_bins_are_low = low > count / 8 * 7;
  coder_now = coder;
  return true;
}

/** \brief Codes an escaped bin, which is not one of the fifteen from `lowest` on. */
template <class Coder>
bool
ExpectedIntensities::codeWholeBin(Coder& coder,
                                  Models& models,
                                  unsigned int lowest,
                                  unsigned int value,
                                  unsigned int& bin)
{
  bin = Coder::is_decoder ? 0 : binOf(value);
  const unsigned int high = coder.code(models.escape_high, bin >> 4);
  bin = high << 4 | coder.code(models.escape_low[high & 7], bin & 15);
  return bin - lowest >= escape;
}

/** \brief Codes the low bits of a value in a bin; a decoder sets the value. */
template <class Coder>
bool
ExpectedIntensities::codeValue(Coder& coder, unsigned int bin, unsigned int& value)
{
  if (bin > highest_bin_)
    return false;
  if (bin == top_bin_)
    value = top_;
  else if (bin < intensity_bins::exact)
    value = bin;
  else {
    const unsigned int bits = intensity_bins::lowBits(bin);
    value = intensity_bins::lowestValue(bin) |
            coder.codeBits(bits, value & ((1u << bits) - 1));
    return value < top_ && !coder.isOverrun();
  }
  return true;
}

template <class Coder, class Symbol>
bool
ExpectedIntensities::codeHighQuadBins(Coder& coder,
                                      Models& models,
                                      std::size_t low_class,
                                      std::uint16_t* statistics,
                                      Symbol* symbols)
{
  const Row& row = rows_.quads[low_class];
  coder.reserve(4 * row.noted);
  for (std::size_t i = 0; i < row.noted; ++i) {
    const std::uint32_t voxel = row.voxels[i];
    unsigned int value = Coder::is_decoder ? 0 : symbols[voxel] - origin_;
    unsigned int bin = Coder::is_decoder ? 0 : binOf(value);
    const unsigned int above =
        coder.code(models.quad_escape[low_class], std::min(bin - quad_escape, escape));
    bin = quad_escape + above;
    if (above == escape && !codeWholeBin(coder, models, quad_escape, value, bin))
      return false;
    if (!codeValue(coder, bin, value) || bin < quad_escape || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
    statistics[places_[voxel]] =
        low_class == IntensityRows::without_statistics
            ? symbol_statistics::first(bin)
            : symbol_statistics::next(rows_.before[voxel], bin);
  }
  return true;
}

/** \brief Codes escaped bins and low bits of the voxels with statistics. */
template <class Coder, class Symbol>
bool
ExpectedIntensities::codeNotedBins(Coder& coder,
                                   Models& models,
                                   std::uint16_t* statistics,
                                   Symbol* symbols)
{
  coder.reserve(3 * rows_.known.noted);
  for (std::size_t i = 0; i < rows_.known.noted; ++i) {
    const std::uint32_t voxel = rows_.known.voxels[i];
    const std::uint16_t voxel_statistics = rows_.before[voxel];
    const unsigned int lowest = symbol_statistics::lowestBin(voxel_statistics);
    unsigned int value = symbols[voxel] - origin_;
    // In a decoder the symbol is the bin as far as it is coded.
    unsigned int bin = Coder::is_decoder ? value : binOf(value);
    if (bin - lowest >= escape) {
      if (!codeWholeBin(coder, models, lowest, value, bin))
        return false;
      statistics[places_[voxel]] = symbol_statistics::next(voxel_statistics, bin);
    }
    if (!codeValue(coder, bin, value) || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value + origin_);
  }
  return true;
}

template bool
ExpectedIntensities::code(NibbleEncoder&,
                          Models&,
                          const Frame&,
                          unsigned int,
                          unsigned int,
                          StatisticsTable&,
                          const std::uint16_t*);
template bool
ExpectedIntensities::code(NibbleDecoder&,
                          Models&,
                          const Frame&,
                          unsigned int,
                          unsigned int,
                          StatisticsTable&,
                          std::uint16_t*);

} // namespace fast
} // namespace io
} // namespace pcl_ext
