// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Conversions between the conventions of PCL and those of the codec.
 */
#pragma once

#include <pcl_ext/compression/cloud_source.h>
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <pcl/compression/compression_profiles.h>

#include <Eigen/Geometry>

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

/** \brief The arguments of PCL's constructor that a profile replaces, with PCL's names,
 * as in pcl::io::configurationProfile_t. */
struct ProfileArguments {
  unsigned int i_frame_rate;
  double octree_resolution;
  double point_resolution;
  bool do_voxel_grid_down_sampling;
  bool do_color_encoding;
  unsigned char color_bit_resolution;
};

/** \brief The settings that correspond to the arguments of PCL's constructor.
 * \param[in] profile values outside the enumeration count as MANUAL_CONFIGURATION
 * \param[in] show_statistics see IntensityCompressionSettings
 * \param[in] arguments used with MANUAL_CONFIGURATION
 */
PCL_EXT_EXPORT IntensityCompressionSettings
settingsOfArguments(pcl::io::compression_Profiles_e profile,
                    bool show_statistics,
                    const ProfileArguments& arguments);

/** \brief The resolution of the settings, or the default if they are invalid, as PCL's
 * octree accepts no other. */
PCL_EXT_EXPORT double
octreeResolution(const IntensityCompressionSettings& settings);

/** \brief Ok, or InvalidInput for the pose of a cloud that is not finite, where the
 * intensity model uses the depth. */
PCL_EXT_EXPORT CompressionStatus
checkSensorPose(const Eigen::Vector4f& sensor_origin,
                const Eigen::Quaternionf& sensor_orientation);

/** \brief Pose of the sensor in the coordinate frame of a cloud, sensor -> cloud: that
 * of the settings or the cloud's own. */
PCL_EXT_EXPORT SensorPose
sensorPose(const IntensityCompressionSettings& settings,
           const Eigen::Vector4f& sensor_origin,
           const Eigen::Quaternionf& sensor_orientation);

/** \brief Where the depths of a cloud's points are measured from. */
PCL_EXT_EXPORT DepthAxis
depthAxisOfSensor(const SensorPose& pose);

/** \brief The box of an octree whose voxels are those of a grid. */
struct OctreeBox {
  std::array<double, 3> min; ///< metres
  std::array<double, 3> max;
};

/** \brief The box of an octree for a grid, metres.
 *
 * PCL divides the distance of a point from the corner, the codec its coordinate. The
 * lower corner is moved outwards by the difference in rounding, so that a point on a
 * voxel's boundary is in the same voxel for both.
 */
PCL_EXT_EXPORT OctreeBox
octreeBox(const VoxelGrid& grid);

} // namespace pcl_ext::PCL_EXT_ABI::io::detail
