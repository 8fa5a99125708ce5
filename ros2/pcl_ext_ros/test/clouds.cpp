// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds.h"

#include <Eigen/Geometry>

#include <sensor_msgs/point_cloud2_iterator.hpp>
#include <tf2_eigen/tf2_eigen.hpp>

#include <cmath>
#include <limits>
#include <random>

namespace pcl_ext_ros::test {

namespace {

/** \brief A number within [begin, end). The standard distributions differ between
 * standard libraries. */
float
between(std::mt19937& random, float begin, float end)
{
  constexpr std::uint32_t numbers = 1u << 20;
  return begin + (end - begin) * static_cast<float>(random() % numbers) /
                     static_cast<float>(numbers);
}

} // namespace

sensor_msgs::msg::PointCloud2
makeCloud(std::uint32_t number,
          const std::string& frame_id,
          const rclcpp::Time& stamp,
          std::size_t points)
{
  std::mt19937 random(number + 1);
  const float ball_x = -0.8f + 0.05f * static_cast<float>(number % 32);
  sensor_msgs::msg::PointCloud2 cloud;
  cloud.header.frame_id = frame_id;
  cloud.header.stamp = stamp;
  cloud.is_dense = false;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(points);
  sensor_msgs::PointCloud2Iterator<float> point(cloud, "x");
  for (std::size_t i = 0; i < points; ++i, ++point) {
    const float x = between(random, -1.0f, 1.0f);
    const float y = between(random, -1.0f, 1.0f);
    float z = 3.0f + between(random, -0.02f, 0.02f);
    const float from_centre = std::hypot(x - ball_x, y);
    if (from_centre < 0.3f)
      z = 2.0f - std::sqrt(0.09f - from_centre * from_centre);
    if (i % 97 == 96)
      z = std::numeric_limits<float>::quiet_NaN();
    point[0] = x;
    point[1] = y;
    point[2] = z;
  }
  return cloud;
}

pcl_ext::WorldPose
samplePose(double shift)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(0.513 + shift, -0.277, 1.391));
  pose.rotate(
      Eigen::AngleAxisd(0.7 + shift, Eigen::Vector3d(0.2, -0.9, 0.4).normalized()));
  return pcl_ext::WorldPose(tf2::transformToEigen(tf2::eigenToTransform(pose)));
}

geometry_msgs::msg::TransformStamped
toMessage(const std::string& frame_id,
          const pcl_ext::WorldPose& pose,
          const rclcpp::Time& stamp)
{
  auto message = tf2::eigenToTransform(Eigen::Isometry3d(pose));
  message.header.stamp = stamp;
  message.header.frame_id = "world";
  message.child_frame_id = frame_id;
  return message;
}

} // namespace pcl_ext_ros::test
