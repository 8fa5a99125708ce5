// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/camera_pixels.h"

#include "voxelizing/ray_fit.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Clouds of fewer points take few bytes anyway. */
constexpr std::size_t least_points = 1024;
constexpr std::size_t least_rows = 16;

/** \brief Of points that are not missing, metres; see isAtSensor(). */
constexpr double least_depth = 1e-6;

/** \brief Cameras see less than 180 degrees. */
constexpr double steepest = 50.0;

/** \brief So many points or pairs of points are enough to tell a step. */
constexpr std::size_t enough = 4096;

/** \brief Points are nearer to their pixels on average, in steps; 0.25 by chance. Those
 * of whole millimetres are 0.15 from them. */
constexpr double farthest_from_pixels = 0.18;

/** \brief Sides are this part longer than what is seen, as in later clouds points may be
 * beside those of the first one. */
constexpr double margin = 0.125;

/** \brief Makes a step exact, as of pairs ever farther apart it is known how many steps
 * they are apart.
 * \param[in] for_each_pair calls back with the difference of each pair of numbers that
 * are so many places apart
 * \param[in,out] step
 */
template <typename ForEachPairT>
void
refineStep(const ForEachPairT& for_each_pair, double& step)
{
  for (std::size_t places = 4; places <= 1024; places *= 4) {
    double products = 0.0;
    double squares = 0.0;
    for_each_pair(places, [&](double difference) {
      const double steps = std::round(difference / step);
      // Of others, as of two rows, the number of steps is not known yet.
      if (2.0 * steps < static_cast<double>(places) ||
          steps > 2.0 * static_cast<double>(places))
        return;
      products += difference * steps;
      squares += steps * steps;
    });
    if (!(squares > 0.0))
      return;
    step = products / squares;
  }
}

/** \brief Sets where the pixels of a side begin and how many they are.
 * \param[in,out] slopes some of them, not empty; are sorted
 */
template <typename SideT>
bool
setRange(std::vector<double>& slopes, SideT& side)
{
  constexpr double least_count = 16.0;
  constexpr double most_count = 8192.0;
  double offset = 0.0;
  coherence(slopes, std::abs(side.step), offset);
  // Without a few that may be odd.
  std::sort(slopes.begin(), slopes.end());
  const double least = slopes[slopes.size() / 200];
  const double most = slopes[slopes.size() - 1 - slopes.size() / 200];
  const double extent = std::ceil((most - least) / std::abs(side.step)) + 1.0;
  if (!(extent >= least_count && extent <= most_count))
    return false;
  const double pixels_before = std::ceil(margin * extent);
  const double first = side.step > 0.0 ? least : most;
  side.begin =
      offset + side.step * (std::round((first - offset) / side.step) - pixels_before);
  side.per_slope = 1.0 / side.step;
  side.count = static_cast<std::uint32_t>(extent + 2.0 * pixels_before);
  return true;
}

/** \brief How many of some points may be where no pixel is, or in another order. */
std::size_t
mostOdd(std::size_t points)
{
  return points / 50;
}

constexpr std::uint32_t no_pixel = ~std::uint32_t{0};

} // namespace

/** \brief The points of a cloud, and how to move them to the camera. */
struct CameraPixels::Points {
  const std::vector<std::array<double, 3>>& positions;
  Eigen::Matrix4d to_sensor;

  std::size_t
  size() const
  {
    return positions.size();
  }

  /** \brief Whether a point is at the sensor, as drivers write missing ones. */
  bool
  isMissing(std::size_t point) const
  {
    return isAtSensor(
        {coordinate(point, 0), coordinate(point, 1), coordinate(point, 2)});
  }

  /** \brief Of a point in the coordinates of the camera. */
  double
  coordinate(std::size_t point, int axis) const
  {
    const std::array<double, 3>& at = positions[point];
    return to_sensor(axis, 0) * at[0] + to_sensor(axis, 1) * at[1] +
           to_sensor(axis, 2) * at[2] + to_sensor(axis, 3);
  }
};

bool
CameraPixels::find(const std::vector<std::array<double, 3>>& positions,
                   const WorldPose& to_sensor,
                   bool may_refit,
                   std::vector<std::uint32_t>& pixels)
{
  const Points points{positions, to_sensor.matrix()};
  const bool has_steps = columns_.count > 0;
  if (has_steps && assign(points, pixels))
    return true;
  if (!(may_refit || has_steps) || !fit(points, pixels))
    columns_.count = 0;
  // Fits are rare, so that their memory is not kept.
  along_row_ = std::vector<double>();
  along_column_ = std::vector<double>();
  return columns_.count > 0;
}

/** \brief Finds depth, rows and columns among the axes. */
bool
CameraPixels::fit(const Points& points, std::vector<std::uint32_t>& pixels)
{
  for (int side = 0; side < 6; ++side) {
    depth_axis_ = side / 2;
    depth_sign_ = side % 2 == 0 ? 1.0 : -1.0;
    for (const int other : {1, 2}) {
      columns_.axis = (depth_axis_ + other) % 3;
      rows_.axis = 3 - depth_axis_ - columns_.axis;
      if (!setSlopes(points))
        break;
      // Points that are all on one side of the image seem to be before another axis, too.
      if (hasRowsOfSteps() && findColumns() && findRows() && assign(points, pixels))
        return true;
    }
  }
  return false;
}

/** \brief Sets the slopes of all points but missing ones.
 * \return false if more than a few are beside or behind the camera, or few before it
 */
bool
CameraPixels::setSlopes(const Points& points)
{
  along_row_.clear();
  along_column_.clear();
  std::size_t odd = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double depth = depth_sign_ * points.coordinate(i, depth_axis_);
    const double along_row = points.coordinate(i, columns_.axis) / depth;
    const double along_column = points.coordinate(i, rows_.axis) / depth;
    if (depth > least_depth && std::abs(along_row) <= steepest &&
        std::abs(along_column) <= steepest) {
      along_row_.push_back(along_row);
      along_column_.push_back(along_column);
    }
    else if (!points.isMissing(i) && ++odd > mostOdd(points.size()))
      return false;
  }
  return along_row_.size() >= least_points;
}

/** \brief Whether most neighbours in the cloud are about a step apart along one axis, and
 * at one place on the other; sets the step. */
bool
CameraPixels::hasRowsOfSteps()
{
  const std::size_t count = along_row_.size();
  std::vector<double> across;
  std::vector<double> along;
  for (std::size_t i = 1; i < count; ++i)
    if (isChosen(i, count, enough)) {
      across.push_back(std::abs(along_column_[i] - along_column_[i - 1]));
      along.push_back(along_row_[i] - along_row_[i - 1]);
    }
  const double step = quantileOf(along);
  const auto of_a_step =
      std::count_if(along.begin(), along.end(), [&](double distance) {
        return std::abs(distance - step) < 0.6 * std::abs(step);
      });
  columns_.step = step;
  return step != 0.0 && 2 * static_cast<std::size_t>(of_a_step) > along.size() &&
         quantileOf(across) < 0.5 * std::abs(step);
}

/** \brief Finds the columns, whose step is known roughly. */
bool
CameraPixels::findColumns()
{
  const std::size_t count = along_row_.size();
  double& step = columns_.step;
  refineStep(
      [&](std::size_t places, const auto& add) {
        for (std::size_t i = places; i < count; ++i)
          if (isChosen(i, count, enough) &&
              std::abs(along_column_[i] - along_column_[i - places]) <
                  0.5 * std::abs(step))
            add(along_row_[i] - along_row_[i - places]);
      },
      step);
  std::vector<double> sample;
  for (std::size_t i = 0; i < count; ++i)
    if (isChosen(i, count, enough))
      sample.push_back(along_row_[i]);
  return setRange(sample, columns_);
}

/** \brief Finds the rows: one begins where the slopes of the columns go back. */
bool
CameraPixels::findRows()
{
  std::vector<double> slopes; // mean of each row
  const auto add_row = [&](std::size_t begin, std::size_t end) {
    const double sum =
        std::accumulate(along_column_.begin() + static_cast<std::ptrdiff_t>(begin),
                        along_column_.begin() + static_cast<std::ptrdiff_t>(end),
                        0.0);
    slopes.push_back(sum / static_cast<double>(end - begin));
  };
  std::size_t begin = 0;
  for (std::size_t i = 1; i < along_row_.size(); ++i)
    if ((along_row_[i] - along_row_[i - 1]) / columns_.step < -0.6) {
      add_row(begin, i);
      begin = i;
    }
  add_row(begin, along_row_.size());
  if (slopes.size() < least_rows)
    return false;
  std::vector<double> steps;
  for (std::size_t row = 1; row < slopes.size(); ++row)
    steps.push_back(slopes[row] - slopes[row - 1]);
  double& step = rows_.step;
  step = quantileOf(steps);
  // Pixels are hardly ever longer than wide.
  const double ratio = std::abs(step / columns_.step);
  if (!(ratio > 0.25 && ratio < 4.0))
    return false;
  refineStep(
      [&](std::size_t places, const auto& add) {
        for (std::size_t row = places; row < slopes.size(); ++row)
          add(slopes[row] - slopes[row - places]);
      },
      step);
  return setRange(slopes, rows_);
}

/** \brief Sets the pixels of all points.
 * \return false if more than a few are outside of the image or not in the order of their
 * pixels, or many between pixels
 */
bool
CameraPixels::assign(const Points& points, std::vector<std::uint32_t>& pixels) const
{
  pixels.resize(points.size());
  double off = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    pixels[i] = nearestPixel(points, i, off);
  if (!(off <= 2.0 * farthest_from_pixels * static_cast<double>(points.size())))
    return false;
  const std::uint32_t end = columns_.count * rows_.count;
  std::size_t odd = 0;
  std::uint32_t next = 0; // the least pixel that a point may be in
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t nearest = pixels[i];
    const std::uint32_t following = i + 1 < points.size() ? pixels[i + 1] : no_pixel;
    const bool is_ahead = following >= next && following < nearest;
    if (nearest < next || is_ahead || nearest == no_pixel) {
      // Of two that seem to be in one pixel the second one is in the next.
      odd += nearest + 1 == next || points.isMissing(i) ? 0 : 1;
      pixels[i] = next;
    }
    if (pixels[i] >= end || odd > mostOdd(points.size()))
      return false;
    next = pixels[i] + 1;
  }
  return true;
}

/** \brief The pixel that a point is nearest to, or no_pixel.
 * \param[in,out] off how far points are from their pixels, in all, is added to
 */
std::uint32_t
CameraPixels::nearestPixel(const Points& points, std::size_t point, double& off) const
{
  const double depth = depth_sign_ * points.coordinate(point, depth_axis_);
  if (!(depth > least_depth))
    return no_pixel;
  // From the upper left corner of the image.
  const double right =
      (points.coordinate(point, columns_.axis) / depth - columns_.begin) *
          columns_.per_slope +
      0.5;
  const double down =
      (points.coordinate(point, rows_.axis) / depth - rows_.begin) * rows_.per_slope +
      0.5;
  if (!(right >= 0.0 && right < columns_.count && down >= 0.0 && down < rows_.count))
    return no_pixel;
  const auto column = static_cast<std::uint32_t>(right);
  const auto row = static_cast<std::uint32_t>(down);
  off += std::abs(right - column - 0.5) + std::abs(down - row - 0.5);
  return row * columns_.count + column;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
