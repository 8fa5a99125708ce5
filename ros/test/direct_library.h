/** \file
 * \brief What the nodes must do, done by the library without ROS.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/rigid_pose.h>

#include <sensor_msgs/PointCloud2.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_ros {
namespace test {

/** \brief Voxels as points: x, y, z, intensity; in the order in which they came. */
using Voxels = std::vector<std::array<float, 4>>;

using Bytes = std::vector<std::uint8_t>;

/** \brief The points of a cloud that must have the layout of voxels, and no other. */
Voxels
voxelsIn(const sensor_msgs::PointCloud2& message);

Voxels
voxelsIn(const pcl_ext::io::VoxelFrame& frame);

/** \brief One sensor's stream, encoded and decoded by the library at once. */
class DirectStream {
public:
  explicit DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings);

  /** \brief The bytes of the next frame; empty if there is none for this cloud. */
  Bytes
  encode(const sensor_msgs::PointCloud2& cloud,
         const std::optional<pcl_ext::WorldPose>& pose);

  /** \brief The voxels of the next frame, which must be there.
   * \param[in] cloud as the compressor gets it
   * \param[in] pose sensor -> world; none: not known for this cloud
   * \param[in] min_intensity voxels below it are removed
   */
  Voxels
  voxelsOf(const sensor_msgs::PointCloud2& cloud,
           const std::optional<pcl_ext::WorldPose>& pose,
           float min_intensity = 0.0f);

  /** \brief The same as a frame. */
  pcl_ext::io::VoxelFrame
  frameOf(const sensor_msgs::PointCloud2& cloud,
          const std::optional<pcl_ext::WorldPose>& pose,
          float min_intensity = 0.0f);

private:
  pcl_ext::nodes::SensorNode sensor_node_;
};

/** \brief What a CentralNode makes of one frame each of some streams, merged.
 * \param[in] resolution of the common grid, metres
 * \param[in] frames I-frames, by name of their stream
 */
Voxels
mergedDirectly(double resolution, const std::map<std::string, Bytes>& frames);

} // namespace test
} // namespace pcl_ext_ros
