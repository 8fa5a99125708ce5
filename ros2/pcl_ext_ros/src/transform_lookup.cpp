#include "transform_lookup.h"

#include <pcl_ext/nodes/cloud_messages.h>

#include <tf2_eigen/tf2_eigen.hpp>
#include <tf2_ros/buffer_interface.h>

#include <exception>
#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::withoutLeadingSlash;

TransformLookup::TransformLookup(rclcpp::Node& node, std::string global_frame)
: global_frame_(std::move(global_frame))
, buffer_(node.get_clock())
, listener_(buffer_, &node)
{}

bool
TransformLookup::isKnown(const std_msgs::msg::Header& header) const
{
  const std::string frame_id = withoutLeadingSlash(header.frame_id);
  if (frame_id == global_frame_)
    return true;
  std::string reason; // without it tf2 prints a line each time
  return !frame_id.empty() &&
         buffer_.canTransform(
             global_frame_, frame_id, tf2_ros::fromMsg(header.stamp), &reason);
}

FoundTransform
TransformLookup::find(const std_msgs::msg::Header& header) const
{
  FoundTransform found;
  const std::string frame_id = withoutLeadingSlash(header.frame_id);
  if (frame_id == global_frame_) {
    found.pose = pcl_ext::WorldPose::Identity();
    return found;
  }
  if (frame_id.empty()) { // tf2 prints a line for each lookup of one
    found.failure = "the frame_id is empty";
    return found;
  }
  try {
    found.pose = tf2::transformToEigen(buffer_.lookupTransform(
        global_frame_, frame_id, tf2_ros::fromMsg(header.stamp)));
    return found;
  }
  catch (const std::exception& failure) {
    found.failure = failure.what();
  }
  try {
    found.pose = tf2::transformToEigen(
        buffer_.lookupTransform(global_frame_, frame_id, tf2::TimePointZero));
    found.is_latest = true;
  }
  catch (const std::exception&) {
    // The message of the first failure is kept.
  }
  return found;
}

} // namespace pcl_ext_ros
