// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "nodes/left_out.h"
#include "nodes/rate_window.h"
#include "nodes/sensor_node_settings.h"
#include "nodes/sensor_pipeline.h"

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

class SensorNode::Implementation {
public:
  explicit Implementation(const SensorNodeSettings& settings)
  : settings_(settings), settings_status_(checkSettings(settings)), source_(settings)
  {
    if (settings_status_.ok())
      encoder_.emplace(makeEncoder(settings));
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
    if (!settings_status_.ok())
      return settings_status_;
    // A frame may have been encoded that is not returned.
    const auto refuse = [&](SensorNodeStatus status) {
      bytes.clear();
      source_.reset();
      encoder_->requestIFrame();
      return refused(std::move(status));
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
    if (encoder_)
      encoder_->requestIFrame();
  }

  void
  setMaxRate(double bits_per_second)
  {
    if (encoder_)
      encoder_->setMaxRate(bits_per_second);
  }

  SensorNodeStatistics
  statistics() const
  {
    SensorNodeStatistics statistics = statistics_;
    if (encoder_)
      statistics.rate_control = encoder_->rateControlStatus();
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
    const auto start = std::chrono::steady_clock::now();
    if (SensorNodeStatus status = takeTransform(sensor_to_world); !status.ok())
      return status;
    source_.setCloud(cloud, *last_transform_);
    if (settings_.carry_layout)
      takeLayout(cloud);
    const io::CompressionStatus encoded =
        encoder_->encode(source_, infoOf(cloud.header), bytes);
    if (!encoded.ok())
      return statusOf(encoded);
    // Before the statistics are updated, as the message needs memory.
    SensorNodeStatus status(SensorNodeCode::Ok, encoded.text());
    if (encoder_->statistics().is_step_new)
      status = withChange(status, encoder_->rateControlStatus());
    // That of the rate control is told by the statistics.
    const double edge = settings_.compression.resolution;
    if (doOutliersStay() && !VoxelOutlierRemoval::isMadeFor(edge))
      status = withWarning(status, "outliers stay: " + unjudgedEdge(edge).marked);
    if (!sensor_to_world)
      status = {
          SensorNodeCode::UsedLastTransform,
          SettingText{"there is no transform for this cloud; the last one was used" +
                      (status.hasWarning() ? "; " + status.text().marked : "")}};
    const std::chrono::duration<double> cycle =
        std::chrono::steady_clock::now() - start;
    count(cloud, bytes.size(), cycle.count());
    noteFrame(bytes);
    statistics_.frames_with_last_transform += sensor_to_world ? 0 : 1;
    return status;
  }

  const io::CloudInfo&
  infoOf(const pcl::PCLHeader& header)
  {
    info_.sensor_pose = *last_transform_;
    info_.arrival = settings_.clock();
    info_.time = header.stamp != 0 ? io::timeOfStamp(header.stamp) : info_.arrival;
    if (settings_.carry_header)
      info_.stamp = io::FrameStamp{header.stamp, settings_.global_frame};
    return info_;
  }

  /** \brief Sets the layout of a cloud, where it is another one than before; other
   * padding of rows alone, which may depend on their width, is none. */
  void
  takeLayout(const pcl::PCLPointCloud2& cloud)
  {
    if (cloud.data.empty() && (info_.layout || cloud.fields.empty()))
      return; // empty clouds may have other fields, or none
    io::MessageLayout layout = layoutToCarry(cloud, settings_);
    if (info_.layout && info_.layout->point_step == layout.point_step &&
        info_.layout->fields == layout.fields)
      return;
    info_.layout = io::isLayout(layout)
                       ? std::make_shared<const io::MessageLayout>(std::move(layout))
                       : nullptr;
  }

  /** \brief The status of a cloud that was not encoded. */
  SensorNodeStatus
  statusOf(const io::CompressionStatus& status)
  {
    switch (status.code()) {
    case io::CompressionCode::LeftOut: // counted by the rate control
      return {SensorNodeCode::LeftOut, status.text()};
    case io::CompressionCode::OutOfMemory:
      source_.reset();
      return refused(outOfMemoryStatus<SensorNodeStatus>());
    default:
      return refused({source_.isCloudInvalid() ? SensorNodeCode::InvalidCloud
                                               : SensorNodeCode::EncodingFailed,
                      status.text()});
    }
  }

  SensorNodeStatus
  refused(SensorNodeStatus status)
  {
    ++statistics_.clouds_refused;
    return status;
  }

  static SensorNodeStatus
  withWarning(const SensorNodeStatus& status, const std::string& marked)
  {
    return {status.code(),
            SettingText{status.text().marked + (status.message().empty() ? "" : "; ") +
                        marked}};
  }

  static SensorNodeStatus
  withChange(const SensorNodeStatus& status, const io::RateControlStatus& rate)
  {
    return withWarning(status, "rate control: " + rate.choice + ", as " + rate.reason);
  }

  /** \brief Whether outliers stay in the last frame. */
  bool
  doOutliersStay() const
  {
    return source_.doOutliersStay() &&
           encoder_->statistics().voxelization.points_used > 0;
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

  /** \brief Sets the statistics of the last frame. */
  void
  noteFrame(const std::vector<std::uint8_t>& bytes)
  {
    source_.describe(statistics_);
    statistics_.outliers_stay = doOutliersStay();
    const io::ImageSize size = encoder_->decodedSize();
    statistics_.decoded_width = size.width;
    statistics_.decoded_height = size.height;
    statistics_.decoded_layout = info_.layout;
    const io::CodedFrameStatistics& coding = encoder_->statistics().coding;
    if (!coding.has_points) {
      const io::VoxelFrame& frame = encoder_->frame();
      statistics_.decoded_doubles = frame.grid.needsDoubles();
      statistics_.decoded_fields.assign(frame.fields.begin(), frame.fields.end());
    }
    else if (coding.is_i_frame) { // P-frames have the same, and frame() makes voxels
      io::FrameDescription frame = io::describeFrame(bytes.data(), bytes.size());
      statistics_.decoded_doubles = frame.grid.needsDoubles();
      statistics_.decoded_fields = std::move(frame.fields);
    }
  }

  void
  count(const pcl::PCLPointCloud2& cloud, std::size_t bytes, double cycle_seconds)
  {
    const io::FrameStatistics& frame = encoder_->statistics();
    const Time now = settings_.clock();
    window_.add(
        {now,
         bytes,
         cycle_seconds,
         latencySeconds(io::timeOfStamp(cloud.header.stamp), now).value_or(0.0)});
    // Nothing below throws.
    ++statistics_.frames;
    statistics_.encode_times.add(cycle_seconds);
    statistics_.i_frames += frame.coding.is_i_frame ? 1 : 0;
    statistics_.cloud_bytes += cloud.data.size();
    statistics_.frame_bytes += bytes;
    statistics_.frame = frame;
  }

  SensorNodeSettings settings_;
  SensorNodeStatus settings_status_;
  SensorSource source_;
  std::optional<io::CloudEncoder> encoder_; // only if the settings are valid
  std::optional<WorldPose> last_transform_;
  io::CloudInfo info_; // of the current cloud
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

} // namespace pcl_ext::PCL_EXT_ABI::nodes
