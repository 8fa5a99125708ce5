#include "central_map.h"

#include "health_messages.h"
#include "message_conversions.h"

#include <algorithm>
#include <iostream>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::detail::MergedMap;

CentralMap::CentralMap(const ros::NodeHandle& private_node,
                       const DecompressorParameters& parameters,
                       const pcl_ext::nodes::CentralNode& central_node)
: path_(valueOf<std::string>(parameters.node, "map_path"))
, central_node_(central_node)
, node_(private_node)
, spinner_(1, &queue_)
{
  node_.setCallbackQueue(&queue_);
  service_ = node_.advertiseService("write_map", &CentralMap::write, this);
  if (path_.empty())
    return;
  map_.emplace(valueOf<double>(parameters.node, "resolution"),
               valueOf<double>(parameters.node, "map_full_intensity"));
  const bool takes_rays = std::any_of(
      parameters.streams.begin(),
      parameters.streams.end(),
      [](const StreamParameters& stream) { return !stream.sensor_frame.empty(); });
  if (takes_rays)
    transforms_.emplace(parameters.global_frame, parameters.tf_timeout);
  timer_ = node_.createWallTimer(
      ros::WallDuration(1.0 / valueOf<double>(parameters.node, "map_rate")),
      boost::function<void(const ros::WallTimerEvent&)>(
          [this](const ros::WallTimerEvent&) { update(Rays::Yes); }));
}

int
CentralMap::finish()
{
  spinner_.stop();
  if (!map_)
    return 0;
  update(Rays::No);
  // ROS's console is shut down.
  if (map_->tree().size() == 0) {
    std::cout << "The map is empty and is not written\n";
    return 0;
  }
  const MergedMap::Written written = map_->write(path_);
  (written.ok ? std::cout : std::cerr) << written.message << '\n';
  return written.ok ? 0 : 1;
}

void
CentralMap::update(Rays rays)
{
  for (const auto& [topic, sensor_frame] : streams_) {
    if (rays == Rays::Yes && !ros::ok())
      break; // finish() inserts the others
    MergedMap::FindSensor find;
    if (rays == Rays::Yes && !sensor_frame.empty())
      find = [this, &frame = sensor_frame](pcl_ext::nodes::Time stamp) {
        return findSensor(frame, stamp);
      };
    map_->insertLatest(topic, find, central_node_);
  }
  map_->completeRound();
  nodes_ = map_->tree().size();
}

std::optional<octomap::point3d>
CentralMap::findSensor(const std::string& sensor_frame,
                       pcl_ext::nodes::Time stamp) const
{
  std_msgs::Header header;
  header.stamp = toRosTime(stamp);
  header.frame_id = sensor_frame;
  const pcl_ext::nodes::FoundTransform transform = transforms_->toGlobalFrame(header);
  if (!transform.pose) {
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "The map takes no rays from %s: %s",
                      sensor_frame.c_str(),
                      transform.failure.c_str());
    return std::nullopt;
  }
  const Eigen::Vector3f position = transform.pose->translation().cast<float>();
  return octomap::point3d(position.x(), position.y(), position.z());
}

bool
CentralMap::write(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response)
{
  if (!map_) {
    response.success = 0;
    response.message = "There is no map, as ~map_path is not set";
    return true;
  }
  update(Rays::Yes);
  const MergedMap::Written written = map_->write(path_);
  response.success = written.ok ? 1 : 0;
  response.message = written.message;
  return true;
}

} // namespace pcl_ext_ros1
