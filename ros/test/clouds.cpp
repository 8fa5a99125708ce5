#include "clouds.h"

#include <pcl/point_cloud.h>

#include <pcl_conversions/pcl_conversions.h>

#include <cmath>
#include <limits>
#include <random>

namespace pcl_ext_ros {
namespace test {

namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/** \brief A number within [begin, end), the same with every standard library. */
float
between(std::mt19937& random, float begin, float end)
{
  constexpr float steps = 1 << 20;
  return begin + (end - begin) * static_cast<float>(random() % (1u << 20)) / steps;
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
  // Nodes wait for transforms at stamps that are ahead, and not at those long gone.
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
    const float beside_ball = std::hypot(point.x - ball_x, point.y);
    if (beside_ball < 0.3f)
      point.z = 2.0f - std::sqrt(0.09f - beside_ball * beside_ball);
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

} // namespace test
} // namespace pcl_ext_ros
