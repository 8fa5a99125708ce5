#include "transform_lookup.h"

#include "message_conversions.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <utility>

namespace pcl_ext_ros {

TransformLookup::TransformLookup(std::string global_frame, ros::Duration timeout)
: global_frame_(std::move(global_frame)), timeout_(timeout)
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
  try {
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, header.stamp, timeout_));
    return found;
  }
  catch (const tf2::TransformException& failure) {
    found.failure = failure.what();
  }
  try {
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, ros::Time(0)));
    found.is_latest = true;
  }
  catch (const tf2::TransformException&) {
    // Says the same as the first failure, which is kept.
  }
  return found;
}

} // namespace pcl_ext_ros
