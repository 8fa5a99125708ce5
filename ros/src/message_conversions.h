#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/stream_health.h>

#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include <string>

namespace pcl_ext_ros1 {

/** \brief Exact conversions; a time that ROS cannot represent, before 1970 or after 2106,
 * becomes 0. */
pcl_ext::nodes::Time
toNodeTime(const ros::Time& time);
ros::Time
toRosTime(pcl_ext::nodes::Time time);

/** \brief ROS time, which may be simulated. */
pcl_ext::nodes::Time
rosTimeNow();

/** \brief A cloud of the voxel centres, see pcl_ext::nodes::describeVoxels. */
sensor_msgs::PointCloud2
toMessage(const std_msgs::Header& header, const pcl_ext::io::VoxelFrame& frame);

} // namespace pcl_ext_ros1
