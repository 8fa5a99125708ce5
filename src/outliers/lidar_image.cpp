// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/lidar_image.h"

#include "voxelizing/point_batches.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::uint32_t least_columns = 16;
constexpr std::uint32_t most_columns = 8192;
/** \brief Most pixels for each point: more are those of a turn with hardly any points. */
constexpr std::size_t most_pixels_of_point = 64;

/** \brief Azimuth in turns, 0 to 1, to 1.3e-5: near enough for columns, and quick. From
 * -x on, anticlockwise.
 */
float
turnOf(float x, float y)
{
  const float larger = std::max(std::abs(x), std::abs(y));
  const float ratio = std::min(std::abs(x), std::abs(y)) / larger;
  const float square = ratio * ratio;
  // Near-minimax polynomial of atan(ratio) / 2 pi.
  const float eighth =
      ratio * (0.1590298f +
               square * (-0.05111643f + square * (0.02327833f - 0.00620464f * square)));
  const float quarter = std::abs(y) > std::abs(x) ? 0.25f - eighth : eighth;
  const float half = x < 0.0f ? 0.5f - quarter : quarter;
  return 0.5f + (y < 0.0f ? -half : half);
}

/** \brief Whether a point hides another one in its direction: the nearer one, or the
 * first. */
bool
isBefore(const std::vector<LidarPoint>& points, std::uint32_t one, std::uint32_t other)
{
  const float range = points[one].range;
  return range < points[other].range || (range == points[other].range && one < other);
}

bool
isSameRange(const LidarPoint& one, const LidarPoint& other)
{
  return std::abs(one.range - other.range) < 0.01f * one.range;
}

} // namespace

bool
LidarImage::assign(const io::PointView& points)
{
  // A look at the clouds of a camera takes as long as judging those of a lidar.
  constexpr unsigned int tries = 3;
  constexpr std::ptrdiff_t least_points = 1000;
  constexpr unsigned int skipped_clouds = 15;
  if (skipped_ > 0) {
    --skipped_;
    return false;
  }
  const bool has_rows = findPixels(points);
  // Clouds of hardly any points tell nothing, as those of a sensor that starts.
  if (has_rows)
    failures_ = 0;
  else if (std::count_if(points_.begin(), points_.end(), [](const LidarPoint& point) {
             return point.range > 0.0f;
           }) >= least_points)
    ++failures_;
  if (failures_ >= tries)
    skipped_ = skipped_clouds;
  return has_rows;
}

bool
LidarImage::findPixels(const io::PointView& points)
{
  readPoints(points);
  pixels_.assign(points.count, no_pixel);
  if (!rows_.find(points, points_))
    return false;
  // The first cloud may have few points.
  const std::size_t count =
      points.count - static_cast<std::size_t>(std::count(
                         rows_.ofPoints().begin(), rows_.ofPoints().end(), no_row));
  if (width_ == 0 || count > width_points_ + width_points_ / 4) {
    findWidth();
    width_points_ = count;
  }
  const std::size_t pixels = std::size_t{width_} * rows_.count();
  if (width_ == 0 || pixels > most_pixels_of_point * points.count)
    return false;
  ranges_.assign(pixels, 0.0f);
  sortByDirection();
  for (std::uint32_t row = 0; row < rows_.count(); ++row)
    placeRow(row);
  return true;
}

void
LidarImage::readPoints(const io::PointView& points)
{
  points_.assign(points.count, LidarPoint());
  auto direction = points_.begin();
  io::visitPoints(points, [&direction](const auto* point) {
    const auto x = static_cast<float>(point[0]);
    const auto y = static_cast<float>(point[1]);
    const auto z = static_cast<float>(point[2]);
    const float from_axis = std::sqrt(x * x + y * y);
    const float range = std::sqrt(x * x + y * y + z * z);
    // NaN and points on the axis have no direction.
    if (from_axis > 1e-6f && range < 1e6f)
      *direction = {range, turnOf(x, y), z / from_axis};
    ++direction;
  });
}

/** \brief Finds how many columns a turn has, by the distance of neighbours in some of
 * the rows. */
void
LidarImage::findWidth()
{
  constexpr std::uint32_t enough_rows = 16;
  const std::uint32_t every = rows_.count() / enough_rows + 1;
  std::vector<std::vector<float>> azimuths(rows_.count() / every + 1);
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (const std::uint32_t row = rows_.ofPoints()[i];
        row != no_row && row % every == 0)
      azimuths[row / every].push_back(points_[i].azimuth);
  const float step = io::stepOfNeighbours(azimuths, 1.0f / most_columns);
  if (step == 0.0f)
    return;
  const auto columns = static_cast<std::uint32_t>(std::lround(1.0f / step));
  width_ = columns < least_columns ? 0 : columns;
}

/** \brief Sorts the points by row and azimuth: by columns, and within them. */
void
LidarImage::sortByDirection()
{
  const std::vector<std::uint32_t>& rows = rows_.ofPoints();
  // A direction counts at the place after next, so that it is where the next one begins
  // once its points are sorted in.
  begins_.assign(std::size_t{width_} * rows_.count() + 2, 0);
  directions_.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (rows[i] == no_row)
      continue;
    const auto column =
        static_cast<std::uint32_t>(points_[i].azimuth * static_cast<float>(width_));
    directions_[i] = rows[i] * width_ + std::min(column, width_ - 1);
    ++begins_[directions_[i] + 2];
  }
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  sorted_.resize(begins_.back());
  for (std::uint32_t i = 0; i < points_.size(); ++i)
    if (rows[i] != no_row)
      sorted_[begins_[directions_[i] + 1]++] = i;
  for (std::size_t i = 0; i + 2 < begins_.size(); ++i)
    if (begins_[i + 1] - begins_[i] > 1)
      std::sort(sorted_.begin() + begins_[i],
                sorted_.begin() + begins_[i + 1],
                [&](std::uint32_t one, std::uint32_t other) {
                  const float azimuth = points_[one].azimuth;
                  return azimuth < points_[other].azimuth ||
                         (azimuth == points_[other].azimuth && one < other);
                });
}

/** \brief Gives the points of a row columns of their own in the order of their azimuths,
 * as near to these as it can be done. Of several in the same direction, as those of
 * sensors with two echoes, the nearest one gets it: what floats is in front. */
void
LidarImage::placeRow(std::uint32_t row)
{
  constexpr float same_direction = 0.125f; // columns
  placed_.clear();
  columns_.clear();
  repetitions_.clear();
  const std::size_t first = std::size_t{row} * width_;
  std::uint32_t next = 0;
  for (std::uint32_t column = 0; column < width_; ++column) {
    const std::uint32_t begin = begins_[first + column];
    const std::uint32_t end = begins_[first + column + 1];
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t point = sorted_[i];
      if (!placed_.empty() &&
          std::abs(points_[point].azimuth - points_[placed_.back()].azimuth) *
                  static_cast<float>(width_) <
              same_direction) {
        repetitions_.push_back({point, static_cast<std::uint32_t>(placed_.size() - 1)});
        if (isBefore(points_, point, placed_.back()))
          std::swap(placed_.back(), repetitions_.back().point);
      }
      else
        placed_.push_back(point);
    }
    const auto count = static_cast<std::uint32_t>(placed_.size() - columns_.size());
    const std::uint32_t half = std::min(count / 2, column);
    next = std::max(next, column - half);
    for (std::uint32_t i = 0; i < count; ++i)
      columns_.push_back(next++);
  }
  // Those beyond the last column move back.
  std::uint32_t end = width_;
  for (std::size_t i = placed_.size(); i-- > 0 && end > 0;) {
    end = std::min(columns_[i], end - 1);
    ranges_[first + end] = points_[placed_[i]].range;
    pixels_[placed_[i]] = static_cast<std::uint32_t>(first + end);
  }
  for (const Repetition& repetition : repetitions_)
    if (isSameRange(points_[repetition.point], points_[placed_[repetition.of]]))
      pixels_[repetition.point] = pixels_[placed_[repetition.of]];
}

} // namespace pcl_ext::PCL_EXT_ABI
