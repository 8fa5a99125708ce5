#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/exceptions.h"
#include "stream/coordinate_step.h"
#include "stream/frame_warnings.h"
#include "voxelizing/field_collector.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/voxel_locator.h"
#include "voxelizing/voxelizer.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

/** \brief The settings, or the defaults if they are invalid, to construct members that
 * are then not used. */
EncoderSettings
usableSettings(const EncoderSettings& settings)
{
  return checkSettings(settings).ok() ? settings : EncoderSettings();
}

/** \brief Checks that a view of several points says where they are. */
CompressionStatus
checkView(const PointView& points)
{
  const auto invalid = [](const std::string& message) {
    return CompressionStatus(CompressionCode::InvalidInput, message);
  };
  if (points.count == 0)
    return {};
  const bool are_doubles = points.double_coordinates != nullptr;
  if (points.coordinates == nullptr && !are_doubles)
    return invalid("the view has points, but coordinates is null");
  const std::size_t number = are_doubles ? sizeof(double) : sizeof(float);
  if (points.count > 1 &&
      (points.coordinate_stride < 3 * number || points.coordinate_stride % number != 0))
    return invalid("coordinate_stride is " + std::to_string(points.coordinate_stride) +
                   "; it must be the bytes from one point to the next, a multiple of " +
                   std::to_string(number) + " of at least " +
                   std::to_string(3 * number));
  if (points.image.width > 0 && points.pixels == nullptr &&
      std::uint64_t{points.image.width} * points.image.height != points.count)
    return invalid("the image has " + std::to_string(points.image.width) + " x " +
                   std::to_string(points.image.height) + " pixels, but " +
                   std::to_string(points.count) + " points");
  for (const FieldView& field : points.fields)
    if (field.first == nullptr)
      return invalid("field '" + field.description.name + "' of the view is null");
  if (points.intensities != nullptr && points.intensity_stride % sizeof(float) != 0)
    return invalid("intensity_stride is " + std::to_string(points.intensity_stride) +
                   "; it must be a multiple of 4 bytes");
  return {};
}

/** \brief Voxels of a wide cloud are at most 2^4 times as wide as the settings say. */
constexpr unsigned int most_doublings = 4;

/** \brief How often a resolution has to be doubled until a grid may hold all points;
 * above most_doublings if that is not enough. */
unsigned int
doublingsForAll(PointBatches& points, double resolution)
{
  const CoordinateEnds ends = coordinateEnds(points);
  double width = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    width = std::max(width, ends.highest[axis] - ends.lowest[axis]);
  const double most_voxels = std::exp2(max_grid_depth) - 2.0;
  unsigned int doublings = 0;
  while (doublings <= most_doublings &&
         width > most_voxels * std::ldexp(resolution, static_cast<int>(doublings)))
    ++doublings;
  return doublings;
}

std::array<double, 3>
elementsOf(const Eigen::Vector3d& vector)
{
  return {vector.x(), vector.y(), vector.z()};
}

} // namespace

class CloudEncoder::Implementation {
public:
  Implementation(const EncoderSettings& settings,
                 IntensityUnit unit,
                 const std::optional<DepthLaw>& depth_law)
  : settings_(settings)
  , depth_law_(depth_law)
  , settings_status_(checkSettings(settings, depth_law))
  , unit_(unit)
  , voxelizer_(usableSettings(settings), unit)
  , fields_(usableSettings(settings))
  , encoder_(settings.format, settings.i_frame_rate, settings.effort)
  {
    if (settings.temporal_filter != 0)
      temporal_filter_.emplace(settings.temporal_filter);
  }

  const CompressionStatus&
  settingsStatus() const
  {
    return settings_status_;
  }

  const EncoderSettings&
  settings() const
  {
    return settings_;
  }

  const FrameStatistics&
  statistics() const
  {
    return statistics_;
  }

  void
  requestIFrame()
  {
    encoder_.requestIFrame();
  }

  void
  setResolution(double resolution, const std::optional<DepthLaw>& depth_law);

  CompressionStatus
  voxelize(PointBatches& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  CompressionStatus
  filterOverTime(VoxelFrame& frame);

  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

private:
  /** \brief What the temporal filter holds stays in the grid and the scale, which then
   * only grow. */
  bool
  mayRefit() const
  {
    return encoder_.isIFrameDue() && !temporal_filter_;
  }

  void
  refitIntensities(PointBatches& points, VoxelFrame& frame);

  CompressionStatus
  collectFields(PointBatches& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  std::uint64_t
  mostPixels(const VoxelFrame& frame) const;

  bool
  fitCoordinateStep(PointBatches& points);

  void
  voxelizeWide(PointBatches& points, VoxelFrame& frame);

  void
  voxelizeCoarsened(PointBatches& points, unsigned int doublings, VoxelFrame& frame);

  EncoderSettings settings_;
  std::optional<DepthLaw> depth_law_;
  CompressionStatus settings_status_;
  IntensityUnit unit_;
  Voxelizer voxelizer_;
  unsigned int doublings_ = 0;   // of the resolution of voxelizer_
  double coordinate_step_ = 0.0; // its resolution, metres, if above 0
  std::optional<TemporalVoxelFilter> temporal_filter_;
  std::array<double, 3> sensor_position_{}; // of the last voxelized frame
  FieldCollector fields_;
  ImageCollector image_;
  FrameEncoder encoder_;
  VoxelizationStatistics voxelization_; // of the last voxelized frame
  TemporalFilterStatus filtering_;      // likewise
  FrameStatistics statistics_;
};

void
CloudEncoder::Implementation::setResolution(double resolution,
                                            const std::optional<DepthLaw>& depth_law)
{
  EncoderSettings settings = settings_;
  settings.resolution = resolution;
  CompressionStatus status = checkSettings(settings, depth_law);
  // May throw, so it comes before the changes.
  Voxelizer voxelizer(usableSettings(settings), unit_);
  settings_ = settings;
  depth_law_ = depth_law;
  settings_status_ = std::move(status);
  encoder_.requestIFrame();
  if (settings_status_.ok()) {
    voxelizer_ = std::move(voxelizer);
    doublings_ = 0;
    coordinate_step_ = 0.0;
  }
}

CompressionStatus
CloudEncoder::Implementation::voxelize(PointBatches& points,
                                       const WorldPose& sensor_pose,
                                       VoxelFrame& frame)
{
  if (!settings_status_.ok()) {
    frame.clearVoxels();
    return settings_status_;
  }
  const auto voxelize = [&] {
    if (CompressionStatus status = fields_.select(points.fields()); !status.ok()) {
      frame.clearVoxels();
      return status;
    }
    if (fitCoordinateStep(points) || !settings_.coarsen_wide_clouds ||
        unit_ == IntensityUnit::Share)
      voxelization_ = voxelizer_.voxelize(points, mayRefit(), frame);
    else
      voxelizeWide(points, frame);
    refitIntensities(points, frame);
    sensor_position_ = elementsOf(sensor_pose.translation());
    if (CompressionStatus status = collectFields(points, sensor_pose, frame);
        !status.ok()) {
      frame.clearVoxels();
      return status;
    }
    frame.depth_model.reset();
    if (depth_law_ && settings_.format == StreamFormat::Version1 &&
        frame.hasIntensities())
      frame.depth_model = depthModelOf(*depth_law_,
                                       sensor_position_,
                                       elementsOf(sensor_pose.linear().col(2)),
                                       frame.grid,
                                       frame.intensity_scale);
    return CompressionStatus();
  };
  const auto voxelize_or_throw = [&] {
    return callOrCleanUp(voxelize, [&] {
      frame.clearVoxels(); // they may be those of the previous cloud
      encoder_.requestIFrame();
    });
  };
  return callOrNoMemory(voxelize_or_throw, outOfMemoryStatus<CompressionStatus>);
}

/** \brief Fits the scale of native intensities again if an earlier cloud had such high
 * ones that most of this cloud's become 0. */
void
CloudEncoder::Implementation::refitIntensities(PointBatches& points, VoxelFrame& frame)
{
  if (encoder_.isIFrameDue() ||
      2 * voxelization_.intensities_vanished <= voxelization_.voxels)
    return;
  // A high one of this cloud would give the same scale.
  const std::uint32_t highest =
      *std::max_element(frame.intensities.begin(), frame.intensities.end());
  if (highest > frame.intensity_scale.maxSymbol() / 2)
    return;
  encoder_.requestIFrame();
  voxelization_ = voxelizer_.voxelize(points, true, frame);
}

/** \brief How many pixels an image of a frame's points may have: where voxels have many
 * points, or pixels few, it would take more bytes than voxels. */
std::uint64_t
CloudEncoder::Implementation::mostPixels(const VoxelFrame& frame) const
{
  constexpr std::size_t most_points_of_voxel = 4;
  constexpr std::size_t most_pixels_of_point = 64;
  const std::size_t points = voxelization_.points_used;
  const DecoderLimits& limits = settings_.decoder_limits;
  const bool is_i_frame = encoder_.isIFrameDue();
  if (frame.keys.empty() || !frame.has_point_counts ||
      (is_i_frame ? points > most_points_of_voxel * frame.size()
                  : !encoder_.takesImages()))
    return 0;
  std::uint64_t most = std::min<std::uint64_t>(most_image_pixels, limits.max_points);
  if (const std::size_t values = fields_.valuesOfPoint(); values > 0)
    most = std::min<std::uint64_t>(most, limits.max_field_values / values);
  return is_i_frame ? std::min<std::uint64_t>(most, most_pixels_of_point * points)
                    : most;
}

/** \brief Sets fields and image of a voxelized frame, and from where fields are
 * predicted. */
CompressionStatus
CloudEncoder::Implementation::collectFields(PointBatches& points,
                                            const WorldPose& sensor_pose,
                                            VoxelFrame& frame)
{
  const std::uint64_t most_pixels = mostPixels(frame);
  const bool wants_image =
      most_pixels > 0 && image_.begin(points, sensor_pose, most_pixels);
  frame.image = PointImage();
  // A cloud without points has no other order than those before it.
  if (frame.keys.empty() && !encoder_.isIFrameDue() && encoder_.takesImages())
    frame.image = image_.rays();
  if (settings_.fields.empty() && !wants_image) {
    frame.fields.clear();
    return {};
  }
  EncoderSettings settings = settings_;
  settings.resolution = frame.grid.resolution;
  VoxelLocator locator(settings);
  if (!settings_.bounding_box)
    locator.setGrid(frame.grid);
  if (CompressionStatus status = fields_.collect(points,
                                                 locator,
                                                 wants_image ? &image_ : nullptr,
                                                 encoder_.isIFrameDue(),
                                                 frame);
      !status.ok())
    return status;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels =
        (sensor_position_[axis] - frame.grid.origin[axis]) / frame.grid.resolution -
        static_cast<double>(frame.grid.first_index[axis]);
    constexpr double far = farthest_viewpoint;
    frame.viewpoint[axis] =
        std::isfinite(voxels)
            ? static_cast<std::int32_t>(std::clamp(std::floor(voxels), -far, far))
            : 0;
  }
  return {};
}

/** \brief Centres voxels on the multiples of a step, if all coordinates of a cloud are
 * such multiples. The step is the resolution, or a larger one if that is asked for.
 * \return false if they are not
 */
bool
CloudEncoder::Implementation::fitCoordinateStep(PointBatches& points)
{
  if (unit_ == IntensityUnit::Share || settings_.format != StreamFormat::Version1 ||
      settings_.origin || settings_.bounding_box)
    return false;
  // Not changed to and fro, as a change takes an I-frame.
  const double largest = encoder_.isIFrameDue()
                             ? std::numeric_limits<double>::infinity()
                             : coordinate_step_;
  const double step = findCoordinateStep(
      points, settings_.resolution, settings_.use_coordinate_step, largest);
  if (!std::isnan(step) && step != coordinate_step_) {
    EncoderSettings settings = settings_;
    if (step > 0.0) {
      settings.resolution = step;
      settings.origin.emplace().fill(-step / 2.0);
    }
    voxelizer_ = Voxelizer(settings, unit_);
    coordinate_step_ = step;
    doublings_ = 0;
    encoder_.requestIFrame();
  }
  return coordinate_step_ > 0.0;
}

/** \brief Voxelizes with so few doublings that all points are on the grid, or, if some
 * are far out, all but a sixteenth; without doublings if there are none such. */
void
CloudEncoder::Implementation::voxelizeWide(PointBatches& points, VoxelFrame& frame)
{
  const bool is_i_frame_due = encoder_.isIFrameDue();
  if (doublings_ == 0) {
    voxelization_ = voxelizer_.voxelize(points, mayRefit(), frame);
    if (voxelization_.points_outside_grid == 0)
      return;
  }
  const unsigned int for_all = doublingsForAll(points, settings_.resolution);
  const auto are_many_outside = [&] {
    return 16 * voxelization_.points_outside_grid > voxelization_.points;
  };
  // A change takes an I-frame; without one that is due a factor of four is worth it.
  if (doublings_ > 0 && (is_i_frame_due || for_all + 2 <= doublings_))
    voxelizeCoarsened(points, for_all <= most_doublings ? for_all : 0, frame);
  else if (doublings_ > 0)
    voxelization_ = voxelizer_.voxelize(points, mayRefit(), frame);
  if (for_all <= most_doublings)
    for (unsigned int doublings = std::max(for_all, doublings_);
         voxelization_.points_outside_grid > 0 && doublings <= most_doublings;
         ++doublings)
      voxelizeCoarsened(points, doublings, frame);
  else
    while (are_many_outside() && doublings_ < most_doublings)
      voxelizeCoarsened(points, doublings_ + 1, frame);
  if (are_many_outside() && doublings_ > 0)
    voxelizeCoarsened(points, 0, frame);
}

/** \brief Voxelizes a cloud and the following ones with another edge. */
void
CloudEncoder::Implementation::voxelizeCoarsened(PointBatches& points,
                                                unsigned int doublings,
                                                VoxelFrame& frame)
{
  EncoderSettings settings = settings_;
  settings.resolution =
      std::min(std::ldexp(settings_.resolution, static_cast<int>(doublings)),
               largest_resolution);
  voxelizer_ = Voxelizer(settings, unit_);
  doublings_ = doublings;
  encoder_.requestIFrame();
  voxelization_ = voxelizer_.voxelize(points, true, frame);
}

CompressionStatus
CloudEncoder::Implementation::filterOverTime(VoxelFrame& frame)
{
  const auto filter = [&] {
    filtering_ = TemporalFilterStatus();
    if (temporal_filter_)
      filtering_ = temporal_filter_->filter(frame, sensor_position_);
    return filtering_.ok()
               ? CompressionStatus()
               : CompressionStatus(CompressionCode::InvalidInput, filtering_.message());
  };
  const auto filter_or_throw = [&] {
    return callOrCleanUp(filter, [&] {
      frame.clearVoxels();
      encoder_.requestIFrame();
    });
  };
  return callOrNoMemory(filter_or_throw, outOfMemoryStatus<CompressionStatus>);
}

CompressionStatus
CloudEncoder::Implementation::encode(const VoxelFrame& frame,
                                     const std::optional<FrameStamp>& stamp,
                                     std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  if (!settings_status_.ok())
    return settings_status_;
  CompressionStatus status = encoder_.encode(frame, stamp, bytes);
  if (!status.ok())
    return status;
  statistics_ = {
      voxelization_, encoder_.statistics(), filtering_.hidden, filtering_.held};
  // Without memory for it the frame goes out without the warning.
  return callOrElse(
      [&] {
        return CompressionStatus(CompressionCode::Ok,
                                 frameWarning(statistics_,
                                              settings_,
                                              unit_,
                                              doublings_ > 0,
                                              frame.fieldValueCount()));
      },
      [] { return CompressionStatus(); });
}

CloudEncoder::CloudEncoder(const EncoderSettings& settings,
                           IntensityUnit unit,
                           const std::optional<DepthLaw>& depth_law)
: implementation_(std::make_unique<Implementation>(settings, unit, depth_law))
{}

CloudEncoder::~CloudEncoder() = default;
CloudEncoder::CloudEncoder(CloudEncoder&&) noexcept = default;
CloudEncoder&
CloudEncoder::operator=(CloudEncoder&&) noexcept = default;

const CompressionStatus&
CloudEncoder::settingsStatus() const
{
  return implementation_->settingsStatus();
}

const EncoderSettings&
CloudEncoder::settings() const
{
  return implementation_->settings();
}

void
CloudEncoder::setResolution(double resolution, const std::optional<DepthLaw>& depth_law)
{
  implementation_->setResolution(resolution, depth_law);
}

void
CloudEncoder::requestIFrame()
{
  implementation_->requestIFrame();
}

CompressionStatus
CloudEncoder::voxelize(const PointView& points,
                       const WorldPose& sensor_pose,
                       VoxelFrame& frame,
                       std::size_t points_behind_sensor)
{
  if (CompressionStatus status = checkView(points); !status.ok()) {
    frame.clearVoxels();
    return status;
  }
  SingleBatch batch(points, points_behind_sensor);
  return implementation_->voxelize(batch, sensor_pose, frame);
}

CompressionStatus
CloudEncoder::voxelize(PointBatches& points,
                       const WorldPose& sensor_pose,
                       VoxelFrame& frame)
{
  return implementation_->voxelize(points, sensor_pose, frame);
}

CompressionStatus
CloudEncoder::filterOverTime(VoxelFrame& frame)
{
  return implementation_->filterOverTime(frame);
}

CompressionStatus
CloudEncoder::encode(const VoxelFrame& frame,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(frame, stamp, bytes);
}

const FrameStatistics&
CloudEncoder::statistics() const
{
  return implementation_->statistics();
}

} // namespace io
} // namespace pcl_ext
