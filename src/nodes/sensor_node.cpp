// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/sensor_node.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "nodes/left_out.h"
#include "nodes/rate_window.h"
#include "nodes/sensor_node_settings.h"
#include "nodes/sensor_pipeline.h"

#include <memory>
#include <new>
#include <utility>

namespace pcl_ext {
namespace nodes {

class SensorNode::Implementation {
public:
  explicit Implementation(const SensorNodeSettings& settings)
  : settings_(settings)
  , removal_(settings.outlier_removal)
  , settings_status_(checkSettings(settings))
  {
    if (settings_status_.ok())
      pipeline_.emplace(settings_);
  }

  const SensorNodeStatus&
  settingsStatus() const
  {
    return settings_status_;
  }

  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         const std::optional<WorldPose>& sensor_to_world,
         std::vector<std::uint8_t>& bytes)
  {
    bytes.clear();
    const auto refuse = [&](SensorNodeStatus status) {
      bytes.clear();
      if (pipeline_) {
        ++statistics_.clouds_refused;
        pipeline_->filters.reset();
        // A frame may have been encoded that is not returned.
        pipeline_->encoder.requestIFrame();
      }
      return status;
    };
    return callOrElse([&] { return encodeOrThrow(cloud, sensor_to_world, bytes); },
                      [&] { return refuse(outOfMemoryStatus<SensorNodeStatus>()); },
                      [&](const std::string& reason) {
                        return refuse(
                            SensorNodeStatus(SensorNodeCode::EncodingFailed, reason));
                      });
  }

  void
  requestIFrame()
  {
    if (pipeline_)
      pipeline_->encoder.requestIFrame();
  }

  void
  setMaxRate(double bits_per_second)
  {
    if (pipeline_)
      pipeline_->rate_control.setMaxRate(bits_per_second);
  }

  SensorNodeStatistics
  statistics() const
  {
    SensorNodeStatistics statistics = statistics_;
    if (pipeline_)
      statistics.rate_control = pipeline_->rate_control.status();
    if (settings_.clock)
      statistics.rates = window_.rates(settings_.clock());
    return statistics;
  }

private:
  SensorNodeStatus
  encodeOrThrow(const pcl::PCLPointCloud2& cloud,
                const std::optional<WorldPose>& sensor_to_world,
                std::vector<std::uint8_t>& bytes)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const auto start = std::chrono::steady_clock::now();
    if (SensorNodeStatus status = takeTransform(sensor_to_world); !status.ok())
      return status;
    io::RateControl& rate_control = pipeline_->rate_control;
    if (!rate_control.beginCloud(settings_.clock(), pipeline_->encoder.isIFrameDue()))
      return leftOut();
    if (rate_control.hasChanged()) {
      takeStep();
      is_change_new_ = true;
    }
    if (!pipeline_->filters)
      pipeline_->filters.emplace(settings_);
    std::size_t outliers = 0;
    const OutlierRemovalStatus points = judgePoints(cloud);
    SensorNodeStatus status =
        openPoints(points.removed > 0 ? pipeline_->filters->cloud : cloud);
    judges_points_ = points.ok();
    if (status.ok())
      status = encodePoints(cloud.header, outliers, bytes);
    if (!status.ok()) {
      ++statistics_.clouds_refused;
      return status;
    }
    if (!rate_control.endFrame(bytes.size(),
                               pipeline_->encoder.statistics().coding.is_i_frame,
                               std::chrono::steady_clock::now() - start,
                               pipeline_->frame.grid,
                               pipeline_->encoder.statistics().sensor_motion)) {
      pipeline_->encoder.dropLastFrame();
      bytes.clear();
      return leftOut();
    }
    if (is_change_new_)
      status = withChange(status, rate_control.status());
    is_change_new_ = false;
    // Before the statistics are updated, as the message needs memory.
    if (!sensor_to_world)
      status = {
          SensorNodeCode::UsedLastTransform,
          SettingText{"there is no transform for this cloud; the last one was used" +
                      (status.hasWarning() ? "; " + status.text().marked : "")}};
    const std::chrono::duration<double> cycle =
        std::chrono::steady_clock::now() - start;
    count(cloud, bytes.size(), cycle.count());
    noteFrame(points, outliers);
    statistics_.frames_with_last_transform += sensor_to_world ? 0 : 1;
    return status;
  }

  /** \brief The status of a cloud without room; without memory for it, without the
   * message, as the cloud is counted already. */
  SensorNodeStatus
  leftOut() const
  {
    return callOrElse(
        [&] {
          return SensorNodeStatus(SensorNodeCode::LeftOut,
                                  pipeline_->rate_control.leftOutMessage());
        },
        [] { return SensorNodeStatus(SensorNodeCode::LeftOut, ""); });
  }

  /** \brief Sets the statistics of the last frame.
   * \param[in] points what was done to the points
   * \param[in] outliers number of voxels that were removed
   */
  void
  noteFrame(const OutlierRemovalStatus& points, std::size_t outliers)
  {
    statistics_.preprocessing = pipeline_->filters->points->statistics();
    statistics_.outliers_removed = outliers;
    statistics_.judged_points = judges_points_;
    statistics_.points_removed = points.removed;
    statistics_.preprocessing.points_not_finite -= points.removed;
    const bool has_image = pipeline_->encoder.statistics().coding.has_image;
    statistics_.decoded_width =
        has_image ? pipeline_->frame.cloudWidth() : pipeline_->frame.pointCount();
    statistics_.decoded_height = has_image ? pipeline_->frame.cloudHeight() : 1;
    statistics_.decoded_doubles = pipeline_->frame.grid.needsDoubles();
    statistics_.decoded_fields.assign(pipeline_->frame.fields.begin(),
                                      pipeline_->frame.fields.end());
  }

  /** \brief Takes over the step that the rate control has chosen. */
  void
  takeStep()
  {
    const io::RateControl& rate_control = pipeline_->rate_control;
    std::optional<VoxelOutlierRemovalSettings> removal = removal_;
    if (rate_control.minLogOdds()) {
      if (!removal)
        removal.emplace();
      removal->min_log_odds = *rate_control.minLogOdds();
    }
    else
      removal.reset();
    if (rate_control.settings().resolution != settings_.compression.resolution ||
        !(removal == settings_.outlier_removal))
      pipeline_->filters.reset();
    SensorNodeSettings changed = settings_;
    changed.compression = rate_control.settings();
    changed.compression.bounding_box = settings_.compression.bounding_box;
    changed.outlier_removal = removal;
    pipeline_->encoder.setSettings(codecSettings(changed), depthLaw(changed));
    settings_ = std::move(changed);
  }

  static SensorNodeStatus
  withChange(const SensorNodeStatus& status, const io::RateControlStatus& rate)
  {
    return {status.code(),
            SettingText{status.text().marked + (status.message().empty() ? "" : "; ") +
                        "rate control: " + rate.choice + ", as " + rate.reason}};
  }

  SensorNodeStatus
  takeTransform(const std::optional<WorldPose>& sensor_to_world)
  {
    if (sensor_to_world) {
      const Eigen::Isometry3d pose(*sensor_to_world);
      if (!isRigid(pose.cast<float>())) {
        SensorNodeStatus status(
            SensorNodeCode::InvalidTransform,
            "the transform of the sensor is not a rotation and a translation");
        ++statistics_.clouds_refused;
        return status;
      }
      last_transform_ = *sensor_to_world;
    }
    if (!last_transform_) {
      SensorNodeStatus status(SensorNodeCode::NoTransform,
                              "there is no transform from the sensor to '" +
                                  settings_.global_frame +
                                  "' yet; the cloud was not encoded");
      ++statistics_.clouds_without_transform;
      return status;
    }
    return {};
  }

  /** \brief Finds outliers among the points of a lidar, and makes a cloud without
   * them. */
  OutlierRemovalStatus
  judgePoints(const pcl::PCLPointCloud2& cloud)
  {
    SensorFilters& filters = *pipeline_->filters;
    if (!filters.point_outlier_removal)
      return {OutlierRemovalCode::NoImage, ""};
    OutlierRemovalStatus status =
        filters.outliers.find(cloud, *filters.point_outlier_removal);
    if (status.removed > 0) {
      filters.cloud = cloud;
      filters.outliers.hide(filters.cloud);
    }
    return status;
  }

  SensorNodeStatus
  openPoints(const pcl::PCLPointCloud2& cloud)
  {
    const PreprocessingStatus status =
        pipeline_->filters->points->open(Eigen::Isometry3d(*last_transform_), cloud);
    if (!status.ok())
      return {SensorNodeCode::InvalidCloud, status.message()};
    if (pipeline_->filters->uncropped)
      (void)pipeline_->filters->uncropped->open(Eigen::Isometry3d(*last_transform_),
                                                cloud);
    const std::string fault = faultOfNamedFields(cloud, settings_.compression.fields);
    return {fault.empty() ? SensorNodeCode::Ok : SensorNodeCode::InvalidCloud, fault};
  }

  /** \return number of voxels removed */
  std::size_t
  removeOutliersOf(io::VoxelFrame& frame)
  {
    VoxelOutlierRemoval& removal = *pipeline_->filters->outlier_removal;
    const Eigen::Vector3d sensor(last_transform_->translation());
    if (!settings_.outlier_removal->sensor_position)
      removal.setSensorPosition({sensor.x(), sensor.y(), sensor.z()});
    // checkSettings() has refused what the filter would.
    return removal.filter(frame).removed;
  }

  /** \brief Of a cloud's stamp, or of the clock where it has none. */
  Time
  timeOfCloud(const pcl::PCLHeader& header) const
  {
    return header.stamp != 0 ? timeOfStamp(header.stamp) : settings_.clock();
  }

  SensorNodeStatus
  encodePoints(const pcl::PCLHeader& header,
               std::size_t& outliers,
               std::vector<std::uint8_t>& bytes)
  {
    io::VoxelFrame& frame = pipeline_->frame;
    if (pipeline_->filters->uncropped)
      pipeline_->encoder.seeBeyond(pipeline_->filters->uncropped->batches(),
                                   *settings_.crop_box,
                                   *last_transform_);
    io::CompressionStatus status = pipeline_->encoder.voxelize(
        pipeline_->filters->points->batches(), *last_transform_, frame);
    if (status.ok()) {
      if (pipeline_->filters->outlier_removal && !judges_points_)
        outliers = removeOutliersOf(frame);
      status = pipeline_->encoder.filterOverTime(frame, timeOfCloud(header));
    }
    if (status.ok()) {
      if (settings_.carry_header)
        pipeline_->stamp = io::FrameStamp{header.stamp, settings_.global_frame};
      status = pipeline_->encoder.encode(frame, pipeline_->stamp, bytes);
    }
    if (status.code() == io::CompressionCode::OutOfMemory)
      throw std::bad_alloc(); // handled by encode()
    // A success may have a warning.
    return {status.ok() ? SensorNodeCode::Ok : SensorNodeCode::EncodingFailed,
            status.text()};
  }

  void
  count(const pcl::PCLPointCloud2& cloud, std::size_t bytes, double cycle_seconds)
  {
    const io::FrameStatistics& frame = pipeline_->encoder.statistics();
    const Time now = settings_.clock();
    window_.add({now,
                 bytes,
                 cycle_seconds,
                 latencySeconds(timeOfStamp(cloud.header.stamp), now).value_or(0.0)});
    // Nothing below throws.
    ++statistics_.frames;
    statistics_.encode_times.add(cycle_seconds);
    statistics_.i_frames += frame.coding.is_i_frame ? 1 : 0;
    statistics_.cloud_bytes += cloud.data.size();
    statistics_.frame_bytes += bytes;
    statistics_.frame = frame;
  }

  SensorNodeSettings settings_; // of the current step of the rate control
  // As given: of the first step.
  std::optional<VoxelOutlierRemovalSettings> removal_;
  SensorNodeStatus settings_status_;
  std::optional<SensorPipeline> pipeline_; // only if the settings are valid
  std::optional<WorldPose> last_transform_;
  bool judges_points_ = false; // of the current cloud
  bool is_change_new_ = false; // not told yet with a frame
  SensorNodeStatistics statistics_;
  RateWindow window_;
};

SensorNode::SensorNode(const SensorNodeSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

SensorNode::~SensorNode() = default;
SensorNode::SensorNode(SensorNode&&) noexcept = default;
SensorNode&
SensorNode::operator=(SensorNode&&) noexcept = default;

const SensorNodeStatus&
SensorNode::settingsStatus() const
{
  return implementation_->settingsStatus();
}

SensorNodeStatus
SensorNode::encode(const pcl::PCLPointCloud2& cloud,
                   const std::optional<WorldPose>& sensor_to_world,
                   std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(cloud, sensor_to_world, bytes);
}

void
SensorNode::setMaxRate(double bits_per_second)
{
  implementation_->setMaxRate(bits_per_second);
}

void
SensorNode::requestIFrame()
{
  implementation_->requestIFrame();
}

SensorNodeStatistics
SensorNode::statistics() const
{
  return implementation_->statistics();
}

} // namespace nodes
} // namespace pcl_ext
