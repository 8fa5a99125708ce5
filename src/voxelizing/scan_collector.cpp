// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/scan_collector.h"

#include "codec/frame_limits.h"
#include "platforms/run_at_once.h"
#include "voxelizing/coordinate_step.h"
#include "voxelizing/point_period.h"
#include "voxelizing/robust_fit.h"
#include "voxelizing/scan_locator.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint32_t no_point = ~std::uint32_t{0};

/** \brief Places are nearer to the origin of a lattice, edges. */
constexpr double farthest_steps = 0x1p40;

/** \brief How far a place is from another one on the axis where it is farthest, edges. */
double
farthestAxis(const std::array<double, 3>& one,
             const std::array<double, 3>& other,
             double edge)
{
  double farthest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    farthest = std::max(farthest, std::abs(one[axis] - other[axis]) / edge);
  return farthest;
}

/** \brief Appends points to those of a scan. */
void
appendPoints(const scan::ScanFrame& points, scan::ScanFrame& scan)
{
  if (!points.turns.empty())
    scan.turns.resize(scan.pixels.size());
  scan.turns.insert(scan.turns.end(), points.turns.begin(), points.turns.end());
  scan.pixels.insert(scan.pixels.end(), points.pixels.begin(), points.pixels.end());
  scan.depths.insert(scan.depths.end(), points.depths.begin(), points.depths.end());
  scan.beside.insert(scan.beside.end(), points.beside.begin(), points.beside.end());
  if (!scan.turns.empty())
    scan.turns.resize(scan.pixels.size());
}

/** \brief The grid around a place, or around the origin of its lattice if that is near.
 * \return none if the place is too far away
 */
std::optional<VoxelGrid>
gridAround(const std::array<double, 3>& place,
           double resolution,
           const std::array<double, 3>& origin)
{
  constexpr double near = 0x1p19;
  const double distance = farthestAxis(place, origin, resolution);
  if (!(distance < farthest_steps))
    return std::nullopt;
  VoxelGrid grid;
  grid.resolution = resolution;
  grid.origin = origin;
  grid.depth = max_grid_depth;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.first_index[axis] = -(1 << (max_grid_depth - 1));
    if (distance >= near)
      grid.origin[axis] +=
          resolution * std::round((place[axis] - origin[axis]) / resolution);
  }
  return grid;
}

} // namespace

CompressionStatus
orderStatus(const char* reason)
{
  return {CompressionCode::InvalidInput,
          std::string("the order of a cloud cannot be kept: ") + reason};
}

ScanCollector::ScanCollector(const EncoderSettings& settings, IntensityUnit unit)
: settings_(settings), unit_(unit), quantiser_(settings, unit)
{}

bool
ScanCollector::isPossible(const EncoderSettings& settings, IntensityUnit unit)
{
  return settings.format == StreamFormat::Version1 && settings.keepsPoints() &&
         (unit == IntensityUnit::None ||
          (unit == IntensityUnit::Native && settings.aggregation != Aggregation::Sum));
}

bool
ScanCollector::collect(PointBatches& points,
                       const FieldCollector& fields,
                       const WorldPose& sensor_pose,
                       bool is_i_frame_due,
                       scan::ScanFrame& scan,
                       VoxelizationStatistics& statistics,
                       CompressionStatus& status)
{
  scan.clearPoints();
  status = CompressionStatus();
  wants_other_rays_ = false;
  SensorCloudReader::Contents contents;
  contents.intensities = unit_ != IntensityUnit::None;
  contents.colours = settings_.colour_bits > 0 && points.hasColours();
  contents.box = settings_.bounding_box;
  contents.fields = &fields;
  if (!sensor_pose.matrix().allFinite())
    return false;
  // Before the points are read, as who reads them last counts them.
  setCoordinateStep(points, is_i_frame_due);
  if (!reader_.read(points, contents, cloud_)) {
    status = orderStatus("it has more than 65536 rows or columns, or 2^24 pixels");
    return false;
  }
  statistics = cloud_.statistics;
  statistics.resolution = grid_.resolution;
  statistics.voxels = cloud_.size();
  if (cloud_.size() == 0 && !is_i_frame_due) // on the rays of the last one
    return scan.width > 0 &&
           (scan.order != scan::PointOrder::Organised ||
            (cloud_.image.width == scan.width && cloud_.image.height == scan.height));
  if (cloud_.size() == 0 && (!settings_.keep_order || cloud_.image.width == 0))
    return false;
  if (!setGrid(sensor_pose)) {
    status = orderStatus("it is too far from the origin of its coordinates");
    return false;
  }
  scan.grid = grid_;
  scan.is_on_lattice = coordinate_step_ > 0.0;
  was_free_ = scan.rays.shape == scan::RayShape::Free;
  if (!locateOnRays(fields, sensor_pose, is_i_frame_due, scan) &&
      !locateFree(fields, sensor_pose, is_i_frame_due, scan)) {
    const bool has_many =
        std::max(cloud_.pixelCount(), cloud_.size()) > mostPixels(fields);
    status =
        orderStatus(has_many ? "it has more pixels than decoders take"
                             : "its points are 2^26 edges or more from each other, "
                               "which a larger resolution mends");
    return false;
  }
  // Rays may be found as soon as there are points.
  wants_other_rays_ |= cloud_.size() == 0;
  statistics.resolution = grid_.resolution;
  statistics.intensities_out_of_range =
      setIntensities(is_i_frame_due, scan, statistics.intensities_vanished);
  constexpr unsigned int exact_bits = 8; // as all fields are
  scan.colour_bits = !contents.colours   ? 0
                     : fields.meansAll() ? exact_bits
                                         : settings_.colour_bits;
  setColours(scan);
  status = setFields(fields, scan);
  return true;
}

/** \brief How many pixels a scan of the cloud may have: where they are many for the
 * points, it would take more bytes than voxels. */
std::uint64_t
ScanCollector::mostPixels(const FieldCollector& fields) const
{
  constexpr std::size_t most_pixels_of_point = 64;
  // A scan takes a byte for four points, or more.
  const FrameLimits limits = frameLimits(settings_.decoder_limits, cloud_.size() / 4);
  std::uint64_t most = std::min<std::uint64_t>(scan::most_pixels, limits.max_points);
  if (!settings_.keep_order)
    most = std::min<std::uint64_t>(most, most_pixels_of_point * cloud_.size());
  if (fields.valuesOfPoint() > 0)
    most =
        std::min<std::uint64_t>(most, limits.max_field_values / fields.valuesOfPoint());
  return most;
}

/** \brief Puts the points on rays, if they have rows and columns and there are rays. */
bool
ScanCollector::locateOnRays(const FieldCollector& fields,
                            const WorldPose& sensor_pose,
                            bool is_i_frame_due,
                            scan::ScanFrame& scan)
{
  // Without an I-frame there are none now if there were none before.
  if (cloud_.size() == 0 || (was_free_ && !is_i_frame_due))
    return false;
  if (untried_i_frames_ > 0) {
    untried_i_frames_ -= is_i_frame_due ? 1 : 0;
    return false;
  }
  if (setLayout(fields, sensor_pose, is_i_frame_due, scan) &&
      locate(sensor_pose, is_i_frame_due || !rays_.areOf(scan), scan)) {
    last_untried_ = 0;
    return true;
  }
  // Looking for rays takes more time than a frame's coding.
  constexpr unsigned int most_untried = 15;
  if (is_i_frame_due)
    untried_i_frames_ = last_untried_ = std::min(2 * last_untried_ + 1, most_untried);
  return false;
}

/** \brief Sets the size and the order of a scan, and orders the points. */
bool
ScanCollector::setLayout(const FieldCollector& fields,
                         const WorldPose& sensor_pose,
                         bool is_i_frame_due,
                         scan::ScanFrame& scan)
{
  const std::uint64_t most_pixels = mostPixels(fields);
  if (cloud_.image.width > 0) {
    scan.width = cloud_.image.width;
    scan.height = cloud_.image.height;
    scan.order = scan::PointOrder::Organised;
    scan.firing_order.clear();
    scan.row_shifts.clear();
    if (scan.pixelCount() > most_pixels)
      return false;
    pixels_.assign(cloud_.pixels.begin(), cloud_.pixels.end());
  }
  else {
    if (!ScanColumns::areRows(cloud_.rings) && !findRings(sensor_pose, is_i_frame_due))
      return false;
    if (!columns_.find(
            cloud_, sensor_pose.inverse(), is_i_frame_due, most_pixels, scan))
      return false;
    scan.row_shifts.clear();
    pixels_.resize(cloud_.size());
    for (std::size_t point = 0; point < cloud_.size(); ++point)
      pixels_[point] = cloud_.rings[point] * scan.width + columns_.columns()[point];
  }
  if (!orderPoints(scan))
    return false;
  // Row by row they come back in another order than that of the cloud.
  return !settings_.keep_order || scan.order != scan::PointOrder::RowByRow ||
         std::is_sorted(order_.begin(), order_.end());
}

/** \brief Puts the points where they are, without rays.
 * \return false also if an I-frame would be needed that is not due: it may take more
 * bytes than voxels
 */
bool
ScanCollector::locateFree(const FieldCollector& fields,
                          const WorldPose& sensor_pose,
                          bool is_i_frame_due,
                          scan::ScanFrame& scan)
{
  if (!is_i_frame_due && !was_free_ && !settings_.keep_order)
    return false;
  scan.firing_order.clear();
  scan.row_shifts.clear();
  scan.rays = scan::ScanRays();
  scan.rays.shape = scan::RayShape::Free;
  if (cloud_.image.width > 0) {
    scan.order = scan::PointOrder::Organised;
    scan.width = cloud_.image.width;
    scan.height = cloud_.image.height;
    pixels_.assign(cloud_.pixels.begin(), cloud_.pixels.end());
  }
  else {
    if (is_i_frame_due || !scan.isSequence())
      period_ = findPointPeriod(cloud_.positions, grid_.resolution);
    const auto count = static_cast<std::uint32_t>(cloud_.size());
    scan.order = scan::PointOrder::RowByRow;
    scan.width = period_ > 0 ? std::min(period_, count) : count;
    scan.height = (count + scan.width - 1) / scan.width;
    pixels_.resize(count);
    std::iota(pixels_.begin(), pixels_.end(), 0u);
  }
  if (scan.pixelCount() > mostPixels(fields) || !orderPoints(scan))
    return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edges = (sensor_pose.translation()[static_cast<Eigen::Index>(axis)] -
                          grid_.lowerCorner(axis)) /
                         grid_.resolution;
    // The origin is the sensor, or else the middle of the grid.
    constexpr double farthest = 0x1p24;
    const bool is_near = std::abs(edges) < farthest;
    scan.rays.pose.origin[axis] = is_near
                                      ? std::llround(edges * 0x1p16)
                                      : std::int64_t{1} << (max_grid_depth - 1 + 16);
  }
  return isConsistent(scan) && appendAll(scan);
}

/** \brief Appends all points to a scan whose rays are given. */
bool
ScanCollector::appendAll(scan::ScanFrame& scan)
{
  scan.pixels.clear();
  scan.depths.clear();
  scan.turns.clear();
  scan.beside.clear();
  scan.pixels.reserve(order_.size());
  scan.depths.reserve(order_.size());
  const std::size_t count = order_.size();
  const std::size_t parts =
      std::min<std::size_t>(settings_.threads, count / least_points_per_part);
  if (parts < 2)
    return append(0, count, scan);
  std::vector<scan::ScanFrame> others(parts - 1, scan);
  std::atomic<bool> are_all_near{true};
  runAtOnce(parts, [&](std::size_t i) {
    scan::ScanFrame& part = i == 0 ? scan : others[i - 1];
    if (!append(count * i / parts, count * (i + 1) / parts, part))
      are_all_near = false;
  });
  for (const scan::ScanFrame& other : others)
    appendPoints(other, scan);
  return are_all_near;
}

/** \brief Appends some of the points, in their order. */
bool
ScanCollector::append(std::size_t first, std::size_t last, scan::ScanFrame& scan) const
{
  const bool is_spinning = scan.rays.shape == scan::RayShape::Spinning;
  ScanLocator locator(scan, is_spinning && rays_.mayTurn());
  // Rows are not wide, but sequences may be one.
  constexpr std::size_t points_at_once = 4096;
  const std::uint32_t width = scan.rayColumns();
  std::vector<std::uint32_t> row_columns;
  for (std::size_t begin = first; begin < last; begin += row_columns.size()) {
    const std::uint32_t row = pixels_[order_[begin]] / width;
    const std::uint32_t row_begin = row * width;
    const std::size_t end = std::min(last, begin + points_at_once);
    row_columns.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t column = pixels_[order_[i]] - row_begin;
      if (column >= width)
        break;
      row_columns.push_back(column);
    }
    if (!locator.append(row, row_columns, cloud_.positions, &order_[begin]))
      return false;
  }
  return true;
}

/** \brief Finds the rings of a cloud without any, from the elevations of its points. */
bool
ScanCollector::findRings(const WorldPose& sensor_pose, bool is_i_frame_due)
{
  // Most such clouds have no rings, and looking for them takes time.
  constexpr unsigned int untried_clouds = 15;
  if (untried_clouds_ > 0) {
    --untried_clouds_;
    return false;
  }
  const WorldPose to_sensor = sensor_pose.inverse();
  const auto in_sensor = [&to_sensor](const std::array<double, 3>& position) {
    return to_sensor * Eigen::Vector3d(position[0], position[1], position[2]);
  };
  if (is_i_frame_due || elevations_.count() == 0) {
    constexpr std::size_t enough = 16384;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t point = 0; point < cloud_.size(); ++point)
      if (isChosen(point, cloud_.size(), enough))
        points.emplace_back(in_sensor(cloud_.positions[point]));
    if (!elevations_.learn(points)) {
      untried_clouds_ = untried_clouds;
      return false;
    }
  }
  cloud_.rings.resize(cloud_.size());
  for (std::size_t point = 0; point < cloud_.size(); ++point)
    cloud_.rings[point] = elevations_.nextRow(in_sensor(cloud_.positions[point]));
  return true;
}

/** \brief Puts the points in the order of their pixels.
 * \return false if some share one
 */
bool
ScanCollector::orderPoints(const scan::ScanFrame& scan)
{
  order_.resize(pixels_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  const auto is_not_below = [](std::uint32_t one, std::uint32_t next) {
    return one >= next;
  };
  if (std::adjacent_find(pixels_.begin(), pixels_.end(), is_not_below) == pixels_.end())
    return true;
  by_pixel_.assign(scan.pixelCount(), no_point);
  for (std::uint32_t point = 0; point < pixels_.size(); ++point) {
    if (by_pixel_[pixels_[point]] != no_point)
      return false;
    by_pixel_[pixels_[point]] = point;
  }
  order_.clear();
  for (const std::uint32_t point : by_pixel_)
    if (point != no_point)
      order_.push_back(point);
  return true;
}

/** \brief Finds the step that coordinates are multiples of. */
void
ScanCollector::setCoordinateStep(PointBatches& points, bool is_i_frame_due)
{
  if (!settings_.origin && !settings_.bounding_box) {
    // Not changed to and fro, as a change takes an I-frame.
    const double largest =
        is_i_frame_due ? std::numeric_limits<double>::infinity() : coordinate_step_;
    const double step =
        findCoordinateStep(points, settings_.resolution, true, largest, farthest_steps);
    if (!std::isnan(step))
      coordinate_step_ = step;
  }
}

/** \brief Sets the grid: centred on the multiples of a step if coordinates are such, else
 * that of the settings, or the lattice of the origin.
 * \return false if the points are too far away
 */
bool
ScanCollector::setGrid(const WorldPose& sensor_pose)
{
  const double edge = coordinate_step_ > 0.0 ? coordinate_step_ : settings_.resolution;
  std::array<double, 3> origin = settings_.origin.value_or(VoxelGrid().origin);
  if (!settings_.origin && coordinate_step_ > 0.0)
    origin.fill(-edge / 2.0);
  // Around the sensor, unless points are in other coordinates.
  constexpr double farthest = 0x1p24;
  std::array<double, 3> place;
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[axis] = sensor_pose.translation()[static_cast<Eigen::Index>(axis)];
  double near = 0x1p19;
  if (cloud_.size() > 0 &&
      !(farthestAxis(place, cloud_.positions.front(), edge) < farthest)) {
    place = cloud_.positions.front();
    near = farthest; // any point may be the first one
  }
  if (grid_.resolution == edge && lattice_origin_ == origin &&
      farthestAxis(place, grid_.origin, edge) < near)
    return true;
  const std::optional<VoxelGrid> grid = gridAround(place, edge, origin);
  if (grid)
    grid_ = *grid;
  lattice_origin_ = origin;
  return grid.has_value();
}

/** \brief Puts the points on rays.
 * \param[in] refits find rays again if those of the clouds before do not fit as well
 */
bool
ScanCollector::locate(const WorldPose& sensor_pose, bool refits, scan::ScanFrame& scan)
{
  const auto append_all = [&] {
    scan.width = scan.rayColumns();
    scan.row_shifts.clear();
    return rays_.areOf(scan) && rays_.set(cloud_, columns_, sensor_pose, scan) &&
           isConsistent(scan) && appendAll(scan);
  };
  const auto share_beside = [&] {
    const auto turned = static_cast<std::ptrdiff_t>(scan.turns.size()) -
                        std::count(scan.turns.begin(), scan.turns.end(), 0);
    return (static_cast<double>(scan.beside.size()) + static_cast<double>(turned)) /
           static_cast<double>(scan.pixels.size());
  };
  constexpr double growth = 1.1;
  constexpr double least_growth = 0.01;
  const bool has_many_more = cloud_.size() > 2 * fitted_points_;
  if (append_all()) {
    const double share = share_beside();
    if (!refits || (!has_many_more && share <= growth * fitted_share_ + least_growth)) {
      // Less than that is not worth an I-frame.
      wants_other_rays_ = share > 1.5 * fitted_share_ + 0.2;
      return true;
    }
  }
  if (!rays_.fit(cloud_, columns_, sensor_pose, grid_, scan) || !append_all())
    return false;
  fitted_share_ = share_beside();
  fitted_points_ = cloud_.size();
  return true;
}

/** \brief Sets the intensities of all points.
 * \return how many are clamped to an end of the scale
 */
std::size_t
ScanCollector::setIntensities(bool may_refit,
                              scan::ScanFrame& scan,
                              std::size_t& vanished)
{
  scan.intensity_scale = IntensityScale();
  scan.intensity_scale.bits = 0;
  if (unit_ == IntensityUnit::None)
    return 0;
  const std::size_t clamped = quantiser_.quantise(
      cloud_.intensities, cloud_.intensity_step, may_refit, symbols_, vanished);
  scan.intensity_scale = symbols_.intensity_scale;
  scan.intensities.reserve(order_.size());
  for (const std::uint32_t point : order_)
    scan.intensities.push_back(symbols_.intensities[point]);
  return clamped;
}

/** \brief Sets the colours of all points, in 2^colour_bits - 1 steps from 0 to 255. */
void
ScanCollector::setColours(scan::ScanFrame& scan) const
{
  if (scan.colour_bits == 0)
    return;
  const unsigned int highest = (1u << scan.colour_bits) - 1;
  const auto quantised = [highest](std::uint32_t channel) {
    return static_cast<std::uint8_t>((2 * (channel & 255) * highest + 255) / 510);
  };
  scan.colours.reserve(order_.size());
  for (const std::uint32_t point : order_) {
    const std::uint32_t colour = cloud_.colours[point];
    scan.colours.push_back(
        {quantised(colour >> 16), quantised(colour >> 8), quantised(colour)});
  }
}

CompressionStatus
ScanCollector::setFields(const FieldCollector& fields, scan::ScanFrame& scan) const
{
  scan.fields.resize(fields.selected().size());
  for (std::size_t i = 0; i < scan.fields.size(); ++i) {
    FrameField& field = scan.fields[i];
    static_cast<FieldDescription&>(field) = fields.selected()[i].description;
    field.numbers.reserve(order_.size() * field.count);
    for (const std::uint32_t point : order_)
      for (std::size_t k = 0; k < field.count; ++k)
        field.numbers.push_back(cloud_.numbers[i][point * field.count + k]);
    if (CompressionStatus status = checkNumbers(field); !status.ok())
      return status;
  }
  return {};
}

void
ScanCollector::releaseMemory()
{
  cloud_ = SensorCloud();
  columns_.releaseMemory();
  quantiser_.releaseMemory();
  pixels_ = std::vector<std::uint32_t>();
  order_ = std::vector<std::uint32_t>();
  by_pixel_ = std::vector<std::uint32_t>();
  symbols_ = VoxelFrame();
}

} // namespace io
} // namespace pcl_ext
