/** \file
 * \brief Conversions between the conventions of PCL and those of the codec.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>
#include <pcl_ext/rigid_pose.h>

#include <pcl/compression/compression_profiles.h>

#include <Eigen/Geometry>

#include <array>

namespace pcl_ext {
namespace io {
namespace detail {

/** \brief The settings that correspond to PCL's constructor arguments. */
PCL_EXT_EXPORT IntensityCompressionSettings
settingsOfProfile(pcl::io::compression_Profiles_e profile,
                  bool show_statistics,
                  double octree_resolution,
                  unsigned int i_frame_rate);

/** \brief The resolution of the settings, or the default if they are invalid, as PCL's
 * octree accepts no other. */
PCL_EXT_EXPORT double
octreeResolution(const IntensityCompressionSettings& settings);

/** \brief Pose of the sensor in the frame of a cloud, sensor -> cloud: that of the settings
 * or the cloud's own. */
PCL_EXT_EXPORT SensorPose
sensorPose(const IntensityCompressionSettings& settings,
           const Eigen::Vector4f& sensor_origin,
           const Eigen::Quaternionf& sensor_orientation);

/** \brief The box of an octree whose voxels are those of a grid. */
struct OctreeBox {
  std::array<double, 3> min; ///< metres
  std::array<double, 3> max;
};

/** \brief The box of an octree for a grid, metres.
 *
 * PCL divides the distance of a point from the corner, the codec its coordinate. The lower
 * corner is moved outwards by the difference in rounding, so that a point on a voxel's
 * boundary is in the same voxel for both.
 */
PCL_EXT_EXPORT OctreeBox
octreeBox(const VoxelGrid& grid);

} // namespace detail
} // namespace io
} // namespace pcl_ext
