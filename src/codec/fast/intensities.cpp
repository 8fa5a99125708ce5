#include "codec/fast/intensities.h"

#include <algorithm>
#include <cstddef>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

/** \brief Codes symbols without statistics: the high eight bits with a model, the others
 * bypass it. */
template <class Coder, class Symbol>
bool
codePlain(
    Coder& coder, Models& models, unsigned int bits, std::size_t count, Symbol* symbols)
{
  const unsigned int low_bits = bits > 8 ? bits - 8 : 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Each symbol is coded as at most three of the coder's symbols.
    static_assert(3 * 16 <= NibbleDecoder::slack, "isOverrun is called often enough");
    if (i % 16 == 0 && coder.isOverrun())
      return false;
    const auto symbol = Coder::is_decoder ? 0u : static_cast<unsigned int>(symbols[i]);
    const unsigned int high = codeByte(coder, models.plain, 0, symbol >> low_bits);
    unsigned int decoded = high << low_bits;
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

} // namespace

void
Intensities::encode(NibbleEncoder& coder,
                    Models& models,
                    const Frame& frame,
                    StatisticsTable& statistics,
                    unsigned int bits,
                    const std::vector<std::uint16_t>& symbols)
{
  const NibbleEncoder::Mark start = coder.mark();
  models_before_ = models;
  encodeExpected(coder, models, frame, statistics, bits, symbols);
  // Plain coding needs at least two of the coder's symbols for each symbol. It is not tried
  // below 5/4.
  const NibbleEncoder::Mark end = coder.mark();
  if (4 * (end - start) < 5 * symbols.size())
    return;
  const std::uint64_t expected_cost = coder.cost(start);
  restore(frame, statistics);
  models = models_before_;
  coder.reserve(1 + 3 * symbols.size());
  coder.codeBits(1, 1);
  codePlain(coder, models, bits, symbols.size(), symbols.data());
  // The statistics of an I-frame save bytes in the following frames.
  const std::uint64_t plain_cost = coder.cost(end);
  if (frame.is_i_frame ? 16 * plain_cost < 15 * expected_cost
                       : plain_cost < expected_cost) {
    coder.erase(start, end);
    return;
  }
  coder.erase(end, coder.mark());
  models = models_before_;
  coder.erase(start, end);
  encodeExpected(coder, models, frame, statistics, bits, symbols);
}

void
Intensities::encodeExpected(NibbleEncoder& coder,
                            Models& models,
                            const Frame& frame,
                            StatisticsTable& statistics,
                            unsigned int bits,
                            const std::vector<std::uint16_t>& symbols)
{
  unsigned int has_zeros = 0;
  for (const std::uint16_t symbol : symbols)
    has_zeros |= symbol == 0 ? 1u : 0u;
  coder.reserve(2);
  coder.codeBits(1, 0);
  const unsigned int origin = coder.codeBits(1, 1 - has_zeros);
  expected_.begin(frame, statistics);
  expected_.code(coder, models, frame, origin, bits, statistics, symbols.data());
}

bool
Intensities::decode(NibbleDecoder& coder,
                    Models& models,
                    const Frame& frame,
                    StatisticsTable& statistics,
                    unsigned int bits,
                    std::vector<std::uint16_t>& symbols)
{
  symbols.resize(frame.voxel_count);
  const bool is_plain = coder.codeBits(1, 0) != 0;
  const unsigned int origin = is_plain ? 0 : coder.codeBits(1, 0);
  expected_.begin(frame, statistics);
  if (is_plain)
    return codePlain(coder, models, bits, frame.voxel_count, symbols.data());
  return expected_.code(
             coder, models, frame, origin, bits, statistics, symbols.data()) &&
         expected_.areValid(symbols);
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
