// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "codec/changes/last_frame.h"
#include "codec/changes/models.h"
#include "codec/supplement/numbers.h"
#include "codec/supplement/residuals.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief Codes what the cells that change become (doc/bitstream_changes.md,
 * "Symbols"), and lists where the symbols of the others will be.
 * \tparam Coder rans::NibbleEncoder or rans::NibbleDecoder
 */
template <class Coder>
class ChangedSymbols {
public:
  static constexpr bool is_decoder = Coder::is_decoder;

  /** \brief What symbols become. */
  struct Targets {
    const std::uint16_t* symbols;
    bool are_of_changes; ///< of what is coded alone, else of all voxels of the frame
  };

  /** \param[in] targets encoder only
   * \param[in] highest symbol, 0: none
   * \param[in] last symbols of the last frame
   * \param[in] voxel_count of the frame
   * \param[in] changed_cells of which symbols may be coded, at most
   * \param[in,out] changes its symbols and their runs are listed
   */
  ChangedSymbols(const Coder& coder,
                 Models& models,
                 const Targets& targets,
                 std::int32_t highest,
                 const std::vector<std::uint16_t>& last,
                 std::size_t voxel_count,
                 std::size_t changed_cells,
                 FrameChanges& changes)
  : coding_(coder, models.lengths)
  , models_(models)
  , appeared_(models.appeared, highest)
  , targets_(targets)
  , highest_(highest)
  , last_(last.data())
  , voxel_count_(voxel_count)
  {
    const std::size_t coded_symbols = highest > 0 ? changed_cells : 0;
    ensureSize(changes.symbols, coded_symbols);
    ensureSize(changes.symbol_runs, coded_symbols + 1);
    new_symbol_ = changes.symbols.data();
    run_ = changes.symbol_runs.data();
  }

  /** \brief Leaves the symbols of the last frame as they are up to those of a voxel.
   * \return false if the frame has fewer voxels
   */
  bool
  keepUntil(std::size_t last_voxel)
  {
    const std::size_t count = last_voxel - kept_;
    if (count > voxel_count_ - voxel_)
      return false;
    if (highest_ > 0 && count > 0)
      symbol_before_ = last_[last_voxel - 1];
    kept_ = last_voxel;
    voxel_ += count;
    return true;
  }

  /** \brief Codes a cell that was not occupied. \return false if it is invalid */
  bool
  codeAppeared()
  {
    if (voxel_ == voxel_count_)
      return false;
    if (highest_ > 0) {
      coding_.reserve(supplement::ResidualCoding::most_symbols);
      std::int32_t symbol = is_decoder ? 0 : nextTarget();
      if (!appeared_.code(coding_, symbol_before_, symbol))
        return false;
      addSymbol(symbol);
      endRun(kept_);
    }
    ++voxel_;
    run_next_ = voxel_;
    return true;
  }

  /** \brief Codes whether the next voxel of the last frame vanishes, or its symbol.
   * \param[in,out] is_gone set by a decoder
   * \return false if it is invalid
   */
  bool
  codeChanged(bool is_restless, bool& is_gone)
  {
    const std::size_t before = kept_++;
    if (highest_ == 0) {
      is_gone = true;
      return true;
    }
    const std::int32_t symbol = last_[before];
    std::uint32_t number = 0; // vanishes
    if (!is_decoder && !is_gone) {
      const std::int32_t change = nextTarget() - symbol;
      if (change == 0)
        return false;
      number = static_cast<std::uint32_t>(change > 0 ? 2 * change - 1 : -2 * change);
    }
    coding_.reserve(8);
    const std::uint64_t coded =
        coding_.code(models_.change[is_restless ? 1 : 0], number);
    is_gone = coded == 0;
    if (is_gone) {
      endRun(before);
      run_begin_ = kept_;
      run_next_ = voxel_;
      return !coding_.isOverrun();
    }
    if (coded > 2 * static_cast<std::uint64_t>(highest_) || voxel_ == voxel_count_ ||
        coding_.isOverrun())
      return false;
    const auto distance = static_cast<std::int32_t>((coded + 1) / 2);
    const std::int32_t next = coded % 2 != 0 ? symbol + distance : symbol - distance;
    addSymbol(next);
    ++voxel_;
    return next >= 0 && next <= highest_;
  }

  /** \brief Ends the lists.
   * \param[in] last_count voxels of the last frame
   * \return false if the voxels are not as many as the frame has
   */
  bool
  finish(std::size_t last_count, Coder& coder, FrameChanges& changes)
  {
    if (!keepUntil(last_count) || voxel_ != voxel_count_)
      return false;
    if (highest_ > 0)
      endRun(last_count);
    changes.symbols.resize(
        static_cast<std::size_t>(new_symbol_ - changes.symbols.data()));
    changes.symbol_runs.resize(
        static_cast<std::size_t>(run_ - changes.symbol_runs.data()));
    changes.voxel_count = voxel_count_;
    changes.symbol_count = highest_ > 0 ? voxel_count_ : 0;
    coder = coding_.coder();
    return true;
  }

private:
  std::int32_t
  nextTarget()
  {
    return targets_.symbols[targets_.are_of_changes ? coded_++ : voxel_];
  }

  void
  addSymbol(std::int32_t symbol)
  {
    *new_symbol_++ = {static_cast<std::uint32_t>(voxel_),
                      static_cast<std::uint16_t>(symbol)};
    symbol_before_ = symbol;
  }

  /** \brief Ends a run of voxels that stay together. */
  void
  endRun(std::size_t end)
  {
    *run_ = {static_cast<std::uint32_t>(run_begin_),
             static_cast<std::uint32_t>(end),
             static_cast<std::uint32_t>(run_next_)};
    run_ += run_begin_ < end ? 1 : 0;
    run_begin_ = end;
  }

  supplement::NumberCoding<Coder> coding_;
  Models& models_;
  supplement::ResidualCoding appeared_;
  Targets targets_;
  std::int32_t highest_;
  const std::uint16_t* last_;
  NewSymbol* new_symbol_;
  Run* run_;
  std::size_t voxel_count_;
  std::size_t kept_ = 0;  // voxels of the last frame so far, with those that changed
  std::size_t voxel_ = 0; // of the frame
  std::size_t coded_ = 0; // targets of changes
  std::size_t run_begin_ = 0;
  std::size_t run_next_ = 0;
  std::int32_t symbol_before_ = 0; // of the voxel before in the frame
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io
