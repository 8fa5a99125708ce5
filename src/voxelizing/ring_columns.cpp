#include "voxelizing/ring_columns.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace pcl_ext {
namespace io {

namespace {

bool
isAtSensor(const PixelPoint& point)
{
  return point.position.x() == 0.0 && point.position.y() == 0.0;
}

double
azimuthOf(const PixelPoint& point)
{
  return std::atan2(point.position.y(), point.position.x());
}

} // namespace

double
RingColumns::step() const
{
  return two_pi / count_;
}

bool
RingColumns::fit(const std::vector<PixelPoint>& points,
                 std::uint32_t rows,
                 std::uint64_t most_pixels)
{
  count_ = 0;
  phases_.clear();
  constexpr std::size_t least_points_of_row = 4;
  if (points.size() < least_points_of_row * rows)
    return false;
  const double step = findStep(points, rows);
  if (step <= 0.0 || !findCount(points, rows, step) ||
      std::uint64_t{count_} * rows > most_pixels) {
    count_ = 0;
    return false;
  }
  std::vector<std::complex<double>> sums(rows);
  for (const PixelPoint& point : points)
    if (!isAtSensor(point))
      sums[point.row] += std::polar(1.0, azimuthOf(point) * count_);
  phases_.clear();
  for (const std::complex<double>& sum : sums)
    phases_.push_back(std::arg(sum) / count_);
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
  constexpr double least_step = two_pi / most_image_side;
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

/** \brief Finds the number of columns near that of a step with which the azimuths of
 * each row are most alike, modulo a column.
 * \return false if they are not alike with any
 */
bool
RingColumns::findCount(const std::vector<PixelPoint>& points,
                       std::uint32_t rows,
                       double step)
{
  constexpr std::size_t enough = 16384;
  constexpr double least_likeness = 0.3;
  const double about = two_pi / step;
  const auto first = static_cast<std::uint32_t>(0.94 * about);
  const auto last = static_cast<std::uint32_t>(1.06 * about) + 1;
  if (first < 2 || last > most_image_side)
    return false;
  struct Turn {
    std::uint32_t row;
    std::complex<double> one;
    std::complex<double> current;
  };
  std::vector<Turn> sample;
  // Odd, so that no rows are left out.
  const std::size_t every = points.size() / enough | 1;
  for (std::size_t i = 0; i < points.size(); i += every) {
    if (isAtSensor(points[i]))
      continue;
    const double azimuth = azimuthOf(points[i]);
    sample.push_back(
        {points[i].row, std::polar(1.0, azimuth), std::polar(1.0, azimuth * first)});
  }
  double best = least_likeness * static_cast<double>(sample.size());
  std::vector<std::complex<double>> sums(rows);
  for (std::uint32_t count = first; count <= last; ++count) {
    std::fill(sums.begin(), sums.end(), 0.0);
    for (Turn& turn : sample) {
      sums[turn.row] += turn.current;
      turn.current *= turn.one;
    }
    double likeness = 0.0;
    for (const std::complex<double>& sum : sums)
      likeness += std::abs(sum);
    if (likeness > best) {
      best = likeness;
      count_ = count;
    }
  }
  return count_ > 0;
}

bool
RingColumns::assign(std::vector<PixelPoint>& points, double& shift)
{
  azimuths_.clear();
  std::complex<double> sum;
  for (const PixelPoint& point : points) {
    azimuths_.push_back(azimuthOf(point) - phases_[point.row]);
    if (!isAtSensor(point))
      sum += std::polar(1.0, azimuths_.back() * count_);
  }
  // Less than that is lost in the noise of the azimuths.
  constexpr double least_shift = 1.0 / 256;
  const double columns = std::arg(sum) / two_pi;
  shift = std::abs(columns) < least_shift ? 0.0 : columns * step();
  is_taken_.assign(std::size_t{count_} * phases_.size(), false);
  misplaced_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!place(points[i], (azimuths_[i] - shift) / step()))
      misplaced_.push_back(i);
  first_columns_.assign(phases_.size(), 0);
  return std::all_of(misplaced_.begin(), misplaced_.end(), [&](std::size_t i) {
    return placeAnywhere(points[i]);
  });
}

/** \brief Gives a point a column, or a free one that is near.
 * \param[in] column from straight ahead on
 * \return false if there is none, or the point is at the sensor
 */
bool
RingColumns::place(PixelPoint& point, double column)
{
  constexpr std::int64_t farthest = 64;
  const std::int64_t count = count_;
  if (isAtSensor(point) || !(std::abs(column) <= 2.0 * count_))
    return false;
  // The first column is behind the sensor.
  const std::int64_t nearest = std::llround(column) + count / 2;
  for (std::int64_t distance = 0; distance <= farthest; ++distance)
    for (const std::int64_t side : {nearest + distance, nearest - distance})
      if (take(point, static_cast<std::uint32_t>((side % count + count) % count)))
        return true;
  return false;
}

bool
RingColumns::placeAnywhere(PixelPoint& point)
{
  std::uint32_t& column = first_columns_[point.row];
  while (column < count_)
    if (take(point, column++))
      return true;
  return false;
}

bool
RingColumns::take(PixelPoint& point, std::uint32_t column)
{
  const std::size_t pixel = std::size_t{point.row} * count_ + column;
  if (is_taken_[pixel])
    return false;
  is_taken_[pixel] = true;
  point.column = column;
  return true;
}

void
RingColumns::releaseMemory()
{
  azimuths_ = std::vector<double>();
  is_taken_ = std::vector<bool>();
  misplaced_ = std::vector<std::size_t>();
}

} // namespace io
} // namespace pcl_ext
