// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/changes/models.h"
#include "codec/supplement/numbers.h"
#include "codec/supplement/residuals.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief Codes what the cells that change become, and copies the symbols of the
 * others (doc/bitstream_changes.md, "Symbols").
 * \tparam Coder rans::NibbleEncoder or rans::NibbleDecoder
 */
template <class Coder>
class ChangedSymbols {
public:
  static constexpr bool is_decoder = Coder::is_decoder;

  /** \param[in] targets symbols of the frame; encoder only
   * \param[in] highest symbol, 0: none
   * \param[in] last symbols of the last frame
   * \param[out] next symbols of the frame
   * \param[in] voxel_count of the frame
   */
  ChangedSymbols(const Coder& coder,
                 Models& models,
                 const std::uint16_t* targets,
                 std::int32_t highest,
                 const std::vector<std::uint16_t>& last,
                 std::vector<std::uint16_t>& next,
                 std::size_t voxel_count)
  : coding_(coder, models.lengths)
  , models_(models)
  , appeared_(models.appeared, highest)
  , targets_(targets)
  , highest_(highest)
  , last_(last.data())
  , next_(next.data())
  , voxel_count_(voxel_count)
  {}

  const Coder&
  coder() const
  {
    return coding_.coder();
  }

  /** \brief Copies the symbols of the last frame up to those of a voxel.
   * \return false if the frame has fewer voxels
   */
  bool
  copyUntil(std::size_t last_voxel)
  {
    const std::size_t count = last_voxel - copied_;
    if (count > voxel_count_ - voxel_)
      return false;
    if (highest_ > 0)
      std::copy_n(last_ + copied_, count, next_ + voxel_);
    copied_ = last_voxel;
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
      std::int32_t symbol = is_decoder ? 0 : targets_[voxel_];
      const std::int32_t predicted = voxel_ > 0 ? next_[voxel_ - 1] : 0;
      if (!appeared_.code(coding_, predicted, symbol))
        return false;
      next_[voxel_] = static_cast<std::uint16_t>(symbol);
    }
    ++voxel_;
    return true;
  }

  /** \brief Codes whether the next voxel of the last frame vanishes, or its symbol.
   * \param[in,out] is_gone set by a decoder
   * \return false if it is invalid
   */
  bool
  codeChanged(bool is_restless, bool& is_gone)
  {
    const std::size_t before = copied_++;
    if (highest_ == 0) {
      is_gone = true;
      return true;
    }
    const std::int32_t symbol = last_[before];
    std::uint32_t number = 0; // vanishes
    if (!is_decoder && !is_gone) {
      const std::int32_t change = targets_[voxel_] - symbol;
      number = static_cast<std::uint32_t>(change > 0 ? 2 * change - 1 : -2 * change);
    }
    coding_.reserve(8);
    const std::uint64_t coded =
        coding_.code(models_.change[is_restless ? 1 : 0], number);
    is_gone = coded == 0;
    if (is_gone)
      return !coding_.isOverrun();
    if (coded > 2 * static_cast<std::uint64_t>(highest_) || voxel_ == voxel_count_ ||
        coding_.isOverrun())
      return false;
    const auto distance = static_cast<std::int32_t>((coded + 1) / 2);
    const std::int32_t next = coded % 2 != 0 ? symbol + distance : symbol - distance;
    next_[voxel_++] = static_cast<std::uint16_t>(next);
    return next >= 0 && next <= highest_;
  }

  /** \brief Which of the frame's voxels the next one of the last frame is, before whose
   * block nothing else changes.
   * \param[in] last_voxel up to which nothing was coded
   */
  std::size_t
  voxelOf(std::size_t last_voxel) const
  {
    return voxel_ + last_voxel - copied_;
  }

  /** \brief Number of the frame's voxels so far. */
  std::size_t
  voxelCount() const
  {
    return voxel_;
  }

private:
  supplement::NumberCoding<Coder> coding_;
  Models& models_;
  supplement::ResidualCoding appeared_;
  const std::uint16_t* targets_;
  std::int32_t highest_;
  const std::uint16_t* last_;
  std::uint16_t* next_;
  std::size_t voxel_count_;
  std::size_t copied_ = 0; // voxels of the last frame that were copied, or changed
  std::size_t voxel_ = 0;  // of the frame
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io
