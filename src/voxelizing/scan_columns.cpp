// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/scan_columns.h"

#include "voxelizing/firing_columns.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief The scan of a cloud that has the order of firings has fewer pixels for each of
 * its points. */
constexpr std::size_t most_pixels_of_point = 6;

/** \brief Sensors have fewer rows. */
constexpr std::uint32_t most_rings = 1024;

/** \brief With fewer points there is nothing to learn the order of rings from. */
constexpr std::size_t least_ordered_points = 64;

} // namespace

bool
ScanColumns::areRows(const std::vector<std::uint32_t>& rings)
{
  const auto [lowest, highest] = std::minmax_element(rings.begin(), rings.end());
  return lowest != rings.end() && *lowest != *highest && *highest < most_rings;
}

bool
ScanColumns::find(SensorCloud& cloud,
                  const WorldPose& to_sensor,
                  bool may_refit,
                  std::uint64_t most_pixels,
                  scan::ScanLayout& layout)
{
  const std::uint32_t rings =
      *std::max_element(cloud.rings.begin(), cloud.rings.end()) + 1;
  const bool is_first = ring_count_ == 0 || rings > ring_count_;
  if (may_refit || is_first) {
    ring_count_ = rings;
    if (cloud.size() >= least_ordered_points || is_first)
      firing_ranks_ = firingRanks(cloud.rings, rings);
  }
  are_firings_ = findFirings(cloud, most_pixels);
  if ((!are_firings_ && !findByAzimuth(cloud, to_sensor, may_refit, most_pixels)) ||
      !setLayout(most_pixels, layout))
    return false;
  cloud.columns = layout.width;
  cloud.pixels.resize(cloud.size());
  for (std::size_t point = 0; point < cloud.size(); ++point)
    cloud.pixels[point] = cloud.rings[point] * layout.width + columns_[point];
  return true;
}

bool
ScanColumns::setLayout(std::uint64_t most_pixels, scan::ScanLayout& layout) const
{
  layout.firing_order.clear();
  if (are_firings_) {
    layout.width = columns_.back() + 1;
    layout.height = ring_count_;
    layout.order = scan::PointOrder::ColumnByColumn;
    layout.firing_order.resize(ring_count_);
    for (std::uint32_t ring = 0; ring < ring_count_; ++ring)
      layout.firing_order[firing_ranks_[ring]] = static_cast<std::uint16_t>(ring);
    return true;
  }
  layout.width = by_azimuth_.count() * turns_;
  if (layout.width > scan::most_side ||
      std::uint64_t{layout.width} * by_azimuth_.rows() > most_pixels)
    return false;
  layout.height = by_azimuth_.rows();
  layout.order = scan::PointOrder::RowByRow;
  return true;
}

/** \brief Finds the columns of firings.
 * \return false if there are too many: the cloud has another order
 */
bool
ScanColumns::findFirings(const SensorCloud& cloud, std::uint64_t most_pixels)
{
  columns_ = firingColumns(cloud.rings, firing_ranks_);
  const std::uint64_t pixels = (std::uint64_t{columns_.back()} + 1) * ring_count_;
  return columns_.back() < scan::most_side && pixels <= most_pixels &&
         pixels <= most_pixels_of_point * cloud.size();
}

/** \brief Finds columns a step apart, in which points are at their azimuths. */
bool
ScanColumns::findByAzimuth(const SensorCloud& cloud,
                           const WorldPose& to_sensor,
                           bool may_refit,
                           std::uint64_t most_pixels)
{
  points_.clear();
  points_.reserve(cloud.size());
  for (std::size_t point = 0; point < cloud.size(); ++point)
    points_.push_back(
        {cloud.rings[point], 0, to_sensor * vectorOf(cloud.positions[point])});
  by_azimuth_.setPoints(points_);
  const bool has_many_more = points_.size() > 2 * fitted_points_;
  const bool may_keep =
      ring_count_ <= by_azimuth_.rows() && !(may_refit && has_many_more);
  const bool are_assigned = may_keep && by_azimuth_.assign(points_, shift_);
  const bool is_kept = are_assigned && by_azimuth_.areAlike();
  if (!may_refit && !is_kept) {
    RingColumns others = by_azimuth_;
    if (!are_assigned || (others.fit(points_, ring_count_, most_pixels) &&
                          others.fitBetterThan(by_azimuth_)))
      return false;
  }
  else if (!is_kept) {
    fitted_points_ = points_.size();
    if (!by_azimuth_.fit(points_, ring_count_, most_pixels) ||
        !by_azimuth_.assign(points_, shift_))
      return false;
  }
  columns_.resize(points_.size());
  for (std::size_t point = 0; point < points_.size(); ++point)
    columns_[point] = points_[point].column;
  // A wider scan is not narrowed again for each frame.
  turns_ = may_refit ? by_azimuth_.turns() : std::max(by_azimuth_.turns(), turns_);
  return true;
}

void
ScanColumns::releaseMemory()
{
  columns_ = std::vector<std::uint32_t>();
  points_ = std::vector<PixelPoint>();
  by_azimuth_.releaseMemory();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
