// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds and transforms of a sensor, the same in every run.
 */
#pragma once

#include <pcl_ext/rigid_pose.h>

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <rclcpp/duration.hpp>
#include <rclcpp/time.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext_ros::test {

/** \brief A noisy wall of 2 m by 2 m, 3 m before the sensor, and a ball that moves in
 * front of it. Some points are not finite, as in the clouds of depth cameras.
 * \param[in] number of the cloud in its stream; decides the points
 * \param[in] frame_id of the sensor
 * \param[in] stamp of the cloud
 */
sensor_msgs::msg::PointCloud2
makeCloud(std::uint32_t number,
          const std::string& frame_id,
          const rclcpp::Time& stamp,
          std::size_t points = 4000);

/** \brief The last multiple of a period until a time. */
inline rclcpp::Time
roundedDown(const rclcpp::Time& time, const rclcpp::Duration& period)
{
  return rclcpp::Time(time.nanoseconds() - time.nanoseconds() % period.nanoseconds(),
                      time.get_clock_type());
}

/** \brief A rotation about an oblique axis and a translation by fractions of a voxel,
 * after the rounding of a message.
 * \param[in] shift added to the translation along x, metres, and to the angle, radians
 */
pcl_ext::WorldPose
samplePose(double shift);

/** \brief A pose frame_id -> world as a message. */
geometry_msgs::msg::TransformStamped
toMessage(const std::string& frame_id,
          const pcl_ext::WorldPose& pose,
          const rclcpp::Time& stamp);

} // namespace pcl_ext_ros::test
