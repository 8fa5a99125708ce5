// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the columns of a spinning sensor whose points come as it fires its
 * lasers, one of each row after the other. Points in the order of columns, and of ranks
 * within each, are then in the order of the cloud. */
class FiringColumns {
public:
  /** \brief Learns in which order the rows are fired.
   * \param[in] rows of the points, below row_count
   */
  void
  learn(const std::vector<std::uint32_t>& rows, std::uint32_t row_count);

  /** \brief Finds the column of each point.
   * \param[in] rows of the points, below that of learn()
   * \return columns of the points, ascending by at most 1
   */
  std::vector<std::uint32_t>
  columnsOf(const std::vector<std::uint32_t>& rows) const;

  /** \brief Place of each row within a column. */
  const std::vector<std::uint32_t>&
  ranks() const
  {
    return ranks_;
  }

private:
  std::vector<std::uint32_t> ranks_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
