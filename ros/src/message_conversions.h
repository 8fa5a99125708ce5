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

/** \brief Exact conversions; a time that ROS cannot represent, before 1970 or after 2106,
 * becomes 0. */
pcl_ext::nodes::Time
toNodeTime(const ros::Time& time);
ros::Time
toRosTime(pcl_ext::nodes::Time time);

/** \brief ROS time, which may be simulated. */
pcl_ext::nodes::Time
rosTimeNow();

/** \brief A frame id as TF2 needs it. */
std::string
withoutLeadingSlash(const std::string& frame_id);

/** \brief A coded frame as a message.
 * \param[in] header stamp of the cloud and global frame
 * \param[in] format of the stream
 * \param[in] voxels number of voxels in the frame
 * \param[in] has_colours whether they have colours
 * \param[in] bytes of the frame
 */
CompressedPointCloud2
toMessage(const std_msgs::Header& header,
          pcl_ext::io::StreamFormat format,
          std::size_t voxels,
          bool has_colours,
          std::vector<std::uint8_t> bytes);

/** \brief True if the format of a message is one of this library. */
bool
hasKnownFormat(const CompressedPointCloud2& message);

/** \brief A cloud of the voxel centres: x, y, z in metres, intensity, and where the
 * frame has colours rgb: red, green and blue from bit 16, 8 and 0 on, the highest byte
 * 0.
 * \param[in] header of the cloud
 * \param[in] frame for which isConsistent() is true
 */
sensor_msgs::PointCloud2
toMessage(const std_msgs::Header& header, const pcl_ext::io::VoxelFrame& frame);

} // namespace pcl_ext_ros
