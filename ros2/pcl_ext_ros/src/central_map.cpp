// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "central_map.h"

#include <pcl_ext/nodes/impl/cloud_messages.h>

#include "weak_callback.h"

#include <chrono>
#include <exception>
#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::detail::MergedMap;
using std_srvs::srv::Trigger;

CentralMap::CentralMap(rclcpp::Node& node,
                       const pcl_ext::nodes::ParameterValues& values,
                       Streams streams,
                       std::shared_ptr<const pcl_ext::nodes::CentralNode> central_node)
: logger_(node.get_logger())
, clock_(node.get_clock())
, global_frame_(
      pcl_ext::nodes::withoutLeadingSlash(valueOf<std::string>(values, "global_frame")))
, path_(valueOf<std::string>(values, "map_path"))
, fault_(path_.empty() ? "" : MergedMap::faultOf("map_path", path_))
, seconds_between_updates_(1.0 / valueOf<double>(values, "map_rate"))
, full_intensity_(valueOf<double>(values, "map_full_intensity"))
, map_(valueOf<double>(values, "resolution"))
, streams_(std::move(streams))
, central_node_(std::move(central_node))
, publisher_(node)
{}

void
CentralMap::prepareFor(rclcpp::Node& node, const Stream& stream)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!stream.sensorFrame().empty() && !transforms_)
    transforms_.emplace(node, global_frame_);
}

void
CentralMap::connect(rclcpp::Node& node)
{
  const std::weak_ptr<CentralMap> self = weak_from_this();
  group_ = node.create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
  timer_ =
      node.create_wall_timer(std::chrono::duration<double>(seconds_between_updates_),
                             weakCallback(self, &CentralMap::updateOnTimer),
                             group_);
  service_ = node.create_service<Trigger>(
      "~/write_map",
      [self](const Trigger::Request::SharedPtr&,
             const Trigger::Response::SharedPtr& response) {
        if (const auto alive = self.lock())
          alive->write(*response);
      },
      rclcpp::ServicesQoS(),
      group_);
}

void
CentralMap::updateOnTimer()
{
  const bool has_subscribers = publisher_.hasSubscribers();
  if (!has_subscribers && path_.empty())
    return;
  const std::lock_guard<std::mutex> lock(mutex_);
  update(Rays::Yes);
  if (!has_subscribers)
    return;
  std_msgs::msg::Header header;
  header.stamp = clock_->now();
  header.frame_id = global_frame_;
  publisher_.publish(header, map_.tree());
}

void
CentralMap::update(Rays rays)
{
  for (const auto& stream : streams_()) {
    MergedMap::FindSensor find;
    if (rays == Rays::Yes && !stream->sensorFrame().empty())
      find = [&](pcl_ext::nodes::Time stamp) {
        return findSensor(stream->sensorFrame(), stamp);
      };
    map_.insertLatest(stream->topic(), full_intensity_, find, *central_node_);
  }
  map_.completeRound();
  if (const std::string fault = map_.faultOfFrames();
      fault != std::exchange(told_fault_, fault))
    warnings_.warn(fault);
  nodes_ = map_.tree().size();
}

std::optional<octomap::point3d>
CentralMap::findSensor(const std::string& sensor_frame, pcl_ext::nodes::Time stamp)
{
  std_msgs::msg::Header header;
  header.stamp = rclcpp::Time(stamp.count());
  header.frame_id = sensor_frame;
  const pcl_ext::nodes::FoundTransform transform = transforms_->find(header);
  if (!transform.pose) {
    warnings_.warn("The map takes no rays from " + sensor_frame + ": " +
                   transform.failure);
    return std::nullopt;
  }
  const Eigen::Vector3f position = transform.pose->translation().cast<float>();
  return octomap::point3d(position.x(), position.y(), position.z());
}

void
CentralMap::write(Trigger::Response& response)
{
  response.success = false;
  if (path_.empty()) {
    response.message = "There is no map, as map_path is not set";
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  update(Rays::Yes);
  const MergedMap::Written written = map_.write(path_);
  response.success = written.ok;
  response.message = written.message;
}

void
CentralMap::finish() noexcept
{
  try {
    if (path_.empty())
      return;
    const std::lock_guard<std::mutex> lock(mutex_);
    update(Rays::No);
    if (map_.tree().size() == 0) {
      RCLCPP_INFO(logger_, "The map is empty and is not written");
      return;
    }
    const MergedMap::Written written = map_.write(path_);
    if (written.ok)
      RCLCPP_INFO(logger_, "%s", written.message.c_str());
    else
      RCLCPP_ERROR(logger_, "%s", written.message.c_str());
  }
  catch (const std::exception& failure) {
    RCLCPP_ERROR(logger_, "The map is not written: %s", failure.what());
  }
}

} // namespace pcl_ext_ros
