#include "merged_map.h"

#include <pcl_ext/nodes/octomap_insertion.h>

#include "health_messages.h"
#include "message_conversions.h"

#include <ros/console.h>

#include <filesystem>
#include <fstream>

namespace pcl_ext_ros {

MergedMap::MergedMap(const DecompressorParameters& parameters)
: parameters_(parameters.map), tree_(parameters.node.resolution)
{
  for (const StreamParameters& stream : parameters.streams)
    if (!stream.sensor_frame.empty() && !transforms_)
      transforms_.emplace(parameters.global_frame, parameters_.tf_timeout);
}

void
MergedMap::insertLatest(const std::string& stream,
                        const std::string& sensor_frame,
                        Rays rays,
                        const pcl_ext::nodes::CentralNode& central_node)
{
  const auto frame = central_node.latestVoxels(stream, voxels_);
  std::size_t& last_frame = last_frames_[stream];
  // A frame that is inserted twice would count as further evidence.
  if (!frame || frame->number == last_frame)
    return;
  last_frame = frame->number;
  std::optional<octomap::point3d> origin;
  if (rays == Rays::Yes && !sensor_frame.empty())
    origin = findOrigin(sensor_frame, frame->stamp);
  constexpr bool lazily = true; // completeRound() updates the inner nodes
  pcl_ext::nodes::insertVoxels(
      voxels_, static_cast<float>(parameters_.full_intensity), origin, tree_, lazily);
}

std::optional<octomap::point3d>
MergedMap::findOrigin(const std::string& sensor_frame, pcl_ext::nodes::Time stamp) const
{
  std_msgs::Header header;
  header.stamp = toRosTime(stamp);
  header.frame_id = sensor_frame;
  const FoundTransform transform = transforms_->toGlobalFrame(header);
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

void
MergedMap::completeRound()
{
  tree_.updateInnerOccupancy();
  tree_.prune();
}

MergedMap::Written
MergedMap::write() const
{
  const std::string unfinished = unfinishedPath(parameters_.path);
  bool is_complete = false;
  {
    // By stream, as OctoMap's write by name does not report a full disk.
    std::ofstream stream(unfinished, std::ios::binary);
    is_complete = stream.is_open() && tree_.write(stream) && stream.flush().good();
  }
  std::error_code failure;
  if (is_complete)
    std::filesystem::rename(unfinished, parameters_.path, failure);
  if (is_complete && !failure)
    return {true,
            std::to_string(tree_.size()) + " nodes written to " + parameters_.path};
  std::filesystem::remove(unfinished, failure);
  return {false, "The map could not be written to " + parameters_.path};
}

} // namespace pcl_ext_ros
