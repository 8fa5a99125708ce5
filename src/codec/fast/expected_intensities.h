#pragma once

#include "codec/fast/frame.h"
#include "codec/fast/intensity_rows.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes the intensity symbols of a frame with what the statistics of its voxels
 * let expect (doc/bitstream_fast.md, "Symbols"), row by row: voxels with a low mean, four
 * at a time; other voxels with statistics; voxels without; then bins that were escaped,
 * then low bits.
 *
 * A Coder is NibbleEncoder or NibbleDecoder; a Symbol is constant for an encoder.
 */
class ExpectedIntensities {
public:
  /** \brief Begins with a frame: sorts its voxels. Takes all memory that coding needs.
   * \param[in] statistics those of the history, 64 a block
   */
  void
  begin(const Frame& frame, const StatisticsTable& statistics);

  /** \brief Codes the symbols, and their statistics learn them.
   * \param[in] origin lowest value of the symbols, 0 or 1
   * \param[in] bits of a symbol, 1..16
   * \param[in,out] statistics those of the history
   * \return false if the bytes are no such symbols; never in an encoder
   */
  template <class Coder, class Symbol>
  bool
  code(Coder& coder,
       Models& models,
       const Frame& frame,
       unsigned int origin,
       unsigned int bits,
       StatisticsTable& statistics,
       Symbol* symbols);

  /** \brief Gives the statistics back as they were at begin(). */
  void
  restore(const Frame& frame, StatisticsTable& statistics) const;

  /** \brief Whether decoded symbols are what an encoder of this origin can have had. */
  bool
  areValid(const std::vector<std::uint16_t>& symbols) const;

private:
  using Row = IntensityRows::Row;

  void
  setRange(unsigned int origin, unsigned int bits);

  template <class Coder, class Symbol>
  bool
  codeQuads(Coder& coder,
            Models& models,
            std::size_t low_class,
            std::uint16_t* statistics,
            Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeKnown(Coder& coder, Models& models, std::uint16_t* statistics, Symbol* symbols);

  template <bool is_decoder, class Symbol>
  void
  learnKnown(std::uint16_t* statistics, Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeFresh(Coder& coder,
            Models& models,
            bool is_i_frame,
            std::uint16_t* statistics,
            Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeHighQuadBins(Coder& coder,
                   Models& models,
                   std::size_t low_class,
                   std::uint16_t* statistics,
                   Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeNotedBins(Coder& coder,
                Models& models,
                std::uint16_t* statistics,
                Symbol* symbols);

  template <class Coder>
  bool
  codeWholeBin(Coder& coder,
               Models& models,
               unsigned int lowest,
               unsigned int value,
               unsigned int& bin);

  template <class Coder>
  bool
  codeValue(Coder& coder, unsigned int bin, unsigned int& value);

  unsigned int
  binOf(unsigned int value) const;

  IntensityRows rows_;
  const VoxelPlace* places_ = nullptr; ///< those of the frame
  // Of the row that is coded.
  std::vector<std::uint8_t> contexts_;
  std::vector<std::uint8_t> coded_;
  std::vector<std::uint16_t> known_statistics_;
  unsigned int origin_ = 0;      // lowest value that is coded
  unsigned int top_ = 0;         // highest one, less the origin
  unsigned int top_bin_ = 0;     // its bin if it has one of its own, else above all
  unsigned int highest_bin_ = 0; // highest that may occur
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
