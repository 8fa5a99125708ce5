// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/i_frame_requests.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "bytes/exceptions.h"
#include "nodes/stamp_gaps.h"

#include <mutex>
#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

class CloudSender::Implementation {
public:
  explicit Implementation(const SensorNodeSettings& settings) : settings_(settings)
  {
    readEncodingParameters(values_, false, settings_);
    settings_.carry_layout = true;
  }

  std::string
  setParameters(const ParameterValues& values)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ParameterValues changed = values_;
    for (const auto& [name, value] : values)
      changed[name] = value;
    if (changed == values_)
      return {};
    // Whichever law automatic becomes.
    if (std::string fault = faultOfEncodingParameters(changed); !fault.empty())
      return fault;
    const bool is_new_stream = !isSameButForRate(values_, changed);
    if (std::string fault = readEncodingParameters(
            changed, !is_new_stream && has_intensities_, settings_);
        !fault.empty())
      return fault;
    values_ = std::move(changed);
    if (is_new_stream)
      node_.reset();
    else if (node_)
      node_->setMaxRate(settings_.compression.max_rate);
    return {};
  }

  void
  requestIFrame()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.i_frame_requests;
    requests_.add();
  }

  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         const std::optional<WorldPose>& sensor_to_world,
         std::size_t receivers,
         std::vector<std::uint8_t>& bytes)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes.clear();
    return callOrElse(
        [&] { return encodeOrThrow(cloud, sensor_to_world, receivers, bytes); },
        outOfMemoryStatus<SensorNodeStatus>,
        [](const std::string& reason) {
          return SensorNodeStatus(SensorNodeCode::EncodingFailed, reason);
        });
  }

  void
  countMissed(std::size_t clouds)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    health_.clouds_missed += clouds;
  }

  void
  countMissedBefore(Time stamp)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    health_.clouds_missed += stamp_gaps_.missingBefore(stamp);
  }

  void
  countLatestTransform()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.latest_transforms;
  }

  SensorNodeSettings
  settings() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return settings_;
  }

  SenderHealth
  health() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    SenderHealth health = health_;
    if (node_)
      health.node = node_->statistics();
    return health;
  }

private:
  /** \brief True if parameters differ in max_rate alone, which both have set. */
  static bool
  isSameButForRate(const ParameterValues& before, ParameterValues after)
  {
    const auto was = before.find("max_rate");
    ParameterValue& is = after["max_rate"];
    const ParameterValue unset(0.0);
    if (was == before.end() || was->second == unset || is == unset)
      return false;
    is = was->second;
    return after == before;
  }

  SensorNodeStatus
  encodeOrThrow(const pcl::PCLPointCloud2& cloud,
                const std::optional<WorldPose>& sensor_to_world,
                std::size_t receivers,
                std::vector<std::uint8_t>& bytes)
  {
    ++health_.clouds;
    health_.last_arrival = steadyTime();
    if (receivers > receivers_)
      requests_.addReceiver();
    receivers_ = receivers;
    if (SensorNodeStatus status = checkTransform(cloud, sensor_to_world); !status.ok())
      return status;
    makeNode(cloud);
    if (requests_.take())
      node_->requestIFrame();
    SensorNodeStatus status = node_->encode(cloud, sensor_to_world, bytes);
    if (sensor_to_world && status.code() != SensorNodeCode::InvalidTransform)
      frame_of_last_transform_ = cloud.header.frame_id;
    if (!status.hasFrame())
      return status;
    requests_.countFrame();
    // Without memory for it the frame goes out without the remark.
    return callOrElse([&] { return withLeftOut(status, cloud); },
                      [&] { return status; });
  }

  /** \brief The status of a frame, with what is left out of clouds if that is new. */
  SensorNodeStatus
  withLeftOut(const SensorNodeStatus& status, const pcl::PCLPointCloud2& cloud)
  {
    std::string left_out = describeLeftOut(cloud, settings_);
    if (left_out == left_out_)
      return status;
    left_out_ = std::move(left_out);
    const std::string separator =
        status.message().empty() || left_out_.empty() ? "" : "; ";
    return {status.code(),
            SettingText{status.text().marked + separator +
                        SettingText::of(left_out_).marked}};
  }

  /** \brief Refuses a cloud for which the node would use another frame's transform. */
  SensorNodeStatus
  checkTransform(const pcl::PCLPointCloud2& cloud,
                 const std::optional<WorldPose>& sensor_to_world)
  {
    if (sensor_to_world || cloud.header.frame_id == frame_of_last_transform_)
      return {};
    ++health_.clouds_of_other_frame;
    return {SensorNodeCode::NoTransform,
            "there is no transform from '" + cloud.header.frame_id + "' to '" +
                settings_.global_frame + "'; the cloud was not encoded"};
  }

  /** \brief Creates the node for the first cloud, or where the automatic law is
   * another one. */
  void
  makeNode(const pcl::PCLPointCloud2& cloud)
  {
    const bool has_intensities = hasReadableField(cloud, settings_.intensity_field);
    if (node_ && has_intensities == has_intensities_)
      return;
    const IntensityLaw law = settings_.law;
    readEncodingParameters(values_, has_intensities, settings_);
    has_intensities_ = has_intensities;
    if (!node_ || settings_.law != law)
      node_.emplace(settings_);
  }

  mutable std::mutex mutex_; // guards everything below
  ParameterValues values_ = defaultsOf(encodingParameters());
  SensorNodeSettings settings_;
  std::optional<SensorNode> node_; // none before the first cloud of a stream
  bool has_intensities_ = false;   // of the clouds of node_
  std::string frame_of_last_transform_;
  std::string left_out_; // see describeLeftOut(); of the last cloud
  io::IFrameRequests requests_;
  std::size_t receivers_ = 0; // of the last cloud
  StampGaps stamp_gaps_;
  SenderHealth health_; // except for that of node_
};

CloudSender::CloudSender(const SensorNodeSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

CloudSender::~CloudSender() = default;

std::string
CloudSender::setParameters(const ParameterValues& values)
{
  return implementation_->setParameters(values);
}

void
CloudSender::requestIFrame()
{
  implementation_->requestIFrame();
}

SensorNodeStatus
CloudSender::encode(const pcl::PCLPointCloud2& cloud,
                    const std::optional<WorldPose>& sensor_to_world,
                    std::size_t receivers,
                    std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(cloud, sensor_to_world, receivers, bytes);
}

void
CloudSender::countMissed(std::size_t clouds)
{
  implementation_->countMissed(clouds);
}

void
CloudSender::countMissedBefore(Time stamp)
{
  implementation_->countMissedBefore(stamp);
}

void
CloudSender::countLatestTransform()
{
  implementation_->countLatestTransform();
}

SensorNodeSettings
CloudSender::settings() const
{
  return implementation_->settings();
}

SenderHealth
CloudSender::health() const
{
  return implementation_->health();
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
