// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/firing_columns.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using Ranks = std::vector<std::uint32_t>;

/** \brief A row that comes right behind another one, and how often. */
struct Follower {
  std::uint32_t row;
  std::size_t count;
};

/** \brief Of each row those that come right behind it, the most frequent one first. */
using Followers = std::vector<std::vector<Follower>>;

Followers
followersOf(const std::vector<std::uint32_t>& rows, std::uint32_t row_count)
{
  std::vector<std::size_t> counts(std::size_t{row_count} * row_count);
  for (std::size_t i = 1; i < rows.size(); ++i)
    ++counts[std::size_t{rows[i - 1]} * row_count + rows[i]];
  Followers followers(row_count);
  for (std::uint32_t row = 0; row < row_count; ++row) {
    for (std::uint32_t other = 0; other < row_count; ++other)
      if (const auto count = counts[std::size_t{row} * row_count + other]; count > 0)
        followers[row].push_back({other, count});
    std::stable_sort(followers[row].begin(),
                     followers[row].end(),
                     [](const Follower& one, const Follower& next) {
                       return one.count > next.count;
                     });
  }
  return followers;
}

std::size_t
countColumns(const Followers& followers, const Ranks& ranks)
{
  std::size_t columns = 1;
  for (std::size_t row = 0; row < ranks.size(); ++row)
    for (const Follower& follower : followers[row])
      columns += ranks[follower.row] <= ranks[row] ? follower.count : 0;
  return columns;
}

/** \brief The order in which each row is followed by the one that mostly follows it. */
Ranks
chainFrom(std::uint32_t first, const Followers& followers)
{
  constexpr std::uint32_t none = ~std::uint32_t{0};
  Ranks ranks(followers.size(), none);
  std::uint32_t rank = 0;
  for (std::uint32_t row = first; row != none;) {
    ranks[row] = rank++;
    const auto next = std::find_if(
        followers[row].begin(), followers[row].end(), [&](const Follower& follower) {
          return ranks[follower.row] == none;
        });
    row = next == followers[row].end() ? none : next->row;
  }
  for (std::uint32_t& other : ranks)
    if (other == none)
      other = rank++;
  return ranks;
}

} // namespace

Ranks
firingRanks(const std::vector<std::uint32_t>& rows, std::uint32_t row_count)
{
  const Followers followers = followersOf(rows, row_count);
  Ranks best(row_count);
  std::iota(best.begin(), best.end(), 0u);
  std::size_t fewest = countColumns(followers, best);
  const auto use = [&](const Ranks& ranks) {
    const std::size_t columns = countColumns(followers, ranks);
    if (columns < fewest) {
      fewest = columns;
      best = ranks;
    }
  };
  use(Ranks(best.rbegin(), best.rend()));
  for (std::uint32_t first = 0; first < row_count; ++first)
    use(chainFrom(first, followers));
  return best;
}

std::vector<std::uint32_t>
firingColumns(const std::vector<std::uint32_t>& rows, const Ranks& ranks)
{
  std::vector<std::uint32_t> columns(rows.size());
  for (std::size_t i = 1; i < rows.size(); ++i)
    columns[i] = columns[i - 1] + (ranks[rows[i]] <= ranks[rows[i - 1]] ? 1 : 0);
  return columns;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
