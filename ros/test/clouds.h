/** \file
 * \brief Clouds as sensors send them, the same in every run.
 */
#pragma once

#include <pcl/point_types.h>

#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext_ros {
namespace test {

/** \brief The stamp of a stream's nth cloud, whose nanoseconds no float, nor microseconds,
 * can hold. */
ros::Time
stampOf(std::uint32_t number);

/** \brief A noisy wall of two metres by two, three metres before the sensor, and a ball
 * that moves before it; some points are not finite, as in the clouds of depth cameras.
 * \tparam PointT pcl::PointXYZ, PointXYZI or PointXYZRGB
 * \param[in] number of the cloud in its stream, which decides its points and its stamp
 * \param[in] frame_id of the sensor
 * \param[in] points number of them
 */
template <typename PointT>
sensor_msgs::PointCloud2
makeCloud(std::uint32_t number, const std::string& frame_id, std::size_t points = 6000);

} // namespace test
} // namespace pcl_ext_ros
