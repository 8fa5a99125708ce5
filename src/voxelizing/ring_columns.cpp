// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ring_columns.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Places azimuths in a turn from where the first point is on: where columns do
 * not fit a turn exactly they are displaced there.
 * \param[in,out] azimuths of points, radians
 * \return where the turn begins
 */
double
placeInTurn(const std::vector<PixelPoint>& points, std::vector<double>& azimuths)
{
  constexpr std::size_t samples = 64;
  constexpr double margin = 1e-3;
  const std::size_t every = points.size() / samples + 1;
  std::vector<double> sample;
  for (std::size_t i = 0; i < points.size(); i += sample.empty() ? 1 : every)
    if (!isAtSensor(points[i].position))
      sample.push_back(azimuths[i]);
  double sum = 0.0;
  for (std::size_t i = 1; i < sample.size(); ++i)
    sum += std::remainder(sample[i] - sample[i - 1], two_pi);
  const double first = sample.empty() ? 0.0 : sample.front();
  const double begin = sum >= 0.0 ? first - margin : first + margin - two_pi;
  for (double& azimuth : azimuths)
    azimuth -= std::floor((azimuth - begin) / two_pi) * two_pi;
  return begin;
}

} // namespace

double
RingColumns::step() const
{
  return two_pi / columns_of_turn_;
}

void
RingColumns::setPoints(const std::vector<PixelPoint>& points)
{
  azimuths_.clear();
  azimuths_.reserve(points.size());
  for (const PixelPoint& point : points)
    azimuths_.push_back(std::atan2(point.position.y(), point.position.x()));
  turn_begin_ = placeInTurn(points, azimuths_);
}

bool
RingColumns::fit(const std::vector<PixelPoint>& points,
                 std::uint32_t rows,
                 std::uint64_t most_pixels)
{
  count_ = 0;
  phases_.clear();
  fitted_likeness_ = 0.0;
  constexpr std::size_t least_points_of_row = 4;
  if (points.size() < least_points_of_row * rows)
    return false;
  const double about = findStep(points, rows);
  constexpr std::size_t enough = 4096;
  constexpr std::size_t enough_of_row = 64;
  if (about <= 0.0 ||
      !findColumns(
          sampleOf(points, std::max(enough, enough_of_row * rows)), rows, about))
    return false;
  const std::vector<RowAzimuth> sample =
      sampleOf(points, std::max(enough, 2 * enough_of_row * rows));
  const double whole = std::ceil(columns_of_turn_);
  count_ = static_cast<std::uint32_t>(whole) + (whole == columns_of_turn_ ? 0 : 1);
  if (std::uint64_t{count_} * rows > most_pixels)
    return false;
  first_column_ = std::floor(turn_begin_ / step());
  std::vector<std::complex<double>> sums(rows);
  for (const RowAzimuth& point : sample)
    sums[point.row] += std::polar(1.0, point.azimuth * columns_of_turn_);
  for (const std::complex<double>& sum : sums) {
    phases_.push_back(std::arg(sum) / columns_of_turn_);
    fitted_likeness_ += std::abs(sum) / static_cast<double>(sample.size());
  }
  return true;
}

/** \brief About some number of points, of all rows; none at the sensor. */
std::vector<RingColumns::RowAzimuth>
RingColumns::sampleOf(const std::vector<PixelPoint>& points, std::size_t enough) const
{
  std::vector<RowAzimuth> sample;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (isChosen(i, points.size(), enough) && !isAtSensor(points[i].position))
      sample.push_back({points[i].row, azimuths_[i]});
  return sample;
}

/** \brief Angle that most neighbours in a row are apart, radians; 0: there are none. */
double
RingColumns::findStep(const std::vector<PixelPoint>& points, std::uint32_t rows) const
{
  constexpr std::size_t enough = 16384;
  // Some rows may be without points.
  const std::size_t every = std::min<std::size_t>(points.size() / enough, rows / 4) + 1;
  std::vector<std::vector<double>> azimuths((rows + every - 1) / every);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].row % every == 0)
      azimuths[points[i].row / every].push_back(azimuths_[i]);
  return stepOfNeighbours(azimuths, two_pi / scan::most_side);
}

/** \brief Finds the number of columns of a turn, near that of a step, with which the
 * azimuths of each row are most alike, modulo a column.
 * \return false if they are not alike with any
 */
bool
RingColumns::findColumns(const std::vector<RowAzimuth>& sample,
                         std::uint32_t rows,
                         double step)
{
  constexpr double least_likeness = 0.3;
  const double about = two_pi / step;
  const double first = std::floor(0.94 * about);
  const double last = std::ceil(1.06 * about);
  if (sample.empty() || first < 2.0 || last >= scan::most_side)
    return false;
  double best = least_likeness;
  columns_of_turn_ = 0.0;
  using Direction = Eigen::Vector2d;
  std::vector<Direction> sums(rows);
  std::vector<Direction> current(sample.size());
  std::vector<Direction> increment(sample.size());
  const auto direction = [](double angle) {
    return Direction(std::cos(angle), std::sin(angle));
  };
  const auto search = [&](double from, double to, double distance) {
    for (std::size_t i = 0; i < sample.size(); ++i) {
      current[i] = direction(sample[i].azimuth * from);
      increment[i] = direction(sample[i].azimuth * distance);
    }
    for (double columns = from; columns <= to; columns += distance) {
      std::fill(sums.begin(), sums.end(), Direction::Zero());
      for (std::size_t i = 0; i < sample.size(); ++i) {
        const Direction& turn = increment[i];
        sums[sample[i].row] += current[i];
        current[i] = {current[i].x() * turn.x() - current[i].y() * turn.y(),
                      current[i].x() * turn.y() + current[i].y() * turn.x()};
      }
      double likeness = 0.0;
      for (const Direction& sum : sums)
        likeness += sum.norm() / static_cast<double>(sample.size());
      if (likeness > best) {
        best = likeness;
        columns_of_turn_ = columns;
      }
    }
  };
  search(first, last, 1.0);
  if (columns_of_turn_ == 0.0)
    return false;
  // Those of most sensors are whole numbers, some turn a little faster or slower.
  best *= 1.01;
  const double whole = columns_of_turn_;
  search(whole - 0.5, whole + 0.5, 1.0 / 64);
  return true;
}

bool
RingColumns::assign(std::vector<PixelPoint>& points, double& shift)
{
  std::complex<double> sum;
  constexpr std::size_t enough = 4096;
  const std::vector<RowAzimuth> sample = sampleOf(points, enough);
  for (const RowAzimuth& point : sample)
    sum += std::polar(1.0, (point.azimuth - phases_[point.row]) * columns_of_turn_);
  likeness_ =
      std::abs(sum) / static_cast<double>(std::max<std::size_t>(1, sample.size()));
  // Less than that is lost in the noise of the azimuths.
  constexpr double least_shift = 1.0 / 256;
  const double columns = std::arg(sum) / two_pi;
  shift = std::abs(columns) < least_shift ? 0.0 : columns * step();
  turns_ = 1;
  points_of_pixel_.assign(std::size_t{count_} * phases_.size(), 0);
  at_sensor_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (isAtSensor(points[i].position))
      at_sensor_.push_back(i);
    else if (!place(points[i],
                    (azimuths_[i] - phases_[points[i].row] - shift) / step() -
                        first_column_))
      return false;
  free_columns_.assign(phases_.size(), 0);
  return std::all_of(at_sensor_.begin(), at_sensor_.end(), [&](std::size_t i) {
    return placeAnywhere(points[i]);
  });
}

/** \brief Gives a point the column that is nearest, of the first turn that it is free in.
 * \param[in] column from the first one on
 * \return false if there is none
 */
bool
RingColumns::place(PixelPoint& point, double column)
{
  constexpr std::uint32_t most_turns = 4;
  if (!(std::abs(column) <= 2.0 * count_))
    return false;
  std::int64_t of_turn = std::llround(column);
  while (of_turn < 0)
    of_turn += count_;
  while (of_turn >= count_)
    of_turn -= count_;
  const auto nearest = static_cast<std::uint32_t>(of_turn);
  const std::uint32_t turn =
      points_of_pixel_[point.row * std::size_t{count_} + nearest]++;
  point.column = turn * count_ + nearest;
  turns_ = std::max(turns_, turn + 1);
  return turn < most_turns;
}

/** \brief Gives a point at the sensor a free column, as it has no azimuth. */
bool
RingColumns::placeAnywhere(PixelPoint& point)
{
  std::uint32_t& column = free_columns_[point.row];
  for (; column < turns_ * count_; ++column) {
    const std::uint32_t turn = column / count_;
    if (points_of_pixel_[point.row * std::size_t{count_} + column % count_] > turn)
      continue;
    point.column = column++;
    return true;
  }
  return false;
}

void
RingColumns::releaseMemory()
{
  azimuths_ = std::vector<double>();
  points_of_pixel_ = std::vector<std::uint8_t>();
  at_sensor_ = std::vector<std::size_t>();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
