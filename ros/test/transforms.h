/** \file
 * \brief TF as the test sends it.
 */
#pragma once

#include <pcl_ext/rigid_pose.h>

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <string>

namespace pcl_ext_ros {
namespace test {

/** \brief A pose that is about no axis, and a whole number of voxels off the origin in
 * none.
 * \param[in] shift metres along x, with a turn of as many radians
 */
pcl_ext::WorldPose
samplePose(double shift);

/** \brief A pose as a message.
 * \param[in] frame_id of the sensor
 * \param[in] pose frame_id -> world
 * \param[in] stamp of the transform
 */
geometry_msgs::TransformStamped
toMessage(const std::string& frame_id,
          const pcl_ext::WorldPose& pose,
          const ros::Time& stamp = ros::Time());

/** \brief The pose that a message stands for, with the rounding of its quaternion. */
pcl_ext::WorldPose
throughMessage(const pcl_ext::WorldPose& pose);

/** \brief Transforms that hold for all times. One at a time: what they send is latched,
 * and a program can latch one message of a topic only. */
class StaticTransforms {
public:
  void
  set(const std::string& frame_id, const pcl_ext::WorldPose& pose)
  {
    send(toMessage(frame_id, pose, ros::Time::now()));
  }

  void
  send(const geometry_msgs::TransformStamped& transform)
  {
    broadcaster_.sendTransform(transform);
  }

private:
  tf2_ros::StaticTransformBroadcaster broadcaster_;
};

} // namespace test
} // namespace pcl_ext_ros
