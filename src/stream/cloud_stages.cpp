// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/cloud_stages.h"

#include "bytes/exceptions.h"
#include "codec/frame_limits.h"
#include "codec/scan/scan_points.h"
#include "voxelizing/point_batches.h"
#include "voxels/point_voxels.h"
#include "voxels/voxel_block.h"

#include <array>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using Clock = std::chrono::steady_clock;

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
         !settings.keepsPoints() && settings.fields.empty();
}

/** \brief True if voxels of the one settings are those of the others. */
bool
haveSameVoxels(const EncoderSettings& a, const EncoderSettings& b)
{
  return a.resolution == b.resolution && a.origin == b.origin &&
         a.use_coordinate_step == b.use_coordinate_step &&
         a.intensity_curve == b.intensity_curve && a.intensity_bits == b.intensity_bits;
}

std::array<double, 3>
elementsOf(const Eigen::Vector3d& vector)
{
  return {vector.x(), vector.y(), vector.z()};
}

} // namespace

CloudStages::CloudStages(const EncoderSettings& settings,
                         IntensityUnit unit,
                         const std::optional<DepthLaw>& depth_law,
                         const std::optional<NoiseRemoval>& noise_removal)
: unit_(unit)
, noise_removal_(noise_removal)
, encoder_(settings.format,
           settings.i_frame_rate,
           settings.effort,
           settings.first_frame_number,
           settings.i_frame_every)
{
  begin(settings, depth_law);
}

void
CloudStages::setResolution(double resolution, const std::optional<DepthLaw>& depth_law)
{
  EncoderSettings settings = base_;
  settings.resolution = resolution;
  begin(settings, depth_law);
  encoder_.requestIFrame();
}

CompressionStatus
CloudStages::voxelize(const PointView& points,
                      const WorldPose& sensor_pose,
                      VoxelFrame& frame)
{
  if (CompressionStatus status = checkView(points); !status.ok())
    return status;
  SingleBatch batch(points);
  if (CompressionStatus status = contents_->select(batch); !status.ok())
    return status;
  CompressionStatus status =
      voxelizeBatches(batch, sensor_pose, encoder_.isIFrameDue(), frame);
  if (voxelizer_->hasChanged())
    encoder_.requestIFrame();
  return status;
}

/** \brief Begins the rate control with settings; the stream goes on. */
void
CloudStages::begin(const EncoderSettings& settings,
                   const std::optional<DepthLaw>& depth_law)
{
  CompressionStatus status = checkSettings(settings, depth_law);
  if (status.ok()) {
    RateControl rate_control(settings,
                             unit_ != IntensityUnit::None,
                             noise_removal_.has_value(),
                             noise_removal_ ? noise_removal_->min_log_odds
                                            : std::nullopt);
    if (rate_control_)
      rate_control.setMaxRate(rate_control_->status().max_rate); // as it was changed
    if (!contents_)
      contents_.emplace(settings);
    takeSettings(settings, depth_law);
    rate_control_ = std::move(rate_control);
  }
  else
    settings_ = settings;
  base_ = settings;
  settings_status_ = std::move(status);
}

/** \brief Takes over valid settings. The next frame is an I-frame, unless only the
 * temporal filter changes. */
void
CloudStages::takeSettings(const EncoderSettings& settings,
                          const std::optional<DepthLaw>& depth_law)
{
  EncoderSettings taken = settings;
  const bool has_filter =
      taken.temporal_filter == settings_.temporal_filter &&
      taken.temporal_filter_holds == settings_.temporal_filter_holds;
  // May throw, so it comes before the changes.
  std::optional<CloudVoxelizer> voxelizer;
  std::optional<ScanCollector> scans;
  std::optional<ScanChoice> scan_choice;
  if (!voxelizer_ || !haveSameVoxels(taken, settings_)) {
    voxelizer.emplace(taken, unit_);
    if (ScanCollector::isPossible(taken, unit_)) {
      scans.emplace(taken, unit_);
      scan_choice.emplace(taken);
    }
  }
  if (!voxelizer_ || !has_filter)
    temporal_filter_ = temporalFilterOf(taken);
  settings_ = std::move(taken);
  depth_law_ = depth_law;
  encoder_.setEffort(settings_.effort);
  if (!voxelizer)
    return;
  voxelizer_ = std::move(voxelizer);
  scans_ = std::move(scans);
  scan_choice_ = std::move(scan_choice);
  encoder_.requestIFrame();
}

CompressionStatus
CloudStages::run(CloudSource& source,
                 const CloudInfo& info,
                 std::vector<std::uint8_t>& bytes)
{
  const Clock::time_point begin = Clock::now();
  const auto arrival =
      info.arrival ? info.arrival : info.time.value_or(begin.time_since_epoch());
  encoder_.setTime(info.time);
  if (!rate_control_->beginCloud(*arrival, encoder_.isIFrameDue()))
    return leftOut();
  if (rate_control_->hasChanged()) {
    const EncoderSettings& settings = rate_control_->settings();
    takeSettings(settings, source.takeStep(settings, rate_control_->minLogOdds()));
    is_step_new_ = true;
  }

  OpenedCloud cloud;
  if (CompressionStatus status = source.open(cloud); !status.ok())
    return status;
  if (CompressionStatus status = checkView(cloud.view); !status.ok())
    return status;
  SingleBatch batch(cloud.view, cloud.points_behind_sensor);
  PointBatches& points = cloud.batches != nullptr ? *cloud.batches : batch;
  showBeyond(cloud, points, info.sensor_pose);
  CompressionStatus status = encodeCloud(points, source, info, bytes);
  if (!status.ok())
    return status;
  if (scan_choice_ &&
      (scan_choice_->follow(encoder_.statistics(), voxelization_.points_used) ||
       scans_->wantsOtherRays()))
    encoder_.requestIFrame();
  status = describeFrame();

  if (rate_control_->endFrame(bytes.size(),
                              statistics_.coding.is_i_frame,
                              Clock::now() - begin,
                              is_scan_ ? scan_.grid : frame_.grid,
                              statistics_.sensor_motion)) {
    is_step_new_ = false;
    return status;
  }
  encoder_.dropLastFrame();
  return leftOut();
}

/** \brief The status of a cloud without room; without memory for it, without the message,
 * as the cloud is counted already. */
CompressionStatus
CloudStages::leftOut() const
{
  return callOrElse(
      [&] {
        return CompressionStatus(CompressionCode::LeftOut,
                                 rate_control_->leftOutMessage());
      },
      [] { return CompressionStatus(CompressionCode::LeftOut, ""); });
}

/** \brief Encodes a cloud as a scan or as voxels. */
CompressionStatus
CloudStages::encodeCloud(PointBatches& points,
                         CloudSource& source,
                         const CloudInfo& info,
                         std::vector<std::uint8_t>& bytes)
{
  is_scan_ = false;
  if (CompressionStatus status = contents_->select(points); !status.ok())
    return status;
  const bool is_i_frame_due = encoder_.isIFrameDue();
  CompressionStatus status;
  const bool may_be_scan =
      scans_ && !source.removesNoise() && scan_choice_->mayBeScan(is_i_frame_due);
  if (may_be_scan && collectScan(points, info, is_i_frame_due, status)) {
    scan_.layout = info.layout;
    if (status.ok() && !is_i_frame_due && voxelization_.points_used > 0 &&
        (encoder_.mustBeIFrame(scan_, info.stamp) ||
         scan_choice_->triesAgain(voxelization_.points_used)))
      return encodeAsIFrame(points, source, info, bytes);
    if (status.ok())
      status = is_i_frame_due && scan_choice_->prefersVoxels(scan_)
                   ? encodeVoxels(points, source, info, bytes)
                   : encodeScan(points, info, bytes);
  }
  // Its voxels could not follow a scan.
  else if (may_be_scan && !is_i_frame_due &&
           (encoder_.statistics().has_points || (settings_.keep_order && !status.ok())))
    return encodeAsIFrame(points, source, info, bytes);
  else {
    if (settings_.keep_order && !may_be_scan)
      status = orderStatus(scans_ ? "noise is removed from its voxels"
                                  : "intensities are counts or shares of voxels");
    if (!settings_.keep_order || status.ok())
      status = encodeVoxels(points, source, info, bytes);
  }
  return status;
}

/** \brief Begins again with a cloud that was taken for a P-frame. */
CompressionStatus
CloudStages::encodeAsIFrame(PointBatches& points,
                            CloudSource& source,
                            const CloudInfo& info,
                            std::vector<std::uint8_t>& bytes)
{
  encoder_.requestIFrame();
  return encodeCloud(points, source, info, bytes);
}

/** \brief Collects the scan of a cloud.
 * \return false if there is none: the cloud may be coded as voxels, if the status is Ok
 */
bool
CloudStages::collectScan(PointBatches& points,
                         const CloudInfo& info,
                         bool is_i_frame_due,
                         CompressionStatus& status)
{
  return scans_->collect(points,
                         contents_->fields(),
                         info.sensor_pose,
                         is_i_frame_due,
                         scan_,
                         voxelization_,
                         status);
}

CompressionStatus
CloudStages::encodeVoxels(PointBatches& points,
                          CloudSource& source,
                          const CloudInfo& info,
                          std::vector<std::uint8_t>& bytes)
{
  const bool is_i_frame_due = encoder_.isIFrameDue();
  if (CompressionStatus status =
          voxelizeBatches(points, info.sensor_pose, is_i_frame_due, frame_);
      !status.ok())
    return status;
  if (voxelizer_->hasChanged())
    encoder_.requestIFrame();
  const VoxelFit fit = voxelizer_->fit();
  if (scan_choice_ && !source.removesNoise() && (fit.is_coarsened || fit.wider_grid)) {
    // A scan holds all points.
    scan_choice_->takeScan();
    const VoxelizationStatistics of_voxels = voxelization_;
    constexpr bool is_i_frame = true;
    if (CompressionStatus status; collectScan(points, info, is_i_frame, status)) {
      encoder_.requestIFrame();
      return status.ok() ? encodeScan(points, info, bytes) : status;
    }
    voxelization_ = of_voxels;
  }
  else if (scan_choice_ && !source.removesNoise() && !is_i_frame_due &&
           scan_choice_->triesAgain(voxelization_.points_used))
    return encodeAsIFrame(points, source, info, bytes);
  source.removeNoise(frame_);
  if (CompressionStatus status = filterOverTime(info.sensor_pose, info.time);
      !status.ok())
    return status;
  frame_.layout = info.layout;
  return encoder_.encode(frame_, info.stamp, bytes);
}

/** \brief Encodes the scan of a cloud, or in a trial its voxels if they take fewer
 * bytes. */
CompressionStatus
CloudStages::encodeScan(PointBatches& points,
                        const CloudInfo& info,
                        std::vector<std::uint8_t>& bytes)
{
  const bool is_i_frame_due = encoder_.isIFrameDue();
  filtering_ = TemporalFilterStatus();
  frame_.clearVoxels();
  is_scan_ = true;
  scan_.layout = info.layout;
  CompressionStatus status =
      encoder_.encode(scan_, info.stamp, bytes, settings_.threads);
  if (!status.ok())
    return status;
  const bool is_i_frame = encoder_.statistics().is_i_frame;
  if (!scan_choice_->wantsVoxels(bytes.size(), is_i_frame))
    return status;
  const VoxelizationStatistics of_scan = voxelization_;
  const bool are_there =
      voxelizeBatches(points, info.sensor_pose, is_i_frame_due, frame_).ok();
  const VoxelizationStatistics of_voxels = std::exchange(voxelization_, of_scan);
  // Fewer bytes for fewer points, or coarser ones, are no result.
  const VoxelFit fit = voxelizer_->fit();
  if (!are_there || fit.is_coarsened || fit.wider_grid)
    scan_choice_->takeScan();
  else if (scan_choice_->takesVoxels(frame_, bytes.size(), is_i_frame)) {
    is_scan_ = false;
    voxelization_ = of_voxels;
    frame_.layout = info.layout;
    encoder_.dropLastFrame();
    return encoder_.encode(frame_, info.stamp, bytes);
  }
  frame_.clearVoxels();
  return status;
}

const VoxelFrame&
CloudStages::frame()
{
  if (is_scan_ && !frame_.points.areThere()) {
    scan::ScanFrame scan = scan_;
    scan::movePoints(scan, frame_);
    setVoxels(frame_);
  }
  return frame_;
}

ImageSize
CloudStages::decodedSize() const
{
  if (is_scan_ && scan_.order == scan::PointOrder::Organised)
    return {scan_.width, scan_.height};
  const std::size_t points = is_scan_ ? scan_.pixels.size() : frame_.pointCount();
  return {static_cast<std::uint32_t>(points), 1};
}

CompressionStatus
CloudStages::voxelizeBatches(PointBatches& points,
                             const WorldPose& sensor_pose,
                             bool is_i_frame_due,
                             VoxelFrame& frame)
{
  // What the temporal filter holds stays in the grid and the scale, which then only
  // grow.
  voxelization_ =
      voxelizer_->voxelize(points, is_i_frame_due, !temporal_filter_, frame);
  if (CompressionStatus status = contents_->collect(
          points, sensor_pose, settings_, voxelization_.points_used, frame);
      !status.ok())
    return status;
  frame.depth_model.reset();
  if (depth_law_ && settings_.format == StreamFormat::Version1 &&
      frame.hasIntensities())
    frame.depth_model = depthModelOf(*depth_law_,
                                     elementsOf(sensor_pose.translation()),
                                     elementsOf(sensor_pose.linear().col(2)),
                                     frame.grid,
                                     frame.intensity_scale);
  return {};
}

/** \brief Shows the temporal filter the points that are not in the frame as they are
 * outside of a box. */
void
CloudStages::showBeyond(const OpenedCloud& cloud,
                        PointBatches& points,
                        const WorldPose& sensor_pose)
{
  if (!temporal_filter_ || !sensor_pose.translation().allFinite())
    return;
  const std::array<double, 3> position = elementsOf(sensor_pose.translation());
  if (cloud.uncropped != nullptr)
    temporal_filter_->seeBeyond(*cloud.uncropped, cloud.crop_box, position);
  else if (settings_.bounding_box)
    temporal_filter_->seeBeyond(points, *settings_.bounding_box, position);
}

CompressionStatus
CloudStages::filterOverTime(const WorldPose& sensor_pose,
                            const std::optional<std::chrono::nanoseconds>& time)
{
  const std::array<double, 3> position = elementsOf(sensor_pose.translation());
  filtering_ = TemporalFilterStatus();
  if (temporal_filter_) {
    motion_ =
        FrameMotion(); // what moves before the sensor is elsewhere after the filter
    filtering_ = temporal_filter_->filter(frame_, {position, time});
  }
  else if (mayFilterLater(settings_))
    filtering_.sensor_motion = motion_.judge(frame_, position, time);
  return filtering_.ok()
             ? CompressionStatus()
             : CompressionStatus(CompressionCode::InvalidInput, filtering_.message());
}

/** \brief Sets the figures of the frame that was encoded.
 * \return Ok, with what is not in the frame
 */
CompressionStatus
CloudStages::describeFrame()
{
  statistics_ = {voxelization_,
                 encoder_.statistics(),
                 filtering_.hidden,
                 filtering_.held,
                 false,
                 filtering_.sensor_motion,
                 is_step_new_};
  const LimitedCounts counts = limitedCounts();
  statistics_.exceeds_limits = exceedsLimits(statistics_, settings_, counts);
  // Without memory for it the frame goes out without the warning.
  return callOrElse(
      [&] {
        return CompressionStatus(CompressionCode::Ok,
                                 frameWarning(statistics_,
                                              settings_,
                                              unit_,
                                              is_scan_
                                                  ? VoxelFit{scans_->isCoarsened(), {}}
                                                  : voxelizer_->fit(),
                                              counts,
                                              contents_->fields().leftOut()));
      },
      [] { return CompressionStatus(); });
}

/** \brief What of the frame that was encoded last decoders limit. */
LimitedCounts
CloudStages::limitedCounts() const
{
  const std::uint64_t bytes = encoder_.bytesSinceIFrame();
  // Counted only where they may exceed the limit. Those of a refinement are fewer.
  const bool may_exceed = statistics_.coding.voxels >
                          frameLimits(settings_.decoder_limits, bytes).max_blocks;
  std::size_t values = frame_.fieldValueCount();
  for (const FrameField& field : scan_.fields)
    values += is_scan_ ? field.numbers.size() : 0;
  return {may_exceed && !is_scan_ ? countBlocks(frame_.keys) : 0, values, bytes};
}

} // namespace pcl_ext::PCL_EXT_ABI::io
