// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ring_columns.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace pcl_ext {
namespace io {

namespace {

double
azimuthOf(const PixelPoint& point)
{
  return std::atan2(point.position.y(), point.position.x());
}

/** \brief Azimuths of a cloud's points, a turn from where the first point is on: where
 * columns do not fit a turn exactly they are displaced there. */
class Turn {
public:
  explicit Turn(const std::vector<PixelPoint>& points)
  {
    constexpr std::size_t samples = 64;
    constexpr double margin = 1e-3;
    const std::size_t every = points.size() / samples + 1;
    std::vector<double> azimuths;
    for (std::size_t i = 0; i < points.size(); i += azimuths.empty() ? 1 : every)
      if (!isAtSensor(points[i]))
        azimuths.push_back(azimuthOf(points[i]));
    double sum = 0.0;
    for (std::size_t i = 1; i < azimuths.size(); ++i)
      sum += std::remainder(azimuths[i] - azimuths[i - 1], two_pi);
    const double begin = azimuths.empty() ? 0.0 : azimuths.front();
    begin_ = sum >= 0.0 ? begin - margin : begin + margin - two_pi;
  }

  double
  operator()(const PixelPoint& point) const
  {
    const double turns = std::floor((azimuthOf(point) - begin_) / two_pi);
    return azimuthOf(point) - turns * two_pi;
  }

  double
  begin() const
  {
    return begin_;
  }

private:
  double begin_;
};

} // namespace

double
RingColumns::step() const
{
  return two_pi / columns_of_turn_;
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
  if (about <= 0.0 || !findColumns(points, rows, about))
    return false;
  const double whole = std::ceil(columns_of_turn_);
  count_ = static_cast<std::uint32_t>(whole) + (whole == columns_of_turn_ ? 0 : 1);
  if (std::uint64_t{count_} * rows > most_pixels)
    return false;
  const Turn azimuth(points);
  first_column_ = std::floor(azimuth.begin() / step());
  std::vector<std::complex<double>> sums(rows);
  for (const PixelPoint& point : points)
    if (!isAtSensor(point))
      sums[point.row] += std::polar(1.0, azimuth(point) * columns_of_turn_);
  for (const std::complex<double>& sum : sums) {
    phases_.push_back(std::arg(sum) / columns_of_turn_);
    fitted_likeness_ += std::abs(sum) / static_cast<double>(points.size());
  }
  return true;
}

/** \brief Angle that most neighbours in a row are apart, radians; 0: there are none. */
double
RingColumns::findStep(const std::vector<PixelPoint>& points, std::uint32_t rows)
{
  std::vector<std::vector<double>> azimuths(rows);
  for (const PixelPoint& point : points)
    azimuths[point.row].push_back(azimuthOf(point));
  // Two echoes in a direction are not apart.
  constexpr double least_step = two_pi / scan::most_side;
  std::vector<double> steps;
  for (std::vector<double>& row : azimuths) {
    std::sort(row.begin(), row.end());
    for (std::size_t i = 1; i < row.size(); ++i)
      if (row[i] - row[i - 1] > least_step)
        steps.push_back(row[i] - row[i - 1]);
  }
  if (steps.empty())
    return 0.0;
  // Missing points leave larger steps.
  const auto low = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
  std::nth_element(steps.begin(), low, steps.end());
  return *low;
}

/** \brief Finds the number of columns of a turn, near that of a step, with which the
 * azimuths of each row are most alike, modulo a column.
 * \return false if they are not alike with any
 */
bool
RingColumns::findColumns(const std::vector<PixelPoint>& points,
                         std::uint32_t rows,
                         double step)
{
  constexpr std::size_t enough = 16384;
  constexpr double least_likeness = 0.3;
  const double about = two_pi / step;
  const double first = std::floor(0.94 * about);
  const double last = std::ceil(1.06 * about);
  if (first < 2.0 || last >= scan::most_side)
    return false;
  std::vector<std::uint32_t> sample_rows;
  std::vector<double> sample;
  const Turn azimuth(points);
  // Odd, so that no rows are left out.
  const std::size_t every = points.size() / enough | 1;
  for (std::size_t i = 0; i < points.size(); i += every)
    if (!isAtSensor(points[i])) {
      sample_rows.push_back(points[i].row);
      sample.push_back(azimuth(points[i]));
    }
  double best = least_likeness * static_cast<double>(sample.size());
  columns_of_turn_ = 0.0;
  std::vector<std::complex<double>> sums(rows);
  std::vector<std::complex<double>> current(sample.size());
  std::vector<std::complex<double>> increment(sample.size());
  const auto search = [&](double from, double to, double distance) {
    for (std::size_t i = 0; i < sample.size(); ++i) {
      current[i] = std::polar(1.0, sample[i] * from);
      increment[i] = std::polar(1.0, sample[i] * distance);
    }
    for (double columns = from; columns <= to; columns += distance) {
      std::fill(sums.begin(), sums.end(), 0.0);
      for (std::size_t i = 0; i < sample.size(); ++i) {
        sums[sample_rows[i]] += current[i];
        current[i] *= increment[i];
      }
      double likeness = 0.0;
      for (const std::complex<double>& sum : sums)
        likeness += std::abs(sum);
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
  azimuths_.clear();
  const Turn azimuth(points);
  std::complex<double> sum;
  for (const PixelPoint& point : points) {
    azimuths_.push_back(azimuth(point) - phases_[point.row]);
    if (!isAtSensor(point))
      sum += std::polar(1.0, azimuths_.back() * columns_of_turn_);
  }
  likeness_ = std::abs(sum) / static_cast<double>(points.size());
  // Less than that is lost in the noise of the azimuths.
  constexpr double least_shift = 1.0 / 256;
  const double columns = std::arg(sum) / two_pi;
  shift = std::abs(columns) < least_shift ? 0.0 : columns * step();
  turns_ = 1;
  points_of_pixel_.assign(std::size_t{count_} * phases_.size(), 0);
  at_sensor_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (isAtSensor(points[i]))
      at_sensor_.push_back(i);
    else if (!place(points[i], (azimuths_[i] - shift) / step() - first_column_))
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
  const std::int64_t count = count_;
  if (!(std::abs(column) <= 2.0 * count_))
    return false;
  const auto nearest =
      static_cast<std::uint32_t>((std::llround(column) % count + count) % count);
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

} // namespace io
} // namespace pcl_ext
