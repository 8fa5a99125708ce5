#include <pcl_ext/nodes/cloud_sender.h>
#include <pcl_ext/nodes/i_frame_requests.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"

#include <algorithm>
#include <mutex>
#include <optional>

namespace pcl_ext {
namespace nodes {

class CloudSender::Implementation {
public:
  std::string
  setParameters(const ParameterValues& values)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ParameterValues changed = values_;
    for (const auto& [name, value] : values)
      changed[name] = value;
    if (changed == values_)
      return {};
    // Whichever of the two laws auto becomes.
    for (const bool has_intensities : {false, true}) {
      SensorNodeSettings settings;
      if (std::string fault =
              readEncodingParameters(changed, has_intensities, settings);
          !fault.empty())
        return fault;
    }
    values_ = std::move(changed);
    node_.reset();
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
         std::size_t receivers,
         std::vector<std::uint8_t>& bytes)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes.clear();
    return callOrElse([&] { return encodeOrThrow(cloud, receivers, bytes); },
                      outOfMemoryStatus<SensorNodeStatus>,
                      [](const std::string& reason) {
                        return SensorNodeStatus(SensorNodeCode::EncodingFailed, reason);
                      });
  }

  io::StreamFormat
  format() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    SensorNodeSettings settings;
    readEncodingParameters(values_, false, settings);
    return settings.compression.format;
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
  SensorNodeStatus
  encodeOrThrow(const pcl::PCLPointCloud2& cloud,
                std::size_t receivers,
                std::vector<std::uint8_t>& bytes)
  {
    ++health_.clouds;
    health_.last_arrival = steadyTime();
    if (receivers > receivers_)
      requests_.add();
    receivers_ = receivers;
    makeNode(cloud);
    if (requests_.take())
      node_->requestIFrame();
    const SensorNodeStatus status =
        node_->encode(cloud, WorldPose(WorldPose::Identity()), bytes);
    if (status.hasFrame())
      requests_.countFrame();
    return status;
  }

  /** \brief Creates the node for the first cloud, or where auto is another law now. */
  void
  makeNode(const pcl::PCLPointCloud2& cloud)
  {
    SensorNodeSettings settings;
    readEncodingParameters(values_, false, settings);
    const bool has_intensities =
        std::any_of(cloud.fields.begin(),
                    cloud.fields.end(),
                    [&settings](const pcl::PCLPointField& field) {
                      return field.name == settings.intensity_field;
                    });
    if (node_ && has_intensities == has_intensities_)
      return;
    readEncodingParameters(values_, has_intensities, settings);
    node_.emplace(settings);
    has_intensities_ = has_intensities;
  }

  mutable std::mutex mutex_; // guards everything below
  ParameterValues values_ = defaultsOf(encodingParameters());
  std::optional<SensorNode> node_; // none before the first cloud of a stream
  bool has_intensities_ = false;   // of the clouds of node_
  IFrameRequests requests_;
  std::size_t receivers_ = 0; // of the last cloud
  SenderHealth health_;       // but for that of node_
};

CloudSender::CloudSender() : implementation_(std::make_unique<Implementation>()) {}
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
                    std::size_t receivers,
                    std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(cloud, receivers, bytes);
}

io::StreamFormat
CloudSender::format() const
{
  return implementation_->format();
}

SenderHealth
CloudSender::health() const
{
  return implementation_->health();
}

} // namespace nodes
} // namespace pcl_ext
