#pragma once

#include "codec/context/frame.h"
#include "codec/context/history.h"
#include "codec/context/intensity_neighbours.h"
#include "codec/context/models.h"
#include "codec/depth_split.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Models of intensity symbols (doc/bitstream_context.md, "Numbers"). */
struct IntensityModels {
  static constexpr std::uint32_t longest_count = 24;
  static constexpr std::uint32_t longest_distance = 28;
  static constexpr std::uint32_t longest_residual = 32;
  static constexpr std::uint32_t longest_escape = 17; ///< bits

  explicit IntensityModels(bool is_mixing)
  : more(is_mixing,
         5,
         {240 * longest_count,
          640 * longest_count,
          512 * longest_count,
          240 * longest_count},
         20)
  , differs(is_mixing, 5, {14 * 4})
  , above(is_mixing, 5, {14 * 4})
  , farther(is_mixing, 5, {14 * 4 * 2 * longest_distance})
  , residual(is_mixing,
             5,
             {DepthSplit::class_count * longest_residual,
              768 * longest_residual,
              512 * longest_residual},
             8)
  , escape(is_mixing, 5, {3 * longest_escape})
  , plain(is_mixing, 6, {256})
  {}

  DecisionModel<4> more;     ///< a small symbol is above the value so far
  DecisionModel<1> differs;  ///< a large symbol differs from the expected one
  DecisionModel<1> above;    ///< and is above it
  DecisionModel<1> farther;  ///< its distance is above the value so far
  DecisionModel<3> residual; ///< a residual is above the value so far
  DecisionModel<1> escape;   ///< number of bits of an escaped number
  DecisionModel<1> plain;    ///< bits of a plain number
};

/** \brief Codes the intensity symbols of a frame's voxels, for either direction.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class IntensityPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] directory scratch memory
   * \param[in] context of the frame
   */
  IntensityPass(CodingT& coding,
                IntensityModels& models,
                BlockDirectory& directory,
                const FrameContext& context)
  : coding_(coding)
  , models_(models)
  , directory_(directory)
  , history_(context.history)
  , levels_(levelsAboveBlocks(context.grid_depth))
  , symbol_bits_(context.symbol_bits)
  , max_symbol_(context.maxSymbol())
  {}

  /** \brief Codes the symbols.
   * \param[in] frame the frame's blocks
   * \param[in] is_plain whether to code without expected values, as for noise; not used
   * by a decoder
   * \param[in,out] symbols one for each voxel; the decoder fills them
   * \return false if the decoded numbers are not symbols of that many bits
   */
  bool
  run(const BlockList& frame, bool is_plain, std::vector<std::uint16_t>& symbols)
  {
    if (!coding_.codeBypass(is_plain))
      return runExpected(frame, symbols);
    for (std::uint16_t& symbol : symbols)
      symbol = static_cast<std::uint16_t>(codePlain(symbol));
    return true;
  }

  /** \brief Codes the residuals of a depth model.
   * \param[in] split after predict()
   * \param[in,out] symbols one for each voxel; a decoder replaces the numbers of points by
   * the symbols
   * \return false if the decoded numbers are not symbols
   */
  bool
  codeResiduals(const DepthSplit& split, std::vector<std::uint16_t>& symbols)
  {
    std::uint32_t running_residual = 16; // mean so far, in sixteenths
    for (std::size_t i = 0; i < symbols.size(); ++i) {
      const std::uint8_t residual_class = split.classes()[i];
      if (residual_class == DepthSplit::no_residual)
        continue;
      const std::uint32_t target =
          CodingT::is_decoder ? 0 : split.residual(i, symbols[i]);
      DecisionModel<3>::Contexts contexts;
      contexts.ways[0] = residual_class * IntensityModels::longest_residual;
      if constexpr (CodingT::is_mixing) {
        const std::uint32_t place = split.place(i);
        contexts.ways[1] =
            (place * 6 + residual_class % 6) * IntensityModels::longest_residual;
        contexts.ways[2] =
            (((place >> 2) * 4 + std::min(running_residual / 8, 3u)) * 4 +
             split.pointClass(i)) *
            IntensityModels::longest_residual;
      }
      std::uint32_t residual = 0;
      for (; residual < IntensityModels::longest_residual; ++residual) {
        contexts.weight_set = std::min(residual, 7u);
        if (!coding_.code(models_.residual, contexts, target > residual))
          break;
        for (std::uint32_t& context : contexts.ways)
          ++context;
      }
      if (residual == IntensityModels::longest_residual) {
        const std::uint32_t beyond = codeEscape(2, target - residual);
        if (beyond == invalid)
          return false;
        residual += beyond;
      }
      if (!split.symbol(i, residual, symbols[i]))
        return false;
      running_residual += (16 * std::min(residual, 64u) >> 3) - (running_residual >> 3);
    }
    return true;
  }

private:
  static constexpr std::size_t no_record = static_cast<std::size_t>(-1);
  static constexpr std::uint32_t invalid = 0xffffffff;
  static constexpr std::uint32_t longest_escape = IntensityModels::longest_escape;

  bool
  runExpected(const BlockList& frame, std::vector<std::uint16_t>& symbols)
  {
    // Counts of points have no 0: unary codes then start at 1.
    const bool has_zero = coding_.codeBypass(
        std::find(symbols.begin(), symbols.end(), 0) != symbols.end());
    lowest_ = has_zero ? 0 : 1;
    const std::vector<HistoryBlock>& known = history_.blocks();
    [[maybe_unused]] IntensityNeighbours neighbours(frame, levels_, directory_);
    if constexpr (CodingT::is_mixing)
      neighbours.begin();
    AscendingLookup<HistoryBlock> lookup(known);
    std::size_t voxel = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::size_t old = lookup.find(frame.keys[i]);
      const std::uint64_t known_cells = old != not_in_list ? known[old].known : 0;
      if constexpr (CodingT::is_mixing)
        neighbours.moveTo(i);
      for (std::uint64_t cells = frame.masks[i]; cells != 0; cells &= cells - 1) {
        const std::uint64_t cell = cells & (~cells + 1);
        const std::size_t record =
            (known_cells & cell) != 0
                ? known[old].first_record + bitCount(known_cells & (cell - 1))
                : no_record;
        std::uint32_t neighbour_class = 0;
        if constexpr (CodingT::is_mixing)
          neighbour_class = neighbours.classOf(lowestBit(cells), symbols);
        const std::uint32_t symbol =
            codeSymbol(record, neighbour_class, symbols[voxel]);
        if (symbol > max_symbol_)
          return false;
        symbols[voxel++] = static_cast<std::uint16_t>(symbol);
        const auto value = static_cast<std::int32_t>(symbol << 4);
        running_ = running_ < 0 ? value : running_ + ((value - running_) >> 2);
      }
    }
    return true;
  }

  /** \brief Codes the bits of a symbol, highest first: eight with a model, the others
   * bypass it. */
  std::uint32_t
  codePlain(std::uint32_t symbol)
  {
    const unsigned int bypass_bits = symbol_bits_ > 8 ? symbol_bits_ - 8 : 0;
    std::uint32_t node = 1; // a 1, then the bits coded so far
    for (unsigned int bit = symbol_bits_; bit-- > bypass_bits;)
      node = node << 1 | static_cast<std::uint32_t>(coding_.code(
                             models_.plain, {{node}}, (symbol >> bit & 1) != 0));
    for (unsigned int bit = bypass_bits; bit-- > 0;)
      node = node << 1 |
             static_cast<std::uint32_t>(coding_.codeBypass((symbol >> bit & 1) != 0));
    return node & max_symbol_;
  }

  /** \brief Class of the running mean of the previous symbols, 0..7; 0 for the first. */
  std::uint32_t
  runningClass() const
  {
    return running_ < 0     ? 0
           : running_ <= 16 ? 1
           : running_ < 32  ? 2
           : running_ < 48  ? 3
           : running_ < 80  ? 4
           : running_ < 128 ? 5
           : running_ < 256 ? 6
                            : 7;
  }

  std::uint32_t
  codeSymbol(std::size_t record, std::uint32_t neighbour_class, std::uint32_t symbol)
  {
    const VoxelRecord* const records = history_.records();
    const unsigned int shift = 4 - history_.fractionBits();
    const bool has_mean = record != no_record;
    // In sixteenths of a symbol.
    const std::uint32_t expected =
        has_mean       ? static_cast<std::uint32_t>(records[record].mean) << shift
        : running_ < 0 ? 16u
                       : static_cast<std::uint32_t>(running_);
    if (expected < 160) {
      const std::uint32_t row = has_mean ? expected / 8 : 20 + expected / 16;
      typename decltype(models_.more)::Contexts contexts;
      contexts.ways[0] = row * 8 + runningClass();
      if constexpr (CodingT::is_mixing) {
        const std::uint32_t deviation =
            has_mean ? static_cast<std::uint32_t>(records[record].deviation) << shift
                     : 0;
        contexts.ways[1] =
            has_mean ? std::min(expected / 4, 39u) * 15 + std::min(deviation / 6, 14u)
                     : 600 + static_cast<std::uint32_t>(std::min(running_ / 8, 39));
        contexts.ways[2] =
            has_mean ? ((records[record].probability >> 12) * 16 + expected / 10) * 2 +
                           (records[record].recent & 1)
                     : runningClass();
        contexts.ways[3] =
            neighbour_class * 20 + (has_mean ? expected / 10 : 16 + runningClass() / 2);
      }
      return codeCount(contexts, symbol);
    }
    const std::uint32_t deviation =
        has_mean ? static_cast<std::uint32_t>(records[record].deviation) << shift
                 : expected / 4;
    return codeDistance(expected >> 4, deviation, has_mean, symbol);
  }

  /** \brief Codes a symbol that is expected to be small, in unary. */
  std::uint32_t
  codeCount(DecisionModel<4>::Contexts contexts, std::uint32_t symbol)
  {
    const std::uint32_t longest = IntensityModels::longest_count;
    for (std::uint32_t& context : contexts.ways)
      context = context * longest + lowest_;
    for (std::uint32_t count = lowest_; count < longest; ++count) {
      contexts.weight_set = std::min(count, 9u);
      if (!coding_.code(models_.more, contexts, symbol > count))
        return count;
      for (std::uint32_t& context : contexts.ways)
        ++context;
    }
    const std::uint32_t beyond = codeEscape(0, symbol - IntensityModels::longest_count);
    return beyond == invalid ? invalid : IntensityModels::longest_count + beyond;
  }

  /** \brief Codes a symbol that is expected to be large, as its distance from the expected
   * value. */
  std::uint32_t
  codeDistance(std::uint32_t expected,
               std::uint32_t deviation,
               bool has_mean,
               std::uint32_t symbol)
  {
    // Bits well below the deviation are noise.
    unsigned int bypass_bits = 0;
    while (bypass_bits < 12 && deviation >> (4 + bypass_bits) > 6)
      ++bypass_bits;
    const std::uint32_t context = std::min(deviation >> bypass_bits >> 3, 13u) * 4 +
                                  (bypass_bits > 0 ? 2 : 0) + (has_mean ? 1 : 0);
    const std::uint32_t middle = expected >> bypass_bits;
    std::uint32_t high = symbol >> bypass_bits;
    if (coding_.code(models_.differs, {{context}}, high != middle)) {
      const bool is_above = coding_.code(models_.above, {{context}}, high > middle);
      const std::uint32_t row =
          (context * 2 + (is_above ? 1 : 0)) * IntensityModels::longest_distance;
      const std::uint32_t target = is_above ? high - middle - 1 : middle - high - 1;
      std::uint32_t distance = 0;
      while (distance < IntensityModels::longest_distance &&
             coding_.code(models_.farther, {{row + distance}}, target > distance))
        ++distance;
      if (distance == IntensityModels::longest_distance) {
        const std::uint32_t beyond = codeEscape(1, target - distance);
        distance = beyond == invalid ? invalid : distance + beyond;
      }
      if (distance > max_symbol_ || (!is_above && distance >= middle))
        return invalid;
      high = is_above ? middle + 1 + distance : middle - 1 - distance;
    }
    else
      high = middle;
    for (unsigned int bit = bypass_bits; bit-- > 0;)
      high = high << 1 |
             static_cast<std::uint32_t>(coding_.codeBypass((symbol >> bit & 1) != 0));
    return high;
  }

  /** \brief Codes an escaped number as an Elias gamma code whose length has a model.
   * \param[in] kind of the number: 0 count, 1 distance, 2 residual
   * \param[in] number 0 or more
   */
  std::uint32_t
  codeEscape(std::uint32_t kind, std::uint32_t number)
  {
    const std::uint32_t target = CodingT::is_decoder ? 0 : number + 1;
    std::uint32_t bits = 0;
    while (coding_.code(models_.escape,
                        {{kind * longest_escape + bits}},
                        !CodingT::is_decoder && target >> bits > 1))
      if (++bits == longest_escape)
        return invalid;
    std::uint32_t value = 1;
    for (; bits > 0; --bits)
      value = value << 1 | static_cast<std::uint32_t>(
                               coding_.codeBypass((target >> (bits - 1) & 1) != 0));
    return value - 1;
  }

  CodingT& coding_;
  IntensityModels& models_;
  BlockDirectory& directory_;
  const History& history_;
  unsigned int levels_;
  unsigned int symbol_bits_;
  std::uint32_t max_symbol_;
  std::uint32_t lowest_ = 0;
  std::int32_t running_ = -1; // mean of the previous symbols, in sixteenths
};

} // namespace context
} // namespace io
} // namespace pcl_ext
