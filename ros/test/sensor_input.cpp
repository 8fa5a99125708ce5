#include "sensor_input.h"

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>

#include <pcl_conversions/pcl_conversions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <limits>
#include <random>

namespace pcl_ext_ros1 {
namespace test {

namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/** \brief A number within [begin, end). The standard distributions differ between
 * standard libraries. */
float
between(std::mt19937& random, float begin, float end)
{
  constexpr std::uint32_t numbers = 1u << 20;
  return begin + (end - begin) * static_cast<float>(random() % numbers) /
                     static_cast<float>(numbers);
}

void
setAttributes(std::mt19937&, pcl::PointXYZ&)
{}

void
setAttributes(std::mt19937& random, pcl::PointXYZI& point)
{
  point.intensity = static_cast<float>(random() % 200);
}

void
setAttributes(std::mt19937& random, pcl::PointXYZRGB& point)
{
  point.rgba = static_cast<std::uint32_t>(random());
}

} // namespace

ros::Time
stampOf(std::uint32_t number)
{
  // In the future, as nodes do not wait for transforms at old stamps.
  constexpr std::uint32_t seconds_ahead = 100000;
  static const std::uint64_t first_second = ros::Time::now().sec + seconds_ahead;
  ros::Time stamp;
  stamp.fromNSec(first_second * 1000000000u + 123456789u + 33333333ull * number);
  return stamp;
}

template <typename PointT>
sensor_msgs::PointCloud2
makeCloud(std::uint32_t number, const std::string& frame_id, std::size_t points)
{
  std::mt19937 random(number + 1);
  const float ball_x = -0.8f + 0.05f * static_cast<float>(number % 32);
  pcl::PointCloud<PointT> cloud;
  cloud.is_dense = false;
  for (std::size_t i = 0; i < points; ++i) {
    PointT point;
    point.x = between(random, -1.0f, 1.0f);
    point.y = between(random, -1.0f, 1.0f);
    point.z = 3.0f + between(random, -0.02f, 0.02f);
    const float from_centre = std::hypot(point.x - ball_x, point.y);
    if (from_centre < 0.3f)
      point.z = 2.0f - std::sqrt(0.09f - from_centre * from_centre);
    if (i % 97 == 96)
      point.z = nan;
    setAttributes(random, point);
    cloud.push_back(point);
  }
  sensor_msgs::PointCloud2 message;
  pcl::toROSMsg(cloud, message);
  message.header.frame_id = frame_id;
  message.header.stamp = stampOf(number);
  return message;
}

template sensor_msgs::PointCloud2
makeCloud<pcl::PointXYZ>(std::uint32_t, const std::string&, std::size_t);
template sensor_msgs::PointCloud2
makeCloud<pcl::PointXYZI>(std::uint32_t, const std::string&, std::size_t);
template sensor_msgs::PointCloud2
makeCloud<pcl::PointXYZRGB>(std::uint32_t, const std::string&, std::size_t);

pcl_ext::WorldPose
samplePose(double shift)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(0.513 + shift, -0.277, 1.391));
  pose.rotate(
      Eigen::AngleAxisd(0.7 + shift, Eigen::Vector3d(0.2, -0.9, 0.4).normalized()));
  return throughMessage(pcl_ext::WorldPose(pose));
}

geometry_msgs::TransformStamped
toMessage(const std::string& frame_id,
          const pcl_ext::WorldPose& pose,
          const ros::Time& stamp)
{
  geometry_msgs::TransformStamped message =
      tf2::eigenToTransform(Eigen::Isometry3d(pose));
  message.header.stamp = stamp;
  message.header.frame_id = "world";
  message.child_frame_id = frame_id;
  return message;
}

pcl_ext::WorldPose
throughMessage(const pcl_ext::WorldPose& pose)
{
  return pcl_ext::WorldPose(tf2::transformToEigen(toMessage("", pose)));
}

} // namespace test
} // namespace pcl_ext_ros1
