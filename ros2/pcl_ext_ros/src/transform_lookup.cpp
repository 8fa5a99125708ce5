// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "transform_lookup.h"

#include <pcl_ext_ros_common/tf_node.hpp>
#include <tf2_eigen/tf2_eigen.hpp>
#include <tf2_ros/buffer_interface.hpp>

#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::withoutLeadingSlash;

TransformLookup::TransformLookup(rclcpp::Node& node, std::string global_frame)
: global_frame_(std::move(global_frame))
, buffer_(node.get_clock())
, listener_(buffer_, pcl_ext_ros_common::tfNode<tf2_ros::TransformListener>(node))
{}

bool
TransformLookup::isKnown(const std_msgs::msg::Header& header) const
{
  if (!pcl_ext::nodes::needsTransform(header.frame_id, global_frame_))
    return true;
  std::string reason; // without it tf2 prints a line each time
  return buffer_.canTransform(global_frame_,
                              withoutLeadingSlash(header.frame_id),
                              tf2_ros::fromMsg(header.stamp),
                              &reason);
}

pcl_ext::nodes::FoundTransform
TransformLookup::find(const std_msgs::msg::Header& header) const
{
  const auto at = [this](const tf2::TimePoint& time) {
    return [this, time](const std::string& frame) {
      return pcl_ext::WorldPose(
          tf2::transformToEigen(buffer_.lookupTransform(global_frame_, frame, time)));
    };
  };
  return pcl_ext::nodes::findTransform(header.frame_id,
                                       global_frame_,
                                       at(tf2_ros::fromMsg(header.stamp)),
                                       at(tf2::TimePointZero));
}

} // namespace pcl_ext_ros
