// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/elevation_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Elevations are counted in bins of this size, radians; 0.02 degrees. */
constexpr double bin = 0.02 * 3.14159265358979323846 / 180.0;
constexpr std::size_t bin_count = 9000; // from straight down to straight up

/** \brief Nearer points are not at their elevations, as lasers are beside each other and
 * coordinates are rounded; metres. Without points that are near some rows have none. */
constexpr double nearest_points[] = {0.5, 1.0, 2.0, 4.0};

constexpr std::size_t most_rows = 256;

/** \brief A row has more than one of so many points of an average row. */
constexpr std::size_t least_share = 20;

/** \brief Neighbouring bins with points, and how many these are. */
struct Group {
  std::size_t begin;
  std::size_t end;
  std::size_t points;
};

std::vector<Group>
groupsOf(const std::vector<std::uint32_t>& bins)
{
  std::vector<Group> groups;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (bins[i] == 0)
      continue;
    if (groups.empty() || groups.back().end < i)
      groups.push_back({i, i, 0});
    groups.back().end = i + 1;
    groups.back().points += bins[i];
  }
  return groups;
}

/** \brief Whether most groups are narrow for their distance, as those of lasers are. */
bool
areNarrow(const std::vector<Group>& groups)
{
  std::size_t narrow = 0;
  for (std::size_t i = 1; i < groups.size(); ++i)
    narrow += 2 * (groups[i].end - groups[i].begin) < groups[i].end - groups[i - 1].end;
  return 8 * narrow >= 7 * (groups.size() - 1);
}

/** \brief The groups of the elevations of points that are not nearer than some distance;
 * none if there are no clear ones. */
std::vector<Group>
findGroups(const std::vector<Eigen::Vector3d>& points,
           double nearest,
           std::size_t least_points)
{
  std::vector<std::uint32_t> bins(bin_count);
  std::size_t counted = 0;
  for (const Eigen::Vector3d& point : points) {
    const double distance = std::hypot(point.x(), point.y());
    if (distance < nearest)
      continue;
    const double place = std::atan2(point.z(), distance) / bin + bin_count / 2.0;
    ++bins[std::min(static_cast<std::size_t>(std::max(place, 0.0)), bin_count - 1)];
    ++counted;
  }
  if (counted < least_points)
    return {};
  std::vector<Group> groups = groupsOf(bins);
  const std::size_t fewest =
      counted / (least_share * std::max<std::size_t>(1, groups.size()));
  std::size_t left_out = 0;
  const auto is_stray = [&](const Group& group) {
    left_out += group.points <= fewest ? group.points : 0;
    return group.points <= fewest;
  };
  groups.erase(std::remove_if(groups.begin(), groups.end(), is_stray), groups.end());
  constexpr std::size_t most_stray = 64; // one of so many points
  if (groups.size() < 2 || groups.size() > most_rows || !areNarrow(groups) ||
      most_stray * left_out > counted)
    return {};
  return groups;
}

} // namespace

bool
ElevationRows::learn(const std::vector<Eigen::Vector3d>& points,
                     std::size_t least_points)
{
  ends_.clear();
  std::vector<Group> groups;
  for (const double nearest : nearest_points)
    if (groups.empty())
      groups = findGroups(points, nearest, least_points);
  if (groups.empty())
    return false;
  const auto slope_at = [](double place) {
    return std::tan((place - bin_count / 2.0) * bin);
  };
  for (std::size_t i = 1; i < groups.size(); ++i)
    ends_.push_back(
        slope_at(static_cast<double>(groups[i - 1].end + groups[i].begin) / 2.0));
  ends_.push_back(std::numeric_limits<double>::infinity());
  next_rows_.assign(ends_.size(), 0);
  last_row_ = 0;
  return true;
}

std::uint32_t
ElevationRows::nextRow(double slope)
{
  // Lasers mostly fire in the same order.
  const std::uint32_t guess = next_rows_[last_row_];
  if (slope < ends_[guess] && (guess == 0 || slope >= ends_[guess - 1]))
    return last_row_ = guess;
  const auto row = static_cast<std::uint32_t>(
      std::upper_bound(ends_.begin(), ends_.end() - 1, slope) - ends_.begin());
  next_rows_[last_row_] = row;
  return last_row_ = row;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
