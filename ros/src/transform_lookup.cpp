// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "transform_lookup.h"

#include "message_conversions.h"

#include <tf2_eigen/tf2_eigen.h>

#include <utility>

namespace pcl_ext_ros1 {

TransformLookup::TransformLookup(std::string global_frame, double timeout)
: global_frame_(std::move(global_frame))
, timeout_(static_cast<std::int64_t>(1e9 * timeout))
{}

pcl_ext::nodes::FoundTransform
TransformLookup::toGlobalFrame(const std_msgs::Header& header) const
{
  const auto lookUp = [this](const std::string& frame, const ros::Time& time) {
    return pcl_ext::WorldPose(
        tf2::transformToEigen(buffer_.lookupTransform(global_frame_, frame, time)));
  };
  return pcl_ext::nodes::findTransform(
      header.frame_id,
      global_frame_,
      [&](const std::string& frame) {
        const auto wait = pcl_ext::nodes::transformWait(
            timeout_, toNodeTime(header.stamp), rosTimeNow());
        // TF2's own wait does not end while simulated time stands still.
        const ros::WallTime deadline =
            ros::WallTime::now() + ros::WallDuration().fromNSec(wait.count());
        while (!buffer_.canTransform(global_frame_, frame, header.stamp) &&
               ros::WallTime::now() < deadline)
          ros::WallDuration(0.002).sleep();
        return lookUp(frame, header.stamp);
      },
      [&](const std::string& frame) { return lookUp(frame, ros::Time(0)); });
}

} // namespace pcl_ext_ros1
