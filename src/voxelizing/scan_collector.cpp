// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/scan_collector.h"

#include "codec/frame_limits.h"
#include "voxelizing/free_points.h"
#include "voxelizing/scan_locator.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint32_t no_point = ~std::uint32_t{0};

} // namespace

CompressionStatus
orderStatus(const std::string& reason)
{
  return {CompressionCode::InvalidInput,
          SettingText{"the order of a cloud cannot be kept: " + reason}};
}

ScanCollector::ScanCollector(const EncoderSettings& settings, IntensityUnit unit)
: settings_(settings), unit_(unit), quantiser_(settings, unit), grid_(settings)
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
  grid_.findStep(points, is_i_frame_due);
  if (!reader_.read(points, contents, cloud_)) {
    status = orderStatus("it has more than 65536 rows or columns, or 2^24 pixels");
    return false;
  }
  statistics = cloud_.statistics;
  statistics.resolution = grid_.grid().resolution;
  statistics.voxels = cloud_.size();
  if (cloud_.size() == 0 && !is_i_frame_due && has_layout_ && fitsLayout(scan))
    return true;
  if (cloud_.size() == 0 && (!settings_.keep_order || cloud_.image.width == 0))
    return false;
  has_layout_ = false; // until all is collected
  was_free_ = scan.rays.shape == scan::RayShape::Free;
  most_pixels_ = mostPixels(fields);
  if (is_i_frame_due)
    grid_.refine();
  bool is_located = false;
  do
    is_located = locateInGrid(sensor_pose, is_i_frame_due, scan);
  while (!is_located && is_i_frame_due && grid_.coarsen());
  if (!is_located) {
    const std::uint64_t pixels = std::max(cloud_.pixelCount(), cloud_.size());
    status =
        orderStatus(pixels > most_pixels_
                        ? "it has " + std::to_string(pixels) +
                              " places for points, a frame at most " +
                              std::to_string(most_pixels_) + ": leave {keep_order} out"
                        : "its points are 6.6e7 edges or more from each other, or 2^40 "
                          "from the origin of their coordinates: set {bounding_box} "
                          "around the points to keep, or take a larger {resolution}");
    if (is_i_frame_due)
      wants_other_rays_ = std::exchange(was_on_rays_, false);
    return false;
  }
  const bool is_on_rays = scan.rays.shape != scan::RayShape::Free;
  // Rays may be found as soon as there are points, or again after an odd cloud.
  wants_other_rays_ |= cloud_.size() == 0 || (was_on_rays_ && !is_on_rays);
  was_on_rays_ = is_on_rays;
  statistics.resolution = grid_.grid().resolution;
  statistics.intensities_out_of_range =
      setIntensities(is_i_frame_due, scan, statistics.intensities_vanished);
  constexpr unsigned int exact_bits = 8; // as all fields are
  scan.colour_bits = !contents.colours   ? 0
                     : fields.meansAll() ? exact_bits
                                         : settings_.colour_bits;
  setColours(scan);
  status = setFields(fields, scan);
  has_layout_ = status.ok();
  return true;
}

/** \brief Puts the points on rays, or else where they are. */
bool
ScanCollector::locateInGrid(const WorldPose& sensor_pose,
                            bool is_i_frame_due,
                            scan::ScanFrame& scan)
{
  if (!grid_.setAround(sensor_pose, cloud_))
    return false;
  scan.grid = grid_.grid();
  scan.is_on_lattice = grid_.hasStep();
  return locateOnRays(sensor_pose, is_i_frame_due, scan) ||
         locateFree(sensor_pose, is_i_frame_due, scan);
}

/** \brief Whether a cloud without points has the shape of a scan. */
bool
ScanCollector::fitsLayout(const scan::ScanFrame& scan) const
{
  const bool is_image = scan.order == scan::PointOrder::Organised;
  return cloud_.image.width > 0 ? is_image && cloud_.image.width == scan.width &&
                                      cloud_.image.height == scan.height
                                : !is_image;
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
ScanCollector::locateOnRays(const WorldPose& sensor_pose,
                            bool is_i_frame_due,
                            scan::ScanFrame& scan)
{
  // Without an I-frame there are none now if there were none before.
  if (cloud_.size() == 0 || (was_free_ && !is_i_frame_due))
    return false;
  // A few points tell nothing of many.
  if (untried_i_frames_ > 0 && cloud_.size() / 4 <= tried_points_) {
    untried_i_frames_ -= is_i_frame_due ? 1 : 0;
    return false;
  }
  const ImageSize size_of_cloud = cloud_.image;
  if (setLayout(sensor_pose, is_i_frame_due, scan) &&
      locate(sensor_pose, is_i_frame_due, scan)) {
    next_untried_ = 0;
    return true;
  }
  cloud_.image = size_of_cloud;
  tried_points_ = cloud_.size();
  // Looking for rays takes more time than a frame's coding.
  constexpr unsigned int most_untried = 15;
  if (is_i_frame_due)
    untried_i_frames_ =
        std::exchange(next_untried_, std::min(2 * next_untried_ + 1, most_untried));
  return false;
}

/** \brief Sets the size and the order of a scan, and orders the points. */
bool
ScanCollector::setLayout(const WorldPose& sensor_pose,
                         bool is_i_frame_due,
                         scan::ScanFrame& scan)
{
  scan.row_shifts.clear();
  const bool is_organised = cloud_.image.width > 0;
  const bool has_rings = !is_organised && ScanColumns::areRows(cloud_.rings);
  if (!is_organised &&
      !rows_.find(rays_.poseOf(sensor_pose).inverse(), is_i_frame_due, cloud_))
    return false;
  if (cloud_.image.width > 0) {
    scan.width = cloud_.image.width;
    scan.height = cloud_.image.height;
    scan.order =
        is_organised ? scan::PointOrder::Organised : scan::PointOrder::RowByRow;
    scan.firing_order.clear();
    if (scan.pixelCount() > most_pixels_)
      return false;
  }
  else {
    // Columns that are found by azimuths are those of the sensor's pose.
    if (has_rings && (is_i_frame_due ||
                      (scan.order == scan::PointOrder::RowByRow && rays_.haveMoved())))
      rays_.findPose(cloud_, sensor_pose);
    if (!columns_.find(cloud_,
                       rays_.poseOf(sensor_pose).inverse(),
                       is_i_frame_due,
                       most_pixels_,
                       scan))
      return false;
  }
  if (!orderPoints(scan))
    return false;
  // Row by row they come back in another order than that of the cloud.
  return !settings_.keep_order || scan.order != scan::PointOrder::RowByRow ||
         std::is_sorted(order_.begin(), order_.end());
}

/** \brief Puts the points where they are, without rays.
 * \return false also if an I-frame would be needed that is not due
 */
bool
ScanCollector::locateFree(const WorldPose& sensor_pose,
                          bool is_i_frame_due,
                          scan::ScanFrame& scan)
{
  if (!is_i_frame_due && !was_free_)
    return false;
  scan.firing_order.clear();
  scan.row_shifts.clear();
  scan.rays = scan::ScanRays();
  scan.rays.shape = scan::RayShape::Free;
  if (cloud_.image.width > 0) {
    scan.order = scan::PointOrder::Organised;
    scan.width = cloud_.image.width;
    scan.height = cloud_.image.height;
  }
  else {
    if (is_i_frame_due || !scan.isSequence())
      period_ = findPointPeriod(cloud_.positions, scan.grid.resolution);
    const auto count = static_cast<std::uint32_t>(cloud_.size());
    scan.order = scan::PointOrder::RowByRow;
    scan.width = period_ > 0 ? std::min(period_, count) : count;
    scan.height = (count + scan.width - 1) / scan.width;
    cloud_.pixels.resize(count);
    std::iota(cloud_.pixels.begin(), cloud_.pixels.end(), 0u);
  }
  if (scan.pixelCount() > most_pixels_ || !orderPoints(scan))
    return false;
  if (is_i_frame_due)
    phases_ = findPhases(cloud_.positions, scan.grid);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edges = (sensor_pose.translation()[static_cast<Eigen::Index>(axis)] -
                          scan.grid.lowerCorner(axis)) /
                         scan.grid.resolution;
    // The origin is in the voxel of the sensor, or else in the middle of the grid.
    constexpr double farthest = 0x1p24;
    const std::int64_t voxel = std::abs(edges) < farthest
                                   ? static_cast<std::int64_t>(std::floor(edges))
                                   : std::int64_t{1} << (max_grid_depth - 1);
    scan.rays.pose.origin[axis] =
        voxel * (1 << 16) + std::llround(0x1p16 * phases_[axis]);
  }
  return isConsistent(scan) && locateAll(scan);
}

/** \brief Puts all points on the rays of a scan, or where they are beside them. */
bool
ScanCollector::locateAll(scan::ScanFrame& scan) const
{
  const bool may_turn = scan.rays.shape == scan::RayShape::Spinning && rays_.mayTurn();
  return locateScan(
      {cloud_.positions, cloud_.pixels, order_, may_turn}, settings_.threads, scan);
}

/** \brief Puts the points in the order of their pixels.
 * \return false if some share one
 */
bool
ScanCollector::orderPoints(const scan::ScanFrame& scan)
{
  const std::vector<std::uint32_t>& pixels = cloud_.pixels;
  order_.resize(pixels.size());
  std::iota(order_.begin(), order_.end(), 0u);
  const auto is_not_below = [](std::uint32_t one, std::uint32_t next) {
    return one >= next;
  };
  if (std::adjacent_find(pixels.begin(), pixels.end(), is_not_below) == pixels.end())
    return true;
  by_pixel_.assign(scan.pixelCount(), no_point);
  for (std::uint32_t point = 0; point < pixels.size(); ++point) {
    if (by_pixel_[pixels[point]] != no_point)
      return false;
    by_pixel_[pixels[point]] = point;
  }
  order_.clear();
  for (const std::uint32_t point : by_pixel_)
    if (point != no_point)
      order_.push_back(point);
  return true;
}

/** \brief Puts the points on rays.
 * \param[in] refits find rays again if those of the clouds before do not fit as well
 * \return false if there are none, or, unless refits, those of before do not fit
 */
bool
ScanCollector::locate(const WorldPose& sensor_pose, bool refits, scan::ScanFrame& scan)
{
  const auto append_all = [&] {
    scan.width = scan.rayColumns();
    scan.row_shifts.clear();
    return rays_.areOf(scan) && rays_.set(cloud_, columns_, sensor_pose, scan) &&
           isConsistent(scan) && locateAll(scan);
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
    // Those of a camera may be anywhere in each frame; of others less is not worth an
    // I-frame.
    const double far = 1.5 * fitted_share_ + (rays_.arePlanar() ? 0.02 : 0.2);
    double share = share_beside();
    bool are_located = true;
    if (share > far && !refits && rays_.followPose(cloud_, sensor_pose)) {
      are_located = append_all();
      share = share_beside();
    }
    if (are_located &&
        (refits ? !has_many_more && share <= growth * fitted_share_ + least_growth
                : share <= far))
      return true;
  }
  if (!refits && !rays_.arePlanar())
    return false;
  if (!rays_.fit(cloud_, columns_, sensor_pose, scan.grid, refits, scan) ||
      !append_all())
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
  order_ = std::vector<std::uint32_t>();
  by_pixel_ = std::vector<std::uint32_t>();
  symbols_ = VoxelFrame();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
