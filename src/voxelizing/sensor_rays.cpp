// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_rays.h"

#include "voxelizing/pixel_points.h"
#include "voxelizing/robust_fit.h"
#include "voxelizing/spinning_pose.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Nearer rays are those of the sensor: median distance of points, edges. */
constexpr double near_rays = 0.25;

SampledColumns
sampledColumns(const SensorCloud& cloud, const scan::ScanLayout& layout)
{
  return {layout.width, layout.pixelCount() / std::max<std::size_t>(1, cloud.size())};
}

/** \brief The pose of columns that are turned since their step was found. */
WorldPose
turnedPose(const WorldPose& pose, double shift)
{
  WorldPose turned = pose;
  turned.rotate(Eigen::AngleAxisd(shift, Eigen::Vector3d::UnitZ()));
  return turned;
}

/** \brief The angle of a point from the direction that it is expected in, radians.
 * \param[in] column direction that is expected of its column
 * \param[in] row how far its row is turned from that
 */
double
angleOff(const Eigen::Vector3d& position,
         const Eigen::Vector2d& column,
         const Eigen::Vector2d& row)
{
  const double x = column.x() * row.x() - column.y() * row.y();
  const double y = column.x() * row.y() + column.y() * row.x();
  const double ahead = position.x() * x + position.y() * y;
  const double left = position.y() * x - position.x() * y;
  // Mostly the arc tangent is next to its argument.
  constexpr double small = 0.01;
  if (std::abs(left) > small * ahead)
    return std::atan2(left, ahead);
  const double tangent = ahead > 0.0 ? left / ahead : 0.0;
  return tangent - tangent * tangent * tangent / 3.0;
}

} // namespace

bool
SensorRays::areOf(const scan::ScanLayout& layout) const
{
  return (planar_ || spinning_) && layout.order == layout_.order &&
         layout.height == layout_.height &&
         (layout.order == scan::PointOrder::ColumnByColumn ||
          layout.width == layout_.width);
}

void
SensorRays::findPose(const SensorCloud& cloud, const WorldPose& told)
{
  // Blocks, as missing points are side by side.
  constexpr std::size_t block = 64;
  constexpr std::size_t enough = 512;
  const WorldPose to_sensor = poseOf(told).inverse();
  std::vector<PixelPoint> points;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (isChosen(i / block, cloud.size() / block + 1, enough))
      points.push_back({cloud.rings[i], 0, to_sensor * vectorOf(cloud.positions[i])});
  if (const std::optional<WorldPose> found =
          findSpinningPose(points, repeatedPlace(points))) {
    // The turn begins far from where angles wrap.
    const Eigen::Vector3d first = found->inverse() * points.front().position;
    moved_ = moved_ * *found;
    moved_.rotate(
        Eigen::AngleAxisd(std::atan2(first.y(), first.x()), Eigen::Vector3d::UnitZ()));
  }
}

bool
SensorRays::followPose(const SensorCloud& cloud, const WorldPose& told)
{
  const bool are_columns_known =
      cloud.image.width > 0 || layout_.order == scan::PointOrder::ColumnByColumn;
  if (!spinning_ || !are_columns_known || !haveMoved())
    return false;
  const std::vector<PixelPoint> points =
      PixelPoints(cloud, poseOf(told)).ofEachRow(layout_.height);
  const std::optional<WorldPose> found =
      findSpinningPose(points, repeatedPlace(points));
  if (!found)
    return false;
  moved_ = moved_ * turnedToColumns(*found, points, *spinning_);
  return true;
}

bool
SensorRays::fit(const SensorCloud& cloud,
                const ScanColumns& columns,
                const WorldPose& told,
                const VoxelGrid& grid,
                bool may_change_depths,
                const scan::ScanLayout& layout)
{
  planar_.reset();
  spinning_.reset();
  shifts_.clear();
  layout_.width = layout.width;
  layout_.height = layout.height;
  layout_.order = layout.order;
  is_new_ = true;
  if (cloud.image.width > 0)
    moved_ = WorldPose::Identity();
  const WorldPose pose = poseOf(told);
  const ImageSize size{layout.width, layout.height};
  if (cloud.image.width > 0) {
    PixelPoints pixels(cloud, pose);
    std::vector<PixelPoint> points = pixels.ofEachRow(size.height);
    const Eigen::Vector3d place = repeatedPlace(points);
    const auto missing =
        std::count_if(points.begin(), points.end(), [&place](const PixelPoint& point) {
          return point.position == place;
        });
    // Fits are of the middle one of the points.
    if (2 * missing > static_cast<std::ptrdiff_t>(points.size())) {
      pixels.setMissing(pose * place);
      points = pixels.ofEachRow(size.height);
    }
    fitImage(points, place, pose, grid, may_change_depths, size);
  }
  else if (layout.order == scan::PointOrder::ColumnByColumn) {
    const SampledColumns sampled = sampledColumns(cloud, layout);
    spinning_ = fitSpinning(PixelPoints(cloud, pose).ofSampledColumns(sampled),
                            size.height,
                            sampled,
                            grid.resolution);
  }
  else
    spinning_ = fitEvenSpinning(
        PixelPoints(cloud, turnedPose(pose, columns.shift())).ofEachRow(size.height),
        size,
        columns.step());
  return planar_ || spinning_;
}

/** \brief Fits the rays of a camera.
 * \param[in] sample some points
 * \param[in] layout size of its image
 * \return median distance of the points from them, edges; of none infinity
 */
double
SensorRays::fitCamera(const std::vector<PixelPoint>& sample,
                      const WorldPose& pose,
                      const VoxelGrid& grid,
                      bool may_change_depths,
                      scan::ScanLayout layout)
{
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto fit : {fitPlanar, fitPlanarAnywhere}) {
    const std::optional<PlanarFit> found = fit(sample);
    if (!found || !setPlanarRays(*found, pose, grid, layout))
      continue;
    const double distance = distanceFromRays(sample, pose, grid, layout);
    if (distance < nearest) {
      planar_ = found;
      nearest = distance;
    }
    if (nearest <= near_rays)
      break;
  }
  if (!planar_)
    return nearest;
  if (may_change_depths)
    planar_depths_ = chooseDepths(sample, pose, grid.resolution, *planar_);
  planar_->depths = planar_depths_;
  return nearest;
}

/** \brief Fits the rays of an image, of whichever kind of sensor it is. */
void
SensorRays::fitImage(const std::vector<PixelPoint>& points,
                     const Eigen::Vector3d& place,
                     const WorldPose& pose,
                     const VoxelGrid& grid,
                     bool may_change_depths,
                     const ImageSize& size)
{
  // A camera has few numbers to fit.
  constexpr std::size_t enough = 2048;
  std::vector<PixelPoint> sample;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (isChosen(i, points.size(), enough))
      sample.push_back(points[i]);
  constexpr double far = std::numeric_limits<double>::infinity();
  scan::ScanLayout layout;
  layout.width = size.width;
  layout.height = size.height;
  const double of_planar = fitCamera(sample, pose, grid, may_change_depths, layout);
  if (of_planar <= near_rays)
    return;
  double of_spinning = far;
  const auto fit_spinning = [&](const WorldPose& moved) {
    const WorldPose to_sensor = moved.inverse();
    std::vector<PixelPoint> seen;
    for (const PixelPoint& point : points)
      if (const Eigen::Vector3d position = to_sensor * point.position;
          !isAtSensor(position))
        seen.push_back({point.row, point.column, position});
    const std::optional<SpinningFit> found = fitEvenSpinning(seen, size, std::nullopt);
    const double distance = found && setSpinningRays(*found, pose * moved, grid, layout)
                                ? distanceFromRays(sample, pose, grid, layout)
                                : far;
    if (distance < of_spinning) {
      spinning_ = found;
      moved_ = moved;
      of_spinning = distance;
    }
  };
  fit_spinning(WorldPose::Identity());
  if (of_spinning > near_rays)
    if (const std::optional<WorldPose> found = findSpinningPose(points, place))
      fit_spinning(*found);
  if (of_spinning < of_planar) {
    planar_.reset();
    return;
  }
  spinning_.reset();
  moved_ = WorldPose::Identity();
}

bool
SensorRays::set(const SensorCloud& cloud,
                const ScanColumns& columns,
                const WorldPose& told,
                scan::ScanFrame& frame)
{
  const WorldPose pose = poseOf(told);
  if (planar_)
    return setPlanarRays(*planar_, pose, frame.grid, frame);
  const bool is_image = cloud.image.width > 0;
  if (spinning_->is_even)
    return setSpinningRays(*spinning_,
                           is_image ? pose : turnedPose(pose, columns.shift()),
                           frame.grid,
                           frame);
  if (spinning_->has_motion && !is_new_) {
    const SampledColumns sampled = sampledColumns(cloud, frame);
    followMotion(
        PixelPoints(cloud, pose).ofSampledColumns(sampled), sampled, *spinning_);
  }
  is_new_ = false;
  if (!setSpinningRays(*spinning_, pose, frame.grid, frame))
    return false;
  findAngles(cloud, columns.columns(), pose, frame);
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
  const std::int32_t middle = quantileOf(steps);
  if (middle == 0)
    return none;
  std::vector<double> shifts;
  for (const RowFit& row : spinning_->rows)
    shifts.push_back(std::round(std::remainder(row.angle, two_pi) /
                                (middle * spinning_->turn_step)));
  const auto [least, most] = std::minmax_element(shifts.begin(), shifts.end());
  // Wider scans take bytes for pixels without points.
  if (*most - *least > 0.25 * frame.width)
    return none;
  for (std::size_t row = 0; row < shifts.size(); ++row)
    none[row] = static_cast<std::uint16_t>(shifts[row] - *least);
  return none;
}

/** \brief Sets the angle of each column to the middle of those of its points. */
void
SensorRays::findAngles(const SensorCloud& cloud,
                       const std::vector<std::uint32_t>& columns,
                       const WorldPose& pose,
                       scan::ScanFrame& frame) const
{
  const SpinningFit& fit = *spinning_;
  const WorldPose to_sensor = pose.inverse();
  std::vector<Eigen::Vector2d> row_directions;
  for (const RowFit& row : fit.rows)
    row_directions.emplace_back(std::cos(row.angle), std::sin(row.angle));
  frame.rays.columns.assign(frame.width, 0);
  std::vector<double> off; // of a column's points, from the column before
  std::int32_t last = 0;
  for (std::size_t begin = 0, end = 0; begin < cloud.size(); begin = end) {
    const std::uint32_t column = columns[begin];
    while (end < cloud.size() && columns[end] == column)
      ++end;
    const double last_angle = last * fit.turn_step;
    const Eigen::Vector2d direction(std::cos(last_angle), std::sin(last_angle));
    // A few points of a column tell its middle.
    constexpr std::size_t enough = 6;
    const std::size_t every = (end - begin) / enough + 1;
    off.clear();
    for (std::size_t i = begin; i < end; i += every) {
      Eigen::Vector3d position = to_sensor * vectorOf(cloud.positions[i]);
      if (fit.has_motion)
        position = fit.motion.stillPosition(position, timeOf(column, frame.width));
      if (position.x() != 0.0 || position.y() != 0.0)
        off.push_back(angleOff(position, direction, row_directions[cloud.rings[i]]));
    }
    if (!off.empty()) {
      // Columns of an odd cloud may turn without end.
      constexpr double most = 0x1p30;
      last = static_cast<std::int32_t>(
          std::clamp(last + std::round(quantileOf(off) / fit.turn_step), -most, most));
    }
    frame.rays.columns[column] = last;
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
