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

/** \brief Codes the intensity symbols of a frame relative to the statistics of its voxels
 * (doc/bitstream_fast.md, "Symbols"), row by row: voxels with a low mean, in quads; other
 * voxels with statistics; voxels without statistics; then escaped bins and low bits.
 *
 * A Coder is NibbleEncoder or NibbleDecoder; a Symbol is constant for an encoder.
 */
class ExpectedIntensities {
public:
  /** \brief Begins a frame: sorts its voxels, and allocates all memory.
   * \param[in] frame its blocks and voxels
   * \param[in] statistics of the history, 64 a block
   */
  void
  begin(const Frame& frame, const StatisticsTable& statistics);

  /** \brief Codes the symbols, and updates the statistics.
   * \param[in] origin lower bound of the symbols, 0 or 1
   * \param[in] bits of a symbol, 1..16
   * \param[in,out] statistics of the history
   * \return false if the bytes are invalid; never in an encoder
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

  /** \brief Restores the statistics to their state at begin(). */
  void
  restore(const Frame& frame, StatisticsTable& statistics) const;

  /** \brief Whether an encoder may have coded the decoded symbols with this origin. */
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
  const VoxelPlace* places_ = nullptr; // of the frame
  // Of the row that is coded.
  std::vector<std::uint8_t> contexts_;
  std::vector<std::uint8_t> coded_;
  std::vector<std::uint16_t> known_statistics_;
  unsigned int origin_ = 0;      // lowest symbol
  unsigned int top_ = 0;         // highest symbol minus the origin
  unsigned int top_bin_ = 0;     // bin of top_ alone; above all bins if there is none
  unsigned int highest_bin_ = 0; // highest valid bin
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
