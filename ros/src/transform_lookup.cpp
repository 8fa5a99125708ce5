#include "transform_lookup.h"

#include "message_conversions.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace pcl_ext_ros {

TransformLookup::TransformLookup(std::string global_frame, double timeout)
: global_frame_(std::move(global_frame))
, timeout_(static_cast<std::int64_t>(1e9 * timeout))
{}

FoundTransform
TransformLookup::toGlobalFrame(const std_msgs::Header& header) const
{
  FoundTransform found;
  const std::string frame_id = withoutLeadingSlash(header.frame_id);
  if (frame_id == global_frame_) {
    found.pose = pcl_ext::WorldPose::Identity();
    return found;
  }
  if (frame_id.empty()) {
    // TF2 would print a line of its own for every 10 ms that it waits.
    found.failure = "there is no frame_id";
    return found;
  }
  // From the stamp on, so that clouds that queued up meanwhile do not wait once more.
  // Not as a ros::Duration, which throws where a stamp is decades off.
  const auto age = rosTimeNow() - toNodeTime(header.stamp);
  const auto wait = std::clamp(timeout_ - age, pcl_ext::nodes::Time(0), timeout_);
  try {
    // Not TF2's own wait, which never ends while simulated time stands still.
    const ros::WallTime deadline =
        ros::WallTime::now() + ros::WallDuration().fromNSec(wait.count());
    while (!buffer_.canTransform(global_frame_, frame_id, header.stamp) &&
           ros::WallTime::now() < deadline)
      ros::WallDuration(0.002).sleep();
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, header.stamp));
    return found;
  }
  catch (const std::exception& failure) { // TF's, or of ROS's arithmetic with times
    found.failure = failure.what();
  }
  try {
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, ros::Time(0)));
    found.is_latest = true;
  }
  catch (const std::exception&) {
    // Says the same as the first failure, which is kept.
  }
  return found;
}

} // namespace pcl_ext_ros
