// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Numbers of the rings of one stream that are rows of its scans: where many rings
 * are without points, as each fourth one was kept, only those that have some are. Else
 * points would have no neighbours in the rows beside theirs. */
class RingRows {
public:
  /** \brief Replaces rings by rows.
   * \param[in] may_learn the rows may be others than those of the clouds before
   * \param[in,out] rings of all points, not empty, below some thousand
   * \return false if one has no row, and they may not be learnt
   */
  bool
  number(bool may_learn, std::vector<std::uint32_t>& rings)
  {
    if (may_learn)
      learn(rings);
    if (rows_.empty())
      return true;
    for (std::uint32_t& ring : rings) {
      ring = ring < rows_.size() ? rows_[ring] : no_row;
      if (ring == no_row)
        return false;
    }
    return true;
  }

private:
  static constexpr std::uint32_t no_row = ~std::uint32_t{0};

  void
  learn(const std::vector<std::uint32_t>& rings)
  {
    rows_.assign(*std::max_element(rings.begin(), rings.end()) + std::size_t{1},
                 no_row);
    for (const std::uint32_t ring : rings)
      rows_[ring] = 0;
    std::uint32_t count = 0;
    for (std::uint32_t& row : rows_)
      if (row != no_row)
        row = count++;
    if (4 * std::size_t{count} > 3 * rows_.size())
      rows_.clear();
  }

  std::vector<std::uint32_t> rows_; // of rings; empty: they are the same
};

} // namespace pcl_ext::PCL_EXT_ABI::io
