// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/spinning_pose.h"

#include "voxelizing/robust_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using Terms = Eigen::Matrix<double, Eigen::Dynamic, 5>;
using Coefficients = Eigen::Matrix<double, 5, 1>;

/** \brief Nearer to the axis points have no angle, metres. */
constexpr double least_distance = 0.1;

constexpr double infinity = std::numeric_limits<double>::infinity();

/** \brief Some points of the rows that have enough, row after row, without those at a
 * place. */
std::vector<PixelPoint>
usefulPoints(const std::vector<PixelPoint>& points, const Eigen::Vector3d& place)
{
  constexpr std::size_t enough = 2048;
  constexpr std::size_t least_points_of_row = 12;
  std::vector<PixelPoint> there;
  for (const PixelPoint& point : points)
    if (point.position != place)
      there.push_back(point);
  std::vector<std::vector<PixelPoint>> rows;
  for (std::size_t i = 0; i < there.size(); ++i)
    if (isChosen(i, there.size(), enough)) {
      rows.resize(std::max<std::size_t>(rows.size(), there[i].row + 1));
      rows[there[i].row].push_back(there[i]);
    }
  std::vector<PixelPoint> useful;
  for (const std::vector<PixelPoint>& row : rows)
    if (row.size() >= least_points_of_row)
      useful.insert(useful.end(), row.begin(), row.end());
  return useful;
}

/** \brief The points of a row in the equation of its surface: (axis * p)^2 - p * p / 3,
 * whose coefficients all rows have in common, is a sum of the other terms. */
struct RowTerms {
  Terms common;
  Terms others; // p * p, p and 1
  Eigen::VectorXd weights;
  Eigen::Matrix<double, 5, 5> solution; // of the common terms from the others
  Terms errors;                         // of this

  template <typename PointT>
  RowTerms(PointT point, PointT end, const Extent& extent)
  : common(end - point, 5)
  , others(end - point, 5)
  , weights(Eigen::VectorXd::Ones(end - point))
  {
    for (Eigen::Index row = 0; point != end; ++row, ++point) {
      // Numbers about 1, as the equations are of squares.
      const Eigen::Vector3d p =
          (point->position - extent.middle) / std::max(extent.mean_distance, 1e-9);
      common.row(row) << p.x() * p.x() - p.z() * p.z(), p.y() * p.y() - p.z() * p.z(),
          2.0 * p.x() * p.y(), 2.0 * p.x() * p.z(), 2.0 * p.y() * p.z();
      others.row(row) << p.squaredNorm(), p.transpose(), 1.0;
    }
  }

  void
  solve()
  {
    constexpr double threshold = 1e-9; // rows may be flat
    solution = solveLeastSquares(
        weights.asDiagonal() * others, weights.asDiagonal() * common, threshold);
    errors = common - others * solution;
  }
};

/** \brief The coefficients of the common terms: those with the smallest errors. */
Coefficients
fitSurfaces(std::vector<RowTerms>& rows)
{
  Coefficients common;
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix<double, 5, 5> squares = Eigen::Matrix<double, 5, 5>::Zero();
    for (RowTerms& row : rows) {
      row.solve();
      squares += row.errors.transpose() * row.weights.asDiagonal() * row.errors;
    }
    common = SymmetricEigen(squares).vectors.col(0);
    std::vector<double> errors;
    for (const RowTerms& row : rows)
      for (Eigen::Index i = 0; i < row.errors.rows(); ++i)
        errors.push_back(finiteOrLargest(row.errors.row(i).dot(common)));
    const double most = 4.0 * medianSize(errors);
    for (RowTerms& row : rows)
      row.weights = ((row.errors * common).array().abs() <= most).cast<double>();
  }
  return common;
}

/** \brief The axis of surfaces, and where it is: sensor -> points, but for the height. */
WorldPose
poseOf(const Coefficients& common, const std::vector<RowTerms>& rows)
{
  Eigen::Matrix3d form;
  form << common[0], common[2], common[3], common[2], common[1], common[4], common[3],
      common[4], -common[0] - common[1];
  const SymmetricEigen eigen(form);
  const Eigen::Vector3d values = eigen.values;
  const int side = values[1] - values[0] > values[2] - values[1] ? 0 : 2;
  Eigen::Vector3d axis = eigen.vectors.col(side);
  axis *= axis.z() < 0.0 ? -1.0 : 1.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0.0;
  for (const RowTerms& row : rows) {
    const Coefficients others = row.solution * common / (1.5 * values[side]);
    const double of_square = others[0] + 1.0 / 3.0; // the sine's
    sum -= 0.5 * row.weights.sum() * of_square * others.segment<3>(1);
    weight += row.weights.sum() * of_square * of_square;
  }
  WorldPose pose = WorldPose::Identity();
  const Eigen::Vector3d turn = Eigen::Vector3d::UnitZ().cross(axis);
  pose.linear() = Eigen::Quaterniond(1.0 + axis.z(), turn.x(), turn.y(), turn.z())
                      .normalized()
                      .matrix();
  pose.translation() = (sum - axis * axis.dot(sum)) / weight;
  return pose;
}

/** \brief A pose from the equations of the rows' surfaces.
 * \param[in] points row after row
 * \return sensor -> points, but for the height; or not finite numbers
 */
WorldPose
solvePose(const std::vector<PixelPoint>& points, const Extent& extent)
{
  std::vector<RowTerms> terms;
  for (auto begin = points.begin(), end = begin; begin != points.end(); begin = end) {
    const std::uint32_t row = begin->row;
    end = std::find_if(
        begin, points.end(), [row](const PixelPoint& next) { return next.row != row; });
    terms.emplace_back(begin, end, extent);
  }
  WorldPose pose = poseOf(fitSurfaces(terms), terms);
  // Farther away they are not rays of a sensor.
  constexpr double most_extents = 100.0;
  if (!(pose.translation().norm() < most_extents))
    pose.translation().setConstant(infinity);
  pose.translation() = extent.middle + extent.mean_distance * pose.translation();
  return pose;
}

/** \brief Rays of rows as they are seen from a pose. */
struct SeenRows {
  std::vector<TurnPoint> points; // of unknown columns
  std::vector<RowFit> rows;
  double off = infinity; // half of the points are nearer to their rays, radians

  SeenRows(const std::vector<PixelPoint>& from, const WorldPose& pose)
  {
    constexpr std::size_t least_points = 64;
    const WorldPose to_sensor = pose.inverse();
    for (const PixelPoint& point : from) {
      const PixelPoint seen{point.row, 0, to_sensor * point.position};
      rows.resize(std::max<std::size_t>(rows.size(), point.row + 1));
      if (const double distance = seen.position.head<2>().norm();
          distance > least_distance && std::isfinite(distance))
        points.emplace_back(seen, 0, 1.0, TurnMotion());
    }
    if (points.size() < least_points)
      return;
    fitHeights(points, rows);
    if (10 * pointsOfFittedRows(points, rows) < 9 * points.size())
      return;
    off = medianHeightOff(points, rows);
  }

  /** \brief What moves the pose towards one from which the points are nearer. */
  WorldPose
  improvement()
  {
    TurnMotion motion; // at time 1
    improveMotion(points, rows, {}, motion);
    WorldPose pose = WorldPose::Identity();
    pose.translate(motion.shift + motion.velocity);
    pose.rotate(Eigen::AngleAxisd(motion.spin.norm(), motion.spin.normalized()));
    return pose;
  }

  /** \brief How high a level row would begin above the sensor, metres. */
  double
  levelHeight() const
  {
    std::vector<Eigen::Vector2d> features;
    std::vector<double> heights;
    for (const RowFit& row : rows)
      if (row.run > 0.0) {
        features.push_back({1.0, row.rise / row.run});
        heights.push_back(row.up);
      }
    double error = 0.0;
    return fitRobustly(features, heights, error)[0];
  }
};

} // namespace

Eigen::Vector3d
repeatedPlace(const std::vector<PixelPoint>& points)
{
  Eigen::Vector3d place;
  place.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].position == points[i - 1].position)
      place = points[i].position;
  return place;
}

std::optional<WorldPose>
findSpinningPose(const std::vector<PixelPoint>& points, const Eigen::Vector3d& place)
{
  const std::vector<PixelPoint> useful = usefulPoints(points, place);
  // Half of the points of a sensor that is where it was told are as near as this, radians.
  constexpr double most_off = 2e-5;
  const Extent extent(useful);
  // From far away angles are small; they are compared as from among the points.
  const double told_off = SeenRows(useful, WorldPose::Identity()).off *
                          std::max(1.0, extent.middle.norm() / extent.mean_distance);
  if (useful.empty() || told_off <= most_off)
    return std::nullopt;
  WorldPose pose = solvePose(useful, extent);
  SeenRows seen(useful, pose);
  constexpr double least_off = 1e-6; // radians
  for (int round = 0; round < 4 && seen.off < infinity && seen.off > least_off;
       ++round) {
    const WorldPose better = pose * seen.improvement();
    SeenRows seen_better(useful, better);
    if (!(seen_better.off < seen.off))
      break;
    pose = better;
    seen = seen_better;
  }
  if (!(seen.off < 0.3 * told_off) || seen.off == infinity)
    return std::nullopt;
  pose.translate(seen.levelHeight() * Eigen::Vector3d::UnitZ());
  // Missing points are at the sensor's origin, anywhere on the axis, which was found from
  // points that may be a little beside their rays.
  constexpr double near = 0.002;
  constexpr double size_of_sensor = 0.5;
  const Eigen::Vector3d missing = pose.inverse() * place;
  if (missing.head<2>().norm() < near && std::abs(missing.z()) < size_of_sensor)
    pose.translation() = place;
  return pose;
}

WorldPose
turnedToColumns(const WorldPose& pose,
                const std::vector<PixelPoint>& points,
                const SpinningFit& fit)
{
  const double step = fit.is_even ? two_pi : fit.has_turn_step ? fit.turn_step : 0.0;
  if (step == 0.0)
    return pose;
  const WorldPose to_sensor = pose.inverse();
  std::vector<double> angles;
  for (const PixelPoint& point : points) {
    const Eigen::Vector3d seen = to_sensor * point.position;
    const double distance = seen.head<2>().norm();
    const RowFit& row = fit.rows[point.row];
    if (distance > least_distance)
      angles.push_back(std::atan2(seen.y(), seen.x()) - row.angle -
                       row.across / distance -
                       (fit.is_even ? fit.turn_step * point.column : 0.0));
  }
  double turn = 0.0;
  coherence(angles, step, turn);
  WorldPose turned = pose;
  turned.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  return turned;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
