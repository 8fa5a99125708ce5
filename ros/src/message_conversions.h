#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/stream_health.h>

#include <pcl_ext_ros/CompressedPointCloud2.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief To the nanosecond, both ways; times before 1970 and behind 2106, which ROS does
 * not have, become 0. */
pcl_ext::nodes::Time
toNodeTime(const ros::Time& time);
ros::Time
toRosTime(pcl_ext::nodes::Time time);

/** \brief ROS's time, simulated or not, for the clocks of nodes. */
pcl_ext::nodes::Time
rosTimeNow();

/** \brief A frame id as TF2 takes it, which has no slash before it. */
std::string
withoutLeadingSlash(const std::string& frame_id);

/** \brief A coded frame as a message.
 * \param[in] header stamp of the cloud, and the global frame
 * \param[in] format of the stream
 * \param[in] voxels of the frame
 * \param[in] bytes the frame
 */
CompressedPointCloud2
toMessage(const std_msgs::Header& header,
          pcl_ext::io::StreamFormat format,
          std::size_t voxels,
          std::vector<std::uint8_t> bytes);

/** \brief True if a message's bytes are said to be this library's. */
bool
hasKnownFormat(const CompressedPointCloud2& message);

/** \brief Voxels as a cloud of their centres, x, y, z in metres and the intensity.
 * \param[in] header of the cloud
 * \param[in] frame as isConsistent() asks
 */
sensor_msgs::PointCloud2
toMessage(const std_msgs::Header& header, const pcl_ext::io::VoxelFrame& frame);

} // namespace pcl_ext_ros
