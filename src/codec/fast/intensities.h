// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/frame_blocks.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Codes the symbols of a frame, of intensities or of numbers of points,
 * relative to statistics (doc/bitstream_fast.md, "Symbols").
 *
 * A Coder is NibbleEncoder or NibbleDecoder; a Symbol is constant for an encoder.
 */
class Intensities {
public:
  /** \brief Codes the symbols, and updates models and statistics.
   * \param[in] frame its blocks and voxels
   * \param[in,out] statistics of the history, 64 a block
   * \param[in] bits of a symbol, 1..16
   * \param[in,out] symbols one for each voxel; set by a decoder
   * \return false if the bytes are invalid, never in an encoder; the caller then has to
   * call restore()
   */
  template <class Coder, class Symbol>
  bool
  code(Coder& coder,
       SymbolModels& models,
       const FrameBlocks& frame,
       StatisticsTable& statistics,
       unsigned int bits,
       Symbol* symbols);

  /** \brief Restores the statistics to their state before the last frame. */
  void
  restore(const FrameBlocks& frame, StatisticsTable& statistics) const;

private:
  void
  begin(const FrameBlocks& frame, const StatisticsTable& statistics, unsigned int bits);

  template <class Coder, class Symbol>
  bool
  codeRunning(Coder& coder,
              SymbolModels& models,
              std::uint16_t* statistics,
              Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeRow(Coder& coder,
          SymbolModels& models,
          std::uint16_t* statistics,
          Symbol* symbols);

  const std::uint16_t*
  binsOf(const std::uint16_t* symbols);

  void
  learnRow(std::uint16_t* statistics, std::uint16_t* bins);

  template <class Coder, class Symbol>
  bool
  codeNotedBins(Coder& coder,
                SymbolModels& models,
                std::uint16_t* statistics,
                Symbol* symbols);

  template <class Coder>
  bool
  codeWholeBin(Coder& coder,
               SymbolModels& models,
               unsigned int lowest,
               unsigned int value,
               unsigned int& bin);

  template <class Coder>
  bool
  codeValue(Coder& coder, unsigned int bin, unsigned int& value);

  unsigned int
  binOf(unsigned int value) const;

  std::size_t count_ = 0;                   // of the frame's voxels
  const CellIndex* cell_indices_ = nullptr; // of the voxels
  // By voxel.
  std::vector<std::uint16_t> before_; // statistics before this frame
  std::vector<std::uint16_t> after_;
  std::vector<std::uint16_t> contexts_;
  std::vector<std::uint16_t> lowest_; // bins
  std::vector<std::uint16_t> bins_;   // encoder only
  std::vector<std::uint8_t> coded_;
  std::vector<std::uint32_t>
      noted_; // voxels whose bins or low bits are still to be coded
  std::size_t noted_count_ = 0;

  unsigned int top_ = 0;         // highest symbol
  unsigned int top_bin_ = 0;     // bin of top_ alone; above all bins if there is none
  unsigned int highest_bin_ = 0; // highest valid bin
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
