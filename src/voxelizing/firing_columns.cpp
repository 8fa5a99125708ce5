// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/firing_columns.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace pcl_ext {
namespace io {

namespace {

using Ranks = std::vector<std::uint32_t>;

std::size_t
countColumns(const std::vector<std::uint32_t>& rows, const Ranks& ranks)
{
  std::size_t columns = 1;
  for (std::size_t i = 1; i < rows.size(); ++i)
    columns += ranks[rows[i]] <= ranks[rows[i - 1]] ? 1 : 0;
  return columns;
}

/** \brief The order in which each row is followed by the one that mostly follows it. */
Ranks
chainFrom(std::uint32_t first, const std::vector<std::vector<std::uint32_t>>& followers)
{
  Ranks ranks(followers.size(), ~std::uint32_t{0});
  std::uint32_t rank = 0;
  std::uint32_t row = first;
  while (true) {
    ranks[row] = rank++;
    std::uint32_t most = 0;
    std::uint32_t next = row;
    for (std::uint32_t other = 0; other < ranks.size(); ++other)
      if (ranks[other] == ~std::uint32_t{0} && followers[row][other] > most) {
        most = followers[row][other];
        next = other;
      }
    if (most == 0)
      break;
    row = next;
  }
  for (std::uint32_t& other : ranks)
    if (other == ~std::uint32_t{0})
      other = rank++;
  return ranks;
}

} // namespace

void
FiringColumns::learn(const std::vector<std::uint32_t>& rows, std::uint32_t row_count)
{
  std::vector<std::vector<std::uint32_t>> followers(
      row_count, std::vector<std::uint32_t>(row_count));
  for (std::size_t i = 1; i < rows.size(); ++i)
    ++followers[rows[i - 1]][rows[i]];
  ranks_.resize(row_count);
  std::iota(ranks_.begin(), ranks_.end(), 0u);
  std::size_t fewest = countColumns(rows, ranks_);
  const auto use = [&](const Ranks& ranks) {
    const std::size_t columns = countColumns(rows, ranks);
    if (columns < fewest) {
      fewest = columns;
      ranks_ = ranks;
    }
  };
  use(Ranks(ranks_.rbegin(), ranks_.rend()));
  for (std::uint32_t first = 0; first < row_count; ++first)
    use(chainFrom(first, followers));
}

std::vector<std::uint32_t>
FiringColumns::columnsOf(const std::vector<std::uint32_t>& rows) const
{
  std::vector<std::uint32_t> columns(rows.size());
  for (std::size_t i = 1; i < rows.size(); ++i)
    columns[i] = columns[i - 1] + (ranks_[rows[i]] <= ranks_[rows[i - 1]] ? 1 : 0);
  return columns;
}

} // namespace io
} // namespace pcl_ext
