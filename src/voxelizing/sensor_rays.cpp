// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_rays.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext {
namespace io {

namespace {

Eigen::Vector3d
vectorOf(const std::array<double, 3>& position)
{
  return {position[0], position[1], position[2]};
}

/** \brief Points in the coordinates of the sensor, but for those at the sensor.
 * \param[in] is_used called with the column of each
 */
template <typename IsUsedT>
std::vector<PixelPoint>
pixelPointsOf(const SensorCloud& cloud,
              const ScanColumns& columns,
              const WorldPose& pose,
              const IsUsedT& is_used)
{
  const WorldPose to_sensor = pose.inverse();
  std::vector<PixelPoint> points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool has_rings = cloud.image.width == 0;
    const std::uint32_t row =
        has_rings ? cloud.rings[i] : cloud.pixels[i] / cloud.image.width;
    const std::uint32_t column =
        has_rings ? columns.columns()[i] : cloud.pixels[i] % cloud.image.width;
    if (!is_used(column))
      continue;
    points.push_back({row, column, to_sensor * vectorOf(cloud.positions[i])});
    if (isAtSensor(points.back()))
      points.pop_back();
  }
  return points;
}

/** \brief The pose of columns that are turned since their step was found. */
WorldPose
turnedPose(const WorldPose& pose, double shift)
{
  WorldPose turned = pose;
  turned.rotate(Eigen::AngleAxisd(shift, Eigen::Vector3d::UnitZ()));
  return turned;
}

/** \brief A point of a firing. */
struct ColumnPoint {
  double angle;    ///< from the direction that it was expected in, radians
  double distance; ///< from the axis, metres
};

/** \param[in] column direction that is expected of its column
 * \param[in] row how far its row is turned from that
 */
ColumnPoint
columnPointOf(const Eigen::Vector3d& position,
              const Eigen::Vector2d& column,
              const Eigen::Vector2d& row)
{
  const double x = column.x() * row.x() - column.y() * row.y();
  const double y = column.x() * row.y() + column.y() * row.x();
  const double ahead = position.x() * x + position.y() * y;
  const double left = position.y() * x - position.x() * y;
  const double distance = std::sqrt(ahead * ahead + left * left);
  // Mostly the arc tangent is next to its argument.
  constexpr double small = 0.01;
  if (std::abs(left) > small * ahead)
    return {std::atan2(left, ahead), distance};
  const double tangent = ahead > 0.0 ? left / ahead : 0.0;
  return {tangent - tangent * tangent * tangent / 3.0, distance};
}

} // namespace

bool
SensorRays::areOf(const scan::ScanLayout& layout) const
{
  const bool are_firings = layout.order == scan::PointOrder::ColumnByColumn;
  return (are_firings ? spinning_.has_value() : fitted_.has_value()) &&
         layout.order == layout_.order && layout.height == layout_.height &&
         (are_firings || layout.width == layout_.width);
}

bool
SensorRays::fit(const SensorCloud& cloud,
                const ScanColumns& columns,
                const WorldPose& pose,
                const VoxelGrid& grid,
                const scan::ScanLayout& layout)
{
  fitted_.reset();
  spinning_.reset();
  shifts_.clear();
  layout_.width = layout.width;
  layout_.height = layout.height;
  layout_.order = layout.order;
  is_new_ = true;
  const auto all = [](std::uint32_t) { return true; };
  const ImageSize size{layout.width, layout.height};
  switch (layout.order) {
  case scan::PointOrder::Organised:
    fitted_ = fitRays(pixelPointsOf(cloud, columns, pose, all), pose, grid, size);
    break;
  case scan::PointOrder::RowByRow:
    fitted_ = fitSpinningRays(
        pixelPointsOf(cloud, columns, turnedPose(pose, columns.shift()), all),
        size,
        columns.step());
    break;
  case scan::PointOrder::ColumnByColumn:
    spinning_ = fitSpinning(pixelPointsOf(cloud,
                                          columns,
                                          pose,
                                          [&](std::uint32_t column) {
                                            return isSampled(column, layout.width);
                                          }),
                            layout.height,
                            layout.width,
                            grid.resolution);
    break;
  }
  return fitted_ || spinning_;
}

bool
SensorRays::set(const SensorCloud& cloud,
                const ScanColumns& columns,
                const WorldPose& pose,
                scan::ScanFrame& frame)
{
  turns_.clear();
  if (frame.order == scan::PointOrder::Organised)
    return setRays(*fitted_, pose, frame.grid, frame);
  if (frame.order == scan::PointOrder::RowByRow)
    return setRays(*fitted_, turnedPose(pose, columns.shift()), frame.grid, frame);
  const auto is_sampled = [&](std::uint32_t column) {
    return isSampled(column, frame.width);
  };
  if (spinning_->has_motion && !is_new_)
    followMotion(
        pixelPointsOf(cloud, columns, pose, is_sampled), frame.width, *spinning_);
  is_new_ = false;
  if (!setSpinningRays(*spinning_, pose, frame.grid, frame))
    return false;
  findAngles(cloud, columns, pose, frame.grid.resolution, frame);
  shiftRows(frame);
  return true;
}

/** \brief Moves rows by the columns that their angle takes. */
void
SensorRays::shiftRows(scan::ScanFrame& frame)
{
  if (shifts_.empty())
    shifts_ = findShifts(frame);
  const std::uint16_t most = *std::max_element(shifts_.begin(), shifts_.end());
  if (most == 0)
    return;
  frame.row_shifts = shifts_;
  frame.width += most;
}

std::vector<std::uint16_t>
SensorRays::findShifts(const scan::ScanFrame& frame) const
{
  const std::vector<std::int32_t>& angles = frame.rays.columns;
  std::vector<std::int32_t> steps;
  for (std::size_t column = 1; column < angles.size(); ++column)
    steps.push_back(angles[column] - angles[column - 1]);
  std::vector<std::uint16_t> none(frame.height);
  if (steps.empty())
    return none;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (*middle == 0)
    return none;
  std::vector<double> shifts;
  for (const FittedRays::Row& row : spinning_->rows)
    shifts.push_back(std::round(std::remainder(row.angle, two_pi) /
                                (*middle * spinning_->turn_step)));
  const auto [least, most] = std::minmax_element(shifts.begin(), shifts.end());
  // Wider scans take bytes for pixels without points.
  if (*most - *least > 0.25 * frame.width)
    return none;
  for (std::size_t row = 0; row < shifts.size(); ++row)
    none[row] = static_cast<std::uint16_t>(shifts[row] - *least);
  return none;
}

/** \brief Sets the angle of each column to the middle of its points, and turns those that
 * are further from it than their rays may be. */
void
SensorRays::findAngles(const SensorCloud& cloud,
                       const ScanColumns& columns,
                       const WorldPose& pose,
                       double resolution,
                       scan::ScanFrame& frame)
{
  const SpinningFit& fit = *spinning_;
  const WorldPose to_sensor = pose.inverse();
  const double steps_of_turn = two_pi / fit.turn_step;
  std::vector<Eigen::Vector2d> row_directions;
  for (const FittedRays::Row& row : fit.rows)
    row_directions.emplace_back(std::cos(row.angle), std::sin(row.angle));
  frame.rays.columns.assign(frame.width, 0);
  turns_.assign(fit.has_turn_step ? cloud.size() : 0, 0);
  std::vector<ColumnPoint> points;
  std::vector<double> off; // of a column's points, from the column before
  std::int32_t last = 0;
  for (std::size_t begin = 0, end = 0; begin < cloud.size(); begin = end) {
    const std::uint32_t column = columns.columns()[begin];
    const double last_angle = last * fit.turn_step;
    const Eigen::Vector2d direction(std::cos(last_angle), std::sin(last_angle));
    points.clear();
    off.clear();
    for (; end < cloud.size() && columns.columns()[end] == column; ++end) {
      Eigen::Vector3d position = to_sensor * vectorOf(cloud.positions[end]);
      if (fit.has_motion)
        position = fit.motion.stillPosition(position, timeOf(column, frame.width));
      points.push_back(
          columnPointOf(position, direction, row_directions[cloud.rings[end]]));
      if (points.back().distance > 0.0)
        off.push_back(points.back().angle);
    }
    if (!off.empty()) {
      const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
      std::nth_element(off.begin(), middle, off.end());
      last += static_cast<std::int32_t>(std::llround(*middle / fit.turn_step));
    }
    frame.rays.columns[column] = last;
    const double moved = last * fit.turn_step - last_angle;
    for (std::size_t i = begin; fit.has_turn_step && i < end; ++i) {
      const ColumnPoint& point = points[i - begin];
      const double turn = point.angle - moved;
      if (std::abs(turn) * point.distance > 0.5 * resolution)
        turns_[i] = static_cast<std::int32_t>(
            std::llround(std::remainder(turn / fit.turn_step, steps_of_turn)));
    }
  }
}

} // namespace io
} // namespace pcl_ext
