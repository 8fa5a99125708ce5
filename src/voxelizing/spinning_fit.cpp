// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/spinning_fit.h"

#include "voxelizing/column_angles.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Points nearer than this are on the sensor's own vehicle or case, metres. */
constexpr double nearest = 0.3;

/** \brief Motions are not followed with fewer points. */
constexpr std::size_t least_moving_points = 256;

/** \brief A motion is found with one of so many used columns first, as it has but a few
 * unknowns. */
constexpr std::uint32_t share_of_motion = 3;

constexpr int most_motion_rounds = 12;

/** \brief Steps towards a motion are not worth more time, metres. */
constexpr double least_motion = 1e-5;

/** \brief Steps of the angles that sensors send, degrees; the largest first. */
constexpr double turn_steps[] = {0.2, 0.1, 0.02, 0.01, 0.005};

/** \brief Points of the columns that are used, placed by a motion.
 * \param[in] share of them to use: each so many-th one
 */
std::vector<TurnPoint>
samplePoints(const std::vector<PixelPoint>& points,
             const SampledColumns& columns,
             std::uint32_t share,
             const TurnMotion& motion)
{
  const std::uint32_t every = share * columns.every;
  std::vector<TurnPoint> samples;
  for (const PixelPoint& point : points)
    if (point.column % every == 0 &&
        point.position.head<2>().squaredNorm() > nearest * nearest)
      samples.emplace_back(
          point, point.column / every, timeOf(point.column, columns.count), motion);
  return samples;
}

using PointsOfRow = std::vector<const TurnPoint*>;

std::vector<PointsOfRow>
pointsOfRows(const std::vector<TurnPoint>& samples, std::size_t row_count)
{
  std::vector<PointsOfRow> of_rows(row_count);
  for (const TurnPoint& point : samples)
    of_rows[point.row].push_back(&point);
  return of_rows;
}

/** \brief The height of a row's rays, as a line over the distance from the axis.
 * \param[in] points not empty
 */
void
fitHeights(const PointsOfRow& points, RowFit& row)
{
  std::vector<Eigen::Vector2d> features;
  std::vector<double> heights;
  for (const TurnPoint* point : points) {
    features.push_back({1.0, point->distance});
    heights.push_back(point->position.z());
  }
  double error = 0.0;
  const Eigen::Vector2d line = fitRobustly(features, heights, error);
  const double length = std::hypot(1.0, line[1]);
  row.up = line[0];
  row.run = 1.0 / length;
  row.rise = line[1] / length;
}

/** \brief The angle between neighbouring columns, radians. */
double
fitTurn(const std::vector<TurnPoint>& samples, std::uint32_t width)
{
  std::vector<double> slopes;
  for (std::size_t i = 1; i < samples.size(); ++i)
    if (samples[i].row == samples[i - 1].row &&
        samples[i].column == samples[i - 1].column + 1)
      slopes.push_back(wrapped(samples[i].azimuth - samples[i - 1].azimuth));
  if (slopes.empty())
    return 0.0;
  const double middle = quantileOf(slopes);
  // Most turn once.
  const double whole = std::copysign(two_pi / width, middle);
  return std::abs(middle - whole) < 0.1 * std::abs(whole) ? whole : middle;
}

/** \brief The angle of a row against even columns, and how far it is beside the axis.
 * \param[in] points not empty
 */
void
fitEvenAngle(const PointsOfRow& points, double turn, RowFit& row)
{
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> features;
  std::vector<double> angles;
  for (const TurnPoint* point : points) {
    features.push_back({1.0, 1.0 / point->distance});
    angles.push_back(point->azimuth - turn * point->column);
    sum += Eigen::Vector2d(std::cos(angles.back()), std::sin(angles.back()));
  }
  const double middle = std::atan2(sum.y(), sum.x());
  for (double& angle : angles)
    angle = std::remainder(angle - middle, two_pi);
  double error = 0.0;
  const Eigen::Vector2d fitted = fitRobustly(features, angles, error);
  row.angle = middle + fitted[0];
  row.across = fitted[1];
}

/** \brief Fits the rows of even columns; those with few points are as the nearest one.
 * \return false if all have few
 */
bool
fitEvenRows(const std::vector<TurnPoint>& samples, SpinningFit& fit)
{
  constexpr std::size_t fewest = 16;
  const std::vector<PointsOfRow> of_rows = pointsOfRows(samples, fit.rows.size());
  std::size_t last = fit.rows.size();
  for (std::size_t row = 0; row < fit.rows.size(); ++row) {
    if (of_rows[row].size() >= fewest) {
      fitHeights(of_rows[row], fit.rows[row]);
      fitEvenAngle(of_rows[row], fit.turn_step, fit.rows[row]);
      if (last == fit.rows.size())
        std::fill_n(fit.rows.begin(), row, fit.rows[row]);
      last = row;
    }
    else if (last != fit.rows.size())
      fit.rows[row] = fit.rows[last];
  }
  return last != fit.rows.size();
}

/** \brief Fits the angles of rows: those that all columns have in common. */
void
fitAngles(const std::vector<TurnPoint>& samples,
          std::vector<RowFit>& rows,
          ColumnAngles& columns)
{
  constexpr int most_rounds = 24;
  constexpr double least_change = 5e-7;
  double most = two_pi;
  double change = two_pi;
  for (int round = 0; round < most_rounds && change > least_change; ++round) {
    columns.turnColumns(samples, rows, most);
    most = 6.0 * columns.turnRows(samples, rows, change) + 1e-9;
  }
}

/** \brief The distance of the angles of columns, and moves those of rows to it. */
double
fitTurnStep(const std::vector<TurnPoint>& samples, std::vector<RowFit>& rows)
{
  for (const double degrees : turn_steps) {
    const double step = degrees * two_pi / 360.0;
    std::vector<double> angles;
    for (const TurnPoint& point : samples)
      if (point.distance > 1.0)
        angles.push_back(point.azimuth - rows[point.row].angle);
    double offset = 0.0;
    if (coherence(angles, step, offset) < 0.8)
      continue;
    for (RowFit& row : rows)
      row.angle += offset;
    return step;
  }
  return 0.0;
}

/** \brief The distance of depths, and moves the begin of each row to one. */
double
fitDepthStep(const std::vector<TurnPoint>& samples, std::vector<RowFit>& rows)
{
  std::vector<std::vector<double>> depths(rows.size());
  for (const TurnPoint& point : samples) {
    const RowFit& row = rows[point.row];
    depths[point.row].push_back(point.distance * row.run +
                                (point.position.z() - row.up) * row.rise);
  }
  std::vector<double> offsets(rows.size());
  const auto coherence_of = [&](double step, std::size_t every) {
    double sum = 0.0;
    double count = 1e-9;
    for (std::size_t i = 0; i < rows.size(); i += every) {
      const auto size = static_cast<double>(depths[i].size());
      sum += size * coherence(depths[i], step, offsets[i]);
      count += size;
    }
    return sum / count;
  };
  // A few rows tell that most steps are not those of the sensor.
  const std::size_t every = rows.size() / 16 + 1;
  constexpr double least_of_few = 0.8 * least_coherence;
  for (const double step : depth_steps) {
    if (coherence_of(step, every) < least_of_few ||
        coherence_of(step, 1) < least_coherence)
      continue;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].along += offsets[i] * rows[i].run;
      rows[i].up += offsets[i] * rows[i].rise;
    }
    return step;
  }
  return 0.0;
}

/** \brief Fits rows, columns and the motion of the sensor, in rounds until that stays.
 * \param[in] least_move smaller steps are the last ones, metres
 * \param[in,out] fit to begin with
 * \param[in,out] samples are placed by its motion
 */
void
fitMotion(std::vector<TurnPoint>& samples, double least_move, SpinningFit& fit)
{
  ColumnAngles columns(samples);
  columns.turnColumns(samples, fit.rows, two_pi);
  double moved_by = 1.0;
  for (int round = 0; round < most_motion_rounds && moved_by > least_move; ++round) {
    moved_by = improveMotion(samples, fit.rows, columns.angles(), fit.motion);
    fitHeights(samples, fit.rows);
    fitAngles(samples, fit.rows, columns);
  }
}

} // namespace

void
fitHeights(const std::vector<TurnPoint>& samples, std::vector<RowFit>& rows)
{
  constexpr std::size_t fewest = 8;
  const std::vector<PointsOfRow> of_rows = pointsOfRows(samples, rows.size());
  for (std::size_t row = 0; row < rows.size(); ++row)
    if (of_rows[row].size() >= fewest)
      fitHeights(of_rows[row], rows[row]);
}

std::size_t
pointsOfFittedRows(const std::vector<TurnPoint>& samples,
                   const std::vector<RowFit>& rows)
{
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(), [&rows](const TurnPoint& point) {
        return rows[point.row].run > 0.0;
      }));
}

double
medianHeightOff(const std::vector<TurnPoint>& samples, const std::vector<RowFit>& rows)
{
  std::vector<double> off;
  for (const TurnPoint& point : samples)
    off.push_back(heightOff(point, rows) / point.position.norm());
  return medianSize(off);
}

std::optional<SpinningFit>
fitSpinning(const std::vector<PixelPoint>& points,
            std::uint32_t row_count,
            const SampledColumns& sampled,
            double edge)
{
  std::vector<TurnPoint> samples = samplePoints(points, sampled, 1, TurnMotion());
  SpinningFit fit;
  fit.rows.resize(row_count);
  fitHeights(samples, fit.rows);
  if (2 * pointsOfFittedRows(samples, fit.rows) < samples.size() || samples.empty())
    return std::nullopt;
  ColumnAngles columns(samples);
  fitAngles(samples, fit.rows, columns);
  // Half of the points of a sensor that stands still are as near as this, radians.
  constexpr double most_off = 2e-5;
  const double still_off = medianHeightOff(samples, fit.rows);
  if (still_off > most_off) {
    SpinningFit moved = fit;
    std::vector<TurnPoint> few =
        samplePoints(points, sampled, share_of_motion, moved.motion);
    if (!few.empty())
      fitMotion(few, 10.0 * least_motion, moved);
    std::vector<TurnPoint> moved_samples =
        samplePoints(points, sampled, 1, moved.motion);
    fitMotion(moved_samples, least_motion, moved);
    if (medianHeightOff(moved_samples, moved.rows) < 0.7 * still_off) {
      fit = moved;
      fit.has_motion = true;
      samples.swap(moved_samples);
    }
  }
  fit.turn_step = fitTurnStep(samples, fit.rows);
  fit.has_turn_step = fit.turn_step > 0.0;
  if (!fit.has_turn_step) {
    double farthest = 1.0;
    for (const TurnPoint& point : samples)
      farthest = std::max(farthest, point.distance);
    fit.turn_step = std::max(edge / farthest, 1e-6);
  }
  fit.depth_step = fitDepthStep(samples, fit.rows);
  return fit;
}

std::optional<SpinningFit>
fitEvenSpinning(const std::vector<PixelPoint>& points,
                const ImageSize& size,
                const std::optional<double>& turn)
{
  std::vector<TurnPoint> samples;
  for (const PixelPoint& point : points)
    if (point.position.head<2>().squaredNorm() > 0.0)
      samples.emplace_back(point, point.column, 0.0, TurnMotion());
  SpinningFit fit;
  fit.rows.resize(size.height);
  fit.is_even = true;
  fit.turn_step = turn ? *turn : fitTurn(samples, size.width);
  if (!fitEvenRows(samples, fit))
    return std::nullopt;
  fit.depth_step = fitDepthStep(samples, fit.rows);
  return fit;
}

void
followMotion(const std::vector<PixelPoint>& points,
             const SampledColumns& sampled,
             SpinningFit& fit)
{
  if (!fit.has_motion)
    return;
  std::vector<TurnPoint> samples = samplePoints(points, sampled, 1, fit.motion);
  if (samples.size() < least_moving_points)
    return;
  ColumnAngles columns(samples);
  TurnMotion motion = fit.motion;
  double moved_by = 1.0;
  constexpr int most_rounds = 4;
  for (int round = 0; round < most_rounds && moved_by > least_motion; ++round) {
    columns.turnColumns(samples, fit.rows, two_pi);
    moved_by = improveMotion(samples, fit.rows, columns.angles(), motion);
    // Another motion takes bytes.
    if (round > 0 || moved_by > least_motion)
      fit.motion = motion;
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
