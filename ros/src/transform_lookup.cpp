#include "transform_lookup.h"

#include <pcl_ext/nodes/cloud_messages.h>

#include "message_conversions.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace pcl_ext_ros1 {

TransformLookup::TransformLookup(std::string global_frame, double timeout)
: global_frame_(std::move(global_frame))
, timeout_(static_cast<std::int64_t>(1e9 * timeout))
{}

FoundTransform
TransformLookup::toGlobalFrame(const std_msgs::Header& header) const
{
  FoundTransform found;
  const std::string frame_id = pcl_ext::nodes::withoutLeadingSlash(header.frame_id);
  if (frame_id == global_frame_) {
    found.pose = pcl_ext::WorldPose::Identity();
    return found;
  }
  if (frame_id.empty()) {
    // TF2 prints a line for each lookup of an empty frame.
    found.failure = "the frame_id is empty";
    return found;
  }
  // The timeout starts at the stamp, so that clouds in the queue do not add up their
  // waits. ros::Duration is not used, as it throws for stamps that are decades off.
  const auto age = rosTimeNow() - toNodeTime(header.stamp);
  const auto wait = std::clamp(timeout_ - age, pcl_ext::nodes::Time(0), timeout_);
  try {
    // TF2's own wait does not end while simulated time stands still.
    const ros::WallTime deadline =
        ros::WallTime::now() + ros::WallDuration().fromNSec(wait.count());
    while (!buffer_.canTransform(global_frame_, frame_id, header.stamp) &&
           ros::WallTime::now() < deadline)
      ros::WallDuration(0.002).sleep();
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, header.stamp));
    return found;
  }
  catch (const std::exception& failure) { // of TF, or of ROS's time arithmetic
    found.failure = failure.what();
  }
  try {
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, ros::Time(0)));
    found.is_latest = true;
  }
  catch (const std::exception&) {
    // The message of the first failure is kept.
  }
  return found;
}

} // namespace pcl_ext_ros1
