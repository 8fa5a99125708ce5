// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/exceptions.h"
#include "codec/frame_limits.h"
#include "outliers/frame_motion.h"
#include "stream/cloud_voxelizer.h"
#include "stream/frame_warnings.h"
#include "voxelizing/field_collector.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/voxel_locator.h"
#include "voxels/memory_rule.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
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

std::optional<TemporalVoxelFilter>
temporalFilterOf(const EncoderSettings& settings)
{
  std::optional<TemporalVoxelFilter> filter;
  if (settings.temporal_filter != 0)
    filter.emplace(settings.temporal_filter, settings.temporal_filter_holds);
  return filter;
}

/** \brief Whether RateControl may turn the temporal filter on. */
bool
mayFilterLater(const EncoderSettings& settings)
{
  return settings.max_rate > 0.0 && settings.rate_temporal_filter != 0 &&
         !settings.keep_point_counts && settings.fields.empty();
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
  , encoder_(settings.format,
             settings.i_frame_rate,
             settings.effort,
             settings.first_frame_number)
  {
    temporal_filter_ = temporalFilterOf(settings);
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

  bool
  isIFrameDue() const
  {
    return encoder_.isIFrameDue();
  }

  void
  dropLastFrame()
  {
    encoder_.dropLastFrame();
  }

  void
  setSettings(const EncoderSettings& settings,
              const std::optional<DepthLaw>& depth_law);

  CompressionStatus
  voxelize(PointBatches& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  void
  seeBeyond(PointBatches& points, const BoundingBox& box, const WorldPose& sensor_pose);

  CompressionStatus
  filterOverTime(VoxelFrame& frame,
                 const std::optional<std::chrono::nanoseconds>& time);

  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

private:
  CompressionStatus
  collectFields(PointBatches& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  std::uint64_t
  mostPixels(const VoxelFrame& frame) const;

  LimitedCounts
  limitedCounts(const VoxelFrame& frame);

  EncoderSettings settings_;
  std::optional<DepthLaw> depth_law_;
  CompressionStatus settings_status_;
  IntensityUnit unit_;
  CloudVoxelizer voxelizer_;
  std::optional<TemporalVoxelFilter> temporal_filter_;
  bool sees_beyond_ = false;                // seeBeyond() was called for the next cloud
  FrameMotion motion_;                      // without a temporal filter
  std::array<double, 3> sensor_position_{}; // of the last voxelized frame
  FieldCollector fields_;
  ImageCollector image_;
  MemoryRule memory_rule_; // of both
  FrameEncoder encoder_;
  std::uint64_t bytes_since_i_frame_ = 0; // payloads, with that of the I-frame
  VoxelizationStatistics voxelization_;   // of the last voxelized frame
  TemporalFilterStatus filtering_;        // likewise
  FrameStatistics statistics_;
};

void
CloudEncoder::Implementation::setSettings(const EncoderSettings& settings,
                                          const std::optional<DepthLaw>& depth_law)
{
  EncoderSettings changed = settings_;
  changed.resolution = settings.resolution;
  changed.origin = settings.origin;
  changed.use_coordinate_step = settings.use_coordinate_step;
  changed.effort = settings.effort;
  changed.temporal_filter = settings.temporal_filter;
  changed.temporal_filter_holds = settings.temporal_filter_holds;
  changed.intensity_curve = settings.intensity_curve;
  changed.intensity_bits = settings.intensity_bits;
  const bool keeps_voxels =
      changed.resolution == settings_.resolution &&
      changed.origin == settings_.origin &&
      changed.use_coordinate_step == settings_.use_coordinate_step &&
      changed.intensity_curve == settings_.intensity_curve &&
      changed.intensity_bits == settings_.intensity_bits;
  CompressionStatus status = checkSettings(changed, depth_law);
  // May throw, so it comes before the changes.
  CloudVoxelizer voxelizer(usableSettings(changed), unit_);
  if (status.ok() && (changed.temporal_filter != settings_.temporal_filter ||
                      changed.temporal_filter_holds != settings_.temporal_filter_holds))
    temporal_filter_ = temporalFilterOf(changed);
  settings_ = std::move(changed);
  depth_law_ = depth_law;
  settings_status_ = std::move(status);
  if (settings_status_.ok())
    encoder_.setEffort(settings_.effort);
  if (keeps_voxels)
    return;
  encoder_.requestIFrame();
  if (settings_status_.ok())
    voxelizer_ = std::move(voxelizer);
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
    // What the temporal filter holds stays in the grid and the scale, which then only
    // grow.
    voxelization_ =
        voxelizer_.voxelize(points, encoder_.isIFrameDue(), !temporal_filter_, frame);
    if (voxelizer_.isIFrameDue())
      encoder_.requestIFrame();
    sensor_position_ = elementsOf(sensor_pose.translation());
    if (settings_.bounding_box && !sees_beyond_)
      seeBeyond(points, *settings_.bounding_box, sensor_pose);
    sees_beyond_ = false;
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

/** \brief How many pixels an image of a frame's points may have: where voxels have many
 * points, or pixels few, it would take more bytes than voxels. */
std::uint64_t
CloudEncoder::Implementation::mostPixels(const VoxelFrame& frame) const
{
  constexpr std::size_t most_points_of_voxel = 4;
  constexpr std::size_t most_pixels_of_point = 64;
  if (frame.keys.empty() || !frame.has_point_counts || !encoder_.takesImages())
    return 0;
  // Without missing points, which are all in the same voxel.
  const std::size_t points =
      voxelization_.points_used -
      *std::max_element(frame.point_counts.begin(), frame.point_counts.end());
  // An image takes a byte for four points, or more.
  const FrameLimits limits = frameLimits(settings_.decoder_limits, points / 4);
  const bool is_i_frame = encoder_.isIFrameDue();
  const std::size_t values = fields_.valuesOfPoint();
  // Fields are those of pixels, whatever the voxels.
  const bool has_many = values == 0 && points > most_points_of_voxel * frame.size();
  if (is_i_frame && has_many)
    return 0;
  std::uint64_t most = std::min<std::uint64_t>(most_image_pixels, limits.max_points);
  if (values > 0)
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
  const bool collects = wants_image || !settings_.fields.empty();
  if (memory_rule_.shouldRelease(collects ? 64 * voxelization_.points_used : 0)) {
    fields_.releaseMemory();
    image_.releaseMemory();
  }
  frame.image = PointImage();
  // A cloud without points has no other order than those before it.
  if (frame.keys.empty() && !encoder_.isIFrameDue() && encoder_.takesImages())
    frame.image = image_.rays();
  if (!collects) {
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

void
CloudEncoder::Implementation::seeBeyond(PointBatches& points,
                                        const BoundingBox& box,
                                        const WorldPose& sensor_pose)
{
  const std::array<double, 3> position = elementsOf(sensor_pose.translation());
  if (!temporal_filter_ || !sensor_pose.translation().allFinite())
    return;
  temporal_filter_->seeBeyond(points, box, position);
  sees_beyond_ = true;
}

CompressionStatus
CloudEncoder::Implementation::filterOverTime(
    VoxelFrame& frame, const std::optional<std::chrono::nanoseconds>& time)
{
  const auto filter = [&] {
    filtering_ = TemporalFilterStatus();
    if (temporal_filter_)
      filtering_ = temporal_filter_->filter(frame, {sensor_position_, time});
    else if (mayFilterLater(settings_))
      filtering_.sensor_motion = motion_.judge(frame, sensor_position_, time);
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
  statistics_ = {voxelization_,
                 encoder_.statistics(),
                 filtering_.hidden,
                 filtering_.held,
                 false,
                 filtering_.sensor_motion};
  const LimitedCounts counts = limitedCounts(frame);
  statistics_.exceeds_limits = exceedsLimits(statistics_, settings_, counts);
  // Without memory for it the frame goes out without the warning.
  return callOrElse(
      [&] {
        return CompressionStatus(
            CompressionCode::Ok,
            frameWarning(
                statistics_, settings_, unit_, voxelizer_.isCoarsened(), counts));
      },
      [] { return CompressionStatus(); });
}

/** \brief What of the frame that was encoded last decoders limit. */
LimitedCounts
CloudEncoder::Implementation::limitedCounts(const VoxelFrame& frame)
{
  const CodedFrameStatistics& coding = statistics_.coding;
  if (coding.is_i_frame)
    bytes_since_i_frame_ = 0;
  bytes_since_i_frame_ += coding.bytes - coding.header_bytes;
  // Counted only where they may exceed the limit. Those of a refinement are fewer.
  const bool may_exceed =
      coding.voxels >
      frameLimits(settings_.decoder_limits, bytes_since_i_frame_).max_blocks;
  return {may_exceed ? countBlocks(frame.keys) : 0,
          frame.fieldValueCount(),
          bytes_since_i_frame_};
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
CloudEncoder::setSettings(const EncoderSettings& settings,
                          const std::optional<DepthLaw>& depth_law)
{
  implementation_->setSettings(settings, depth_law);
}

bool
CloudEncoder::isIFrameDue() const
{
  return implementation_->isIFrameDue();
}

void
CloudEncoder::dropLastFrame()
{
  implementation_->dropLastFrame();
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

void
CloudEncoder::seeBeyond(PointBatches& points,
                        const BoundingBox& box,
                        const WorldPose& sensor_pose)
{
  implementation_->seeBeyond(points, box, sensor_pose);
}

CompressionStatus
CloudEncoder::filterOverTime(VoxelFrame& frame,
                             const std::optional<std::chrono::nanoseconds>& time)
{
  return implementation_->filterOverTime(frame, time);
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
