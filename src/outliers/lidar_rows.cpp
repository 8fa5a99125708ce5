// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/lidar_rows.h"

#include "voxelizing/point_batches.h"
#include "voxelizing/ring_field.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::uint32_t least_rows = 4;
constexpr std::uint32_t most_rows = 1024;
/** \brief Fewer points in a row are no row that was told from their directions. */
constexpr std::size_t least_points_of_row = 32;

/** \brief Sine of the elevation: single points near the axis, whose slopes are huge,
 * count no more than others. */
double
sineOf(float slope)
{
  const auto exact = static_cast<double>(slope);
  return exact / std::sqrt(1.0 + exact * exact);
}

/** \brief Sums of some sines of elevations. */
struct SineSums {
  double count = 0.0;
  double sum = 0.0;
  double of_squares = 0.0;

  void
  add(double sine)
  {
    count += 1.0;
    sum += sine;
    of_squares += sine * sine;
  }

  /** \brief Sum of the squares of the differences from the mean. */
  double
  deviations() const
  {
    return count > 0.0 ? of_squares - sum * sum / count : 0.0;
  }
};

} // namespace

bool
LidarRows::find(const io::PointView& points, const std::vector<LidarPoint>& directions)
{
  const Source last = source_;
  if (!isFoundIn(last, points, directions)) {
    constexpr std::array<Source, 4> sources = {
        Source::Image, Source::Ring, Source::Elevations, Source::Turns};
    const auto found = std::find_if(sources.begin(), sources.end(), [&](Source source) {
      return source != last && isFoundIn(source, points, directions);
    });
    source_ = found == sources.end() ? Source::None : *found;
    ranks_.clear();
  }
  if (source_ == Source::None)
    return false;
  sortRows(directions);
  return count_ >= 2;
}

bool
LidarRows::isFoundIn(Source source,
                     const io::PointView& points,
                     const std::vector<LidarPoint>& directions)
{
  rows_.assign(points.count, no_row);
  count_ = 0;
  if (!readRows(source, points, directions))
    return false;
  for (std::size_t i = 0; i < directions.size(); ++i)
    if (directions[i].range == 0.0f)
      rows_[i] = no_row;
  if (source == source_ && checked_rows_ == count_ &&
      checked_points_ == directions.size())
    return true;
  if (!areCones(source, directions))
    return false;
  // What was found stays while clouds have as many rows and points.
  checked_rows_ = count_;
  checked_points_ = directions.size();
  return true;
}

bool
LidarRows::readRows(Source source,
                    const io::PointView& points,
                    const std::vector<LidarPoint>& directions)
{
  const std::optional<std::size_t> ring =
      io::findRing(io::SingleBatch(points).fields());
  switch (source) {
  case Source::Image:
    return points.image.width > 1 && points.image.height > 1 && readImage(points);
  case Source::Ring:
    return ring && readRings(points.fields[*ring], directions);
  case Source::Elevations:
    return findByElevation(directions);
  case Source::Turns:
    return findByTurns(directions);
  default:
    return false;
  }
}

/** \brief Whether rows turn around the axis, each at nearly the same elevation: those
 * of a camera do not, but for middle rows of one that looks along the axis, and wide
 * rows of one that looks ahead are only nearly so. Rings may be of a sensor that sees a
 * small part of a turn. */
bool
LidarRows::areCones(Source source, const std::vector<LidarPoint>& directions) const
{
  constexpr std::uint32_t bins = 36;
  constexpr std::size_t least_bins = bins / 3;
  constexpr std::size_t many_bins = 2 * least_bins;
  // Of that of all rows.
  constexpr double most_variance_of_row = 0.25;
  constexpr double most_variance_of_part = 0.01;
  std::vector<SineSums> sines(count_);
  std::vector<std::bitset<bins>> are_seen(count_);
  SineSums of_all;
  for (std::size_t i = 0; i < directions.size(); ++i)
    if (const std::uint32_t row = rows_[i]; row != no_row) {
      are_seen[row].set(static_cast<std::uint32_t>(directions[i].azimuth * bins) %
                        bins);
      const double sine = sineOf(directions[i].slope);
      sines[row].add(sine);
      of_all.add(sine);
    }
  double in_rows = 0.0;
  double of_wide_rows = 0.0;
  double of_very_wide_rows = 0.0;
  for (std::uint32_t row = 0; row < count_; ++row) {
    in_rows += sines[row].deviations();
    of_wide_rows += are_seen[row].count() >= least_bins ? sines[row].count : 0.0;
    of_very_wide_rows += are_seen[row].count() >= many_bins ? sines[row].count : 0.0;
  }
  const double half = 0.5 * of_all.count;
  const bool is_ring = source == Source::Ring;
  const double most_variance = is_ring || of_very_wide_rows >= half
                                   ? most_variance_of_row
                                   : most_variance_of_part;
  return (is_ring || of_wide_rows >= half) && of_all.deviations() > 0.0 &&
         in_rows <= most_variance * of_all.deviations();
}

bool
LidarRows::readImage(const io::PointView& points)
{
  if (points.image.height > most_rows)
    return false;
  count_ = points.image.height;
  if (points.pixels == nullptr) {
    if (std::size_t{points.image.width} * count_ != points.count)
      return false;
    auto begin = rows_.begin();
    for (std::uint32_t row = 0; row < count_; ++row)
      begin = std::fill_n(begin, points.image.width, row);
    return true;
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    rows_[i] = points.pixels[i] / points.image.width;
    if (rows_[i] >= count_)
      return false;
  }
  return true;
}

bool
LidarRows::readRings(const io::FieldView& rings,
                     const std::vector<LidarPoint>& directions)
{
  const io::RingReader reader(rings);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    // Missing points may have any ring.
    if (directions[i].range == 0.0f)
      continue;
    const std::uint32_t row = reader.row(i);
    if (row >= most_rows)
      return false;
    rows_[i] = row;
    count_ = std::max(count_, row + 1);
  }
  return true;
}

/** \brief Tells rows from the elevations of all points, for sensors whose rows are
 * cones. */
bool
LidarRows::findByElevation(const std::vector<LidarPoint>& directions)
{
  const auto count = static_cast<std::size_t>(
      std::count_if(directions.begin(), directions.end(), [](const LidarPoint& point) {
        return point.range > 0.0f;
      }));
  // The first cloud may have few of the rows.
  if (elevation_rows_.count() == 0 ||
      count > elevation_points_ + elevation_points_ / 4) {
    constexpr std::size_t enough = 16384;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < directions.size(); ++i)
      if (const LidarPoint& point = directions[i];
          point.range > 0.0f && io::isChosen(i, directions.size(), enough)) {
        const auto slope = static_cast<double>(point.slope);
        const double distance =
            static_cast<double>(point.range) / std::sqrt(1.0 + slope * slope);
        points.emplace_back(distance, 0.0, slope * distance);
      }
    io::ElevationRows rows;
    if (rows.learn(points, least_rows * least_points_of_row) &&
        rows.count() >= least_rows)
      elevation_rows_ = rows;
    elevation_points_ = count;
  }
  if (elevation_rows_.count() == 0)
    return false;
  for (std::size_t i = 0; i < directions.size(); ++i)
    rows_[i] = elevation_rows_.nextRow(static_cast<double>(directions[i].slope));
  count_ = elevation_rows_.count();
  return true;
}

/** \brief Tells rows from where a turn ends, for clouds with one row after the other:
 * ahead or behind, whichever makes fewer rows. */
bool
LidarRows::findByTurns(const std::vector<LidarPoint>& directions)
{
  count_ = most_rows + 1;
  std::size_t points = 0;
  for (const float begin : {0.0f, 0.5f}) {
    std::uint32_t row = 0;
    points = 0;
    float last = 0.0f;
    turn_rows_.assign(directions.size(), no_row);
    for (std::size_t i = 0; i < directions.size() && row < most_rows; ++i) {
      if (directions[i].range == 0.0f)
        continue;
      const float azimuth =
          directions[i].azimuth + (directions[i].azimuth < begin ? 1.0f : 0.0f);
      if (points > 0 && std::abs(azimuth - last) > 0.5f)
        ++row;
      last = azimuth;
      turn_rows_[i] = row;
      ++points;
    }
    if (row + 1 < count_) {
      rows_.swap(turn_rows_);
      count_ = row + 1;
    }
  }
  return count_ >= least_rows && count_ <= most_rows &&
         points >= 2 * least_points_of_row * count_;
}

/** \brief Sorts rows by their mean elevation, as lasers may have any numbers; again if a
 * row has points that had none in all clouds before.
 */
void
LidarRows::sortRows(const std::vector<LidarPoint>& directions)
{
  if (ranks_.size() != count_)
    elevations_.assign(count_, std::numeric_limits<double>::quiet_NaN());
  if (ranks_.size() != count_ ||
      (ranked_rows_ < count_ &&
       std::any_of(rows_.begin(), rows_.end(), [&](std::uint32_t row) {
         return row != no_row && ranks_[row] == no_row;
       })))
    rankRows(directions);
  count_ = ranked_rows_;
  if (are_ranked_)
    return;
  for (std::uint32_t& row : rows_)
    row = row == no_row ? no_row : ranks_[row];
}

void
LidarRows::rankRows(const std::vector<LidarPoint>& directions)
{
  std::vector<double> sums(count_);
  std::vector<std::size_t> sizes(count_);
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i] != no_row) {
      sums[rows_[i]] += sineOf(directions[i].slope);
      ++sizes[rows_[i]];
    }
  std::vector<std::uint32_t> order;
  for (std::uint32_t row = 0; row < count_; ++row) {
    if (sizes[row] > 0)
      elevations_[row] = sums[row] / static_cast<double>(sizes[row]);
    if (!std::isnan(elevations_[row]))
      order.push_back(row);
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t one, std::uint32_t other) {
    return elevations_[one] < elevations_[other] ||
           (elevations_[one] == elevations_[other] && one < other);
  });
  ranks_.assign(count_, no_row);
  for (std::uint32_t rank = 0; rank < order.size(); ++rank)
    ranks_[order[rank]] = rank;
  ranked_rows_ = static_cast<std::uint32_t>(order.size());
  are_ranked_ = ranked_rows_ == count_ && std::is_sorted(order.begin(), order.end());
}

} // namespace pcl_ext::PCL_EXT_ABI
