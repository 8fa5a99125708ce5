// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/camera_pixels.h"

#include "voxelizing/ray_fit.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Clouds of fewer points take few bytes anyway. */
constexpr std::size_t least_points = 1024;
constexpr std::size_t least_rows = 16;

/** \brief Of points that are not missing, metres; see isAtSensor(). */
constexpr double least_depth = 1e-6;

/** \brief Cameras see less than 180 degrees. */
constexpr double steepest = 50.0;

/** \brief So many points, or pairs of points, are enough to tell a step. */
constexpr std::size_t enough = 4096;
constexpr std::size_t least_chosen = 256;

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

template <typename SlopeT>
bool
isSeen(const SlopeT& slope)
{
  return slope.is_ahead && std::abs(slope.along_row) <= steepest &&
         std::abs(slope.along_column) <= steepest;
}

/** \brief Calls back with the slopes of pairs of points that are so many places apart. */
template <typename SlopesT, typename VisitT>
void
forEachPair(const SlopesT& slopes,
            const std::vector<std::uint32_t>& chosen,
            std::size_t places,
            const VisitT& visit)
{
  for (const std::uint32_t i : chosen) {
    if (i < places)
      continue;
    const auto one = slopes[i - places];
    const auto other = slopes[i];
    if (isSeen(one) && isSeen(other))
      visit(one, other);
  }
}

} // namespace

/** \brief The points of a cloud and the pose of the camera. */
struct CameraPixels::Points {
  const std::vector<std::array<double, 3>>& positions;
  Eigen::Matrix4d to_sensor;
};

/** \brief The slopes of the rays of points, as seen along an axis of the camera. */
class CameraPixels::Slopes {
public:
  struct Slope {
    double along_row;
    double along_column;
    bool is_ahead; ///< the point is before the camera; if not, there are no slopes
  };

  Slopes(const Points& points, int depth_axis, double depth_sign, int row, int column)
  : positions_(points.positions)
  , to_sensor_(points.to_sensor)
  , depth_(depth_sign * to_sensor_.row(depth_axis))
  , along_row_(to_sensor_.row(row))
  , along_column_(to_sensor_.row(column))
  {}

  std::size_t
  size() const
  {
    return positions_.size();
  }

  Slope
  operator[](std::size_t point) const
  {
    const double depth = coordinate(point, depth_);
    const double per_depth = 1.0 / depth;
    return {coordinate(point, along_row_) * per_depth,
            coordinate(point, along_column_) * per_depth,
            depth > least_depth};
  }

  /** \brief Whether a point is at the sensor, as drivers write missing ones. */
  bool
  isMissing(std::size_t point) const
  {
    return isAtSensor({coordinate(point, to_sensor_.row(0)),
                       coordinate(point, to_sensor_.row(1)),
                       coordinate(point, to_sensor_.row(2))});
  }

private:
  double
  coordinate(std::size_t point, const Eigen::RowVector4d& row) const
  {
    const std::array<double, 3>& at = positions_[point];
    return row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3];
  }

  const std::vector<std::array<double, 3>>& positions_;
  Eigen::Matrix4d to_sensor_;
  Eigen::RowVector4d depth_;
  Eigen::RowVector4d along_row_;
  Eigen::RowVector4d along_column_;
};

bool
CameraPixels::find(const std::vector<std::array<double, 3>>& positions,
                   const WorldPose& to_sensor,
                   bool may_refit,
                   std::vector<std::uint32_t>& pixels)
{
  const Points points{positions, to_sensor.matrix()};
  const bool has_steps = columns_.count > 0;
  if (has_steps && assign(slopesOf(points), pixels))
    return true;
  if ((may_refit || has_steps) && fit(points, pixels))
    return true;
  columns_.count = 0;
  return false;
}

/** \brief Finds depth, rows and columns among the axes. */
bool
CameraPixels::fit(const Points& points, std::vector<std::uint32_t>& pixels)
{
  const std::size_t count = points.positions.size();
  if (count < least_points)
    return false;
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < count; ++i)
    if (isChosen(i, count, enough))
      chosen.push_back(i);
  for (int side = 0; side < 6; ++side) {
    depth_axis_ = side / 2;
    depth_sign_ = side % 2 == 0 ? 1.0 : -1.0;
    for (const int other : {1, 2}) {
      columns_.axis = (depth_axis_ + other) % 3;
      rows_.axis = 3 - depth_axis_ - columns_.axis;
      const Slopes slopes = slopesOf(points);
      if (!areAhead(slopes, chosen))
        break;
      // Points that are all on one side of the image seem to be before another axis, too.
      if (hasRowsOfSteps(slopes, chosen) && findColumns(slopes, chosen) &&
          findRows(slopes) && assign(slopes, pixels))
        return true;
    }
  }
  return false;
}

CameraPixels::Slopes
CameraPixels::slopesOf(const Points& points) const
{
  return {points, depth_axis_, depth_sign_, columns_.axis, rows_.axis};
}

/** \brief Whether the chosen points but missing ones are before the camera, or all but a
 * few. */
bool
CameraPixels::areAhead(const Slopes& slopes, const std::vector<std::uint32_t>& chosen)
{
  std::size_t ahead = 0;
  std::size_t odd = 0;
  for (const std::uint32_t i : chosen) {
    if (isSeen(slopes[i]))
      ++ahead;
    else
      odd += slopes.isMissing(i) ? 0 : 1;
  }
  return ahead >= least_chosen && odd <= mostOdd(chosen.size());
}

/** \brief Whether most neighbours in the cloud are about a step apart along one axis, and
 * at one place on the other; sets the step. */
bool
CameraPixels::hasRowsOfSteps(const Slopes& slopes,
                             const std::vector<std::uint32_t>& chosen)
{
  std::vector<double> across;
  std::vector<double> along;
  forEachPair(slopes, chosen, 1, [&](const auto& one, const auto& next) {
    across.push_back(std::abs(next.along_column - one.along_column));
    along.push_back(next.along_row - one.along_row);
  });
  if (along.empty())
    return false;
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
CameraPixels::findColumns(const Slopes& slopes,
                          const std::vector<std::uint32_t>& chosen)
{
  double& step = columns_.step;
  refineStep(
      [&](std::size_t places, const auto& add) {
        forEachPair(slopes, chosen, places, [&](const auto& one, const auto& other) {
          if (std::abs(other.along_column - one.along_column) < 0.5 * std::abs(step))
            add(other.along_row - one.along_row);
        });
      },
      step);
  std::vector<double> sample;
  for (const std::uint32_t i : chosen)
    if (const auto slope = slopes[i]; isSeen(slope))
      sample.push_back(slope.along_row);
  return setRange(sample, columns_);
}

/** \brief Finds the rows: one begins where the slopes of the columns go back. */
bool
CameraPixels::findRows(const Slopes& slopes)
{
  std::vector<double> rows; // mean slope of each
  double sum = 0.0;
  std::size_t count = 0;
  double last = 0.0;
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const auto slope = slopes[i];
    if (!isSeen(slope))
      continue;
    if (count > 0 && (slope.along_row - last) * columns_.per_slope < -0.6) {
      rows.push_back(sum / static_cast<double>(count));
      sum = 0.0;
      count = 0;
    }
    sum += slope.along_column;
    ++count;
    last = slope.along_row;
  }
  rows.push_back(sum / static_cast<double>(count));
  if (rows.size() < least_rows)
    return false;
  std::vector<double> steps;
  for (std::size_t row = 1; row < rows.size(); ++row)
    steps.push_back(rows[row] - rows[row - 1]);
  double& step = rows_.step;
  step = quantileOf(steps);
  // Pixels are hardly ever longer than wide.
  const double ratio = std::abs(step / columns_.step);
  if (!(ratio > 0.25 && ratio < 4.0))
    return false;
  refineStep(
      [&](std::size_t places, const auto& add) {
        for (std::size_t row = places; row < rows.size(); ++row)
          add(rows[row] - rows[row - places]);
      },
      step);
  return setRange(rows, rows_);
}

/** \brief Sets the pixels of all points.
 * \return false if more than a few are outside of the image or not in the order of their
 * pixels, or many between pixels
 */
bool
CameraPixels::assign(const Slopes& slopes, std::vector<std::uint32_t>& pixels) const
{
  pixels.resize(slopes.size());
  double off = 0.0;
  for (std::size_t i = 0; i < slopes.size(); ++i)
    pixels[i] = nearestPixel(slopes, i, off);
  if (!(off <= 2.0 * farthest_from_pixels * static_cast<double>(slopes.size())))
    return false;
  const std::uint32_t end = columns_.count * rows_.count;
  std::size_t odd = 0;
  std::uint32_t next = 0; // the least pixel that a point may be in
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const std::uint32_t nearest = pixels[i];
    const std::uint32_t following = i + 1 < slopes.size() ? pixels[i + 1] : no_pixel;
    const bool is_ahead = following >= next && following < nearest;
    if (nearest < next || is_ahead || nearest == no_pixel) {
      // Of two that seem to be in one pixel the second one is in the next.
      odd += nearest + 1 == next || slopes.isMissing(i) ? 0 : 1;
      pixels[i] = next;
    }
    if (pixels[i] >= end || odd > mostOdd(slopes.size()))
      return false;
    next = pixels[i] + 1;
  }
  return true;
}

/** \brief The pixel that a point is nearest to, or no_pixel.
 * \param[in,out] off how far points are from their pixels, in all, is added to
 */
std::uint32_t
CameraPixels::nearestPixel(const Slopes& slopes, std::size_t point, double& off) const
{
  const Slopes::Slope slope = slopes[point];
  // From the upper left corner of the image.
  const double right = (slope.along_row - columns_.begin) * columns_.per_slope + 0.5;
  const double down = (slope.along_column - rows_.begin) * rows_.per_slope + 0.5;
  if (!(slope.is_ahead && right >= 0.0 && right < columns_.count && down >= 0.0 &&
        down < rows_.count))
    return no_pixel;
  const auto column = static_cast<std::uint32_t>(right);
  const auto row = static_cast<std::uint32_t>(down);
  off += std::abs(right - column - 0.5) + std::abs(down - row - 0.5);
  return row * columns_.count + column;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
