// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/turn_motion.h"

#include "voxelizing/robust_fit.h"

#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

double
heightOff(const TurnPoint& point, const std::vector<RowFit>& rows)
{
  const RowFit& row = rows[point.row];
  return (point.position.z() - row.up) * row.run - point.distance * row.rise;
}

double
angleOff(const TurnPoint& point,
         const std::vector<RowFit>& rows,
         const std::vector<double>& columns)
{
  return wrapped(point.azimuth - rows[point.row].angle - columns[point.column]);
}

namespace {

/** \brief Numbers of a motion that are found: velocity, spin about x and y, shift along x
 * and y. What else there is, columns and rows take. */
constexpr int unknown_count = 7;
using Equation = Eigen::Matrix<double, unknown_count + 1, 1>; // and what it is off
using Square = Eigen::Matrix<double, unknown_count + 1, unknown_count + 1>;

/** \brief How a point's distance from its rays changes with the motion, along a direction
 * in which it is measured. */
Equation
equationOf(const TurnPoint& point, const Eigen::Vector3d& direction, double off)
{
  const Eigen::Vector3d turned = point.position.cross(direction) * point.time;
  Equation equation;
  equation << direction * point.time, turned.head<2>(), direction.head<2>(), off;
  return equation;
}

/** \brief Takes from equations what the height and the slope of their rows explain. */
void
removeRows(const std::vector<TurnPoint>& points,
           std::size_t row_count,
           const std::vector<bool>& is_used,
           std::vector<Equation>& equations)
{
  std::vector<Eigen::Matrix2d> squares(row_count, Eigen::Matrix2d::Zero());
  std::vector<Eigen::Matrix<double, 2, unknown_count + 1>> products(
      row_count, Eigen::Matrix<double, 2, unknown_count + 1>::Zero());
  const auto features = [&](std::size_t i) {
    const double range = points[i].position.norm();
    return Eigen::Vector2d(1.0 / range, points[i].distance / range);
  };
  for (std::size_t i = 0; i < points.size(); ++i)
    if (is_used[i]) {
      squares[points[i].row] += features(i) * features(i).transpose();
      products[points[i].row] += features(i) * equations[i].transpose();
    }
  for (std::size_t row = 0; row < row_count; ++row)
    products[row] = solveLeastSquares(squares[row], products[row]);
  for (std::size_t i = 0; i < points.size(); ++i)
    equations[i] -= products[points[i].row].transpose() * features(i);
}

/** \brief Takes from equations the means of groups.
 * \param[in] group_of called with a sample
 */
template <class GroupT>
void
removeMeans(const std::vector<TurnPoint>& points,
            std::size_t group_count,
            const std::vector<bool>& is_used,
            std::vector<Equation>& equations,
            const GroupT& group_of)
{
  std::vector<Equation> sums(group_count, Equation::Zero());
  std::vector<double> counts(group_count, 1e-9);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (is_used[i]) {
      sums[group_of(points[i])] += equations[i];
      counts[group_of(points[i])] += 1.0;
    }
  for (std::size_t i = 0; i < points.size(); ++i)
    equations[i] -= sums[group_of(points[i])] / counts[group_of(points[i])];
}

/** \brief Which values are at most some times as large as their median. */
std::vector<bool>
areNear(std::vector<double> values, double times)
{
  std::vector<double> sizes = values;
  const double most = times * medianSize(sizes) + 1e-12;
  std::vector<bool> are(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    are[i] = std::abs(values[i]) <= most;
  return are;
}

Square
sumOfSquares(const std::vector<Equation>& equations, const std::vector<bool>& is_used)
{
  Square sum = Square::Zero();
  for (std::size_t i = 0; i < equations.size(); ++i)
    if (is_used[i])
      sum += equations[i] * equations[i].transpose();
  return sum;
}

/** \brief Equations of how far points are above the rays of their rows. */
Square
squaresOfHeights(const std::vector<TurnPoint>& points, const std::vector<RowFit>& rows)
{
  std::vector<Equation> equations;
  std::vector<double> off;
  equations.reserve(points.size());
  off.reserve(points.size());
  for (const TurnPoint& point : points) {
    const RowFit& row = rows[point.row];
    const double x = point.position.x() / point.distance;
    const double y = point.position.y() / point.distance;
    const double range = point.position.norm();
    off.push_back(heightOff(point, rows) / range);
    equations.push_back(
        equationOf(point,
                   Eigen::Vector3d(-row.rise * x, -row.rise * y, row.run) / range,
                   off.back()));
  }
  const std::vector<bool> is_used = areNear(off, 4.0);
  removeRows(points, rows.size(), is_used, equations);
  return sumOfSquares(equations, is_used);
}

/** \brief Equations of the angles of points against those of their columns and rows. */
Square
squaresOfAngles(const std::vector<TurnPoint>& points,
                const std::vector<RowFit>& rows,
                const std::vector<double>& columns)
{
  std::vector<Equation> equations;
  std::vector<double> off;
  equations.reserve(points.size());
  off.reserve(points.size());
  for (const TurnPoint& point : points) {
    const double x = point.position.x() / point.distance;
    const double y = point.position.y() / point.distance;
    off.push_back(angleOff(point, rows, columns));
    equations.push_back(
        equationOf(point, Eigen::Vector3d(-y, x, 0.0) / point.distance, off.back()));
  }
  const std::vector<bool> is_used = areNear(off, 5.0);
  for (int sweep = 0; sweep < 4; ++sweep) {
    removeMeans(points, columns.size(), is_used, equations, [](const TurnPoint& point) {
      return point.column;
    });
    removeMeans(points, rows.size(), is_used, equations, [](const TurnPoint& point) {
      return point.row;
    });
  }
  return sumOfSquares(equations, is_used);
}

} // namespace

double
improveMotion(std::vector<TurnPoint>& points,
              const std::vector<RowFit>& rows,
              const std::vector<double>& columns,
              TurnMotion& motion)
{
  Square sum = squaresOfHeights(points, rows);
  if (!columns.empty())
    sum += squaresOfAngles(points, rows, columns);
  const Eigen::Matrix<double, unknown_count, 1> step =
      solveLeastSquares(sum.topLeftCorner<unknown_count, unknown_count>(),
                        sum.topRightCorner<unknown_count, 1>());
  motion.velocity += step.head<3>();
  motion.spin.head<2>() += step.segment<2>(3);
  motion.shift.head<2>() += step.tail<2>();
  for (TurnPoint& point : points)
    point.place(motion);
  constexpr double far = 10.0; // metres
  return step.head<3>().norm() + step.tail<2>().norm() +
         far * step.segment<2>(3).norm();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
