/** \file
 * \brief Expected results: the same work done by the library without ROS.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/rigid_pose.h>

#include <sensor_msgs/PointCloud2.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext_ros1 {
namespace test {

/** \brief Voxels as points x, y, z, intensity, colour (0: none), in their order. */
using Voxels = std::vector<std::array<float, 5>>;

using Bytes = std::vector<std::uint8_t>;

/** \brief The points of a cloud. Its layout must be that of published voxels. */
Voxels
voxelsIn(const sensor_msgs::PointCloud2& message);

Voxels
voxelsIn(const pcl_ext::io::VoxelFrame& frame);

/** \brief One stream, encoded and decoded by the library. */
class DirectStream {
public:
  explicit DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings);

  /** \brief The bytes of the next frame; empty if there is none for this cloud.
   * \param[in] cloud as the compressor receives it
   * \param[in] pose sensor -> world
   */
  Bytes
  encode(const sensor_msgs::PointCloud2& cloud, const pcl_ext::WorldPose& pose);

  /** \brief The next frame, which must exist. */
  pcl_ext::io::VoxelFrame
  frameOf(const sensor_msgs::PointCloud2& cloud, const pcl_ext::WorldPose& pose);

  /** \brief The voxels of the next frame, which must exist. */
  Voxels
  voxelsOf(const sensor_msgs::PointCloud2& cloud, const pcl_ext::WorldPose& pose)
  {
    return voxelsIn(frameOf(cloud, pose));
  }

private:
  pcl_ext::nodes::SensorNode sensor_node_;
};

/** \brief The merged voxels of one frame of each stream.
 * \param[in] resolution of the common grid, metres
 * \param[in] frames I-frames, by name of their stream
 */
Voxels
mergedDirectly(double resolution, const std::map<std::string, Bytes>& frames);

} // namespace test
} // namespace pcl_ext_ros1
