/** \file
 * \brief Clouds and transforms of a sensor, the same in every run.
 */
#pragma once

#include <pcl_ext/rigid_pose.h>

#include <pcl/point_types.h>

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext_ros1 {
namespace test {

/** \brief The stamp of the nth cloud. Neither a float nor microseconds can represent
 * its nanoseconds. */
ros::Time
stampOf(std::uint32_t number);

/** \brief A noisy wall of 2 m by 2 m, 3 m before the sensor, and a ball that moves in
 * front of it. Some points are not finite, as in the clouds of depth cameras.
 * \tparam PointT pcl::PointXYZ, PointXYZI or PointXYZRGB
 * \param[in] number of the cloud in its stream; decides points and stamp
 * \param[in] frame_id of the sensor
 * \param[in] points number of points
 */
template <typename PointT>
sensor_msgs::PointCloud2
makeCloud(std::uint32_t number, const std::string& frame_id, std::size_t points = 6000);

/** \brief A rotation about an oblique axis and a translation by fractions of a voxel.
 * \param[in] shift added to the translation along x, metres, and to the angle, radians
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

/** \brief A pose after the rounding of a message's quaternion. */
pcl_ext::WorldPose
throughMessage(const pcl_ext::WorldPose& pose);

/** \brief Static transforms. One object at a time: its message is latched, and a
 * program can latch one message of a topic only. */
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
} // namespace pcl_ext_ros1
