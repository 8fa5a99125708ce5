// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/impl/pcl_conventions.h>

#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace detail {

namespace {

/** \brief The effort of a profile: the smallest streams of those that take no longer
 * than PCL's class, in both directions, on clouds of depth cameras and lidars. */
Effort
effortOf(pcl::io::compression_Profiles_e profile)
{
  switch (profile) {
  case pcl::io::HIGH_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR:
    return Effort::Small;
  default:
    return Effort::Fast;
  }
}

/** \brief Voxel edge that keeps points as PCL does, metres.
 *
 * PCL cuts coordinates off to multiples of its resolution, while the centre of a voxel
 * is at most half an edge off: voxels may be larger and still have the smaller error.
 * Below a millimetre, where most bytes are the last digits of the coordinates, they
 * are; of 0.1 mm eight to the millimetre, which sensors often have as the unit.
 */
double
edgeForPoints(double point_resolution)
{
  return point_resolution < 0.001 ? 1.25 * point_resolution : point_resolution;
}

} // namespace

IntensityCompressionSettings
settingsOfArguments(pcl::io::compression_Profiles_e profile,
                    bool show_statistics,
                    const ProfileArguments& arguments)
{
  ProfileArguments used = arguments;
  const int index = static_cast<int>(profile);
  const bool is_profile =
      index >= 0 && index < static_cast<int>(pcl::io::COMPRESSION_PROFILE_COUNT);
  if (is_profile) {
    const auto& configuration = pcl::io::compressionProfiles_[index];
    used = {configuration.iFrameRate,
            configuration.octreeResolution,
            configuration.pointResolution,
            configuration.doVoxelGridDownSampling,
            configuration.doColorEncoding,
            configuration.colorBitResolution};
  }
  IntensityCompressionSettings settings;
  settings.show_statistics = show_statistics;
  // PCL does not keep points whose resolution, a float there, is that of the octree.
  // Where that of the octree is finer, the voxels of the octree decide.
  settings.keep_points =
      !used.do_voxel_grid_down_sampling &&
      static_cast<double>(static_cast<float>(used.point_resolution)) !=
          used.octree_resolution;
  const double edge = edgeForPoints(used.point_resolution);
  const bool is_octree_finer = std::isfinite(used.point_resolution) &&
                               used.octree_resolution > 0.0 &&
                               used.octree_resolution < edge;
  settings.resolution =
      settings.keep_points && !is_octree_finer ? edge : used.octree_resolution;
  settings.coarsen_wide_clouds = true;
  settings.use_coordinate_step = true;
  settings.i_frame_rate = used.i_frame_rate;
  settings.colour_bits = used.do_color_encoding ? used.color_bit_resolution : 0;
  if (is_profile)
    settings.effort = effortOf(profile);
  return settings;
}

double
octreeResolution(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings.resolution
                                      : IntensityCompressionSettings().resolution;
}

CompressionStatus
checkSensorPose(const Eigen::Vector4f& sensor_origin,
                const Eigen::Quaternionf& sensor_orientation)
{
  if (sensor_origin.allFinite() && sensor_orientation.coeffs().allFinite())
    return {};
  return {CompressionCode::InvalidInput,
          "sensor_origin_ or sensor_orientation_ of the cloud is not finite, and the "
          "intensity model uses the depth; set sensor_pose"};
}

SensorPose
sensorPose(const IntensityCompressionSettings& settings,
           const Eigen::Vector4f& sensor_origin,
           const Eigen::Quaternionf& sensor_orientation)
{
  if (settings.sensor_pose)
    return *settings.sensor_pose;
  SensorPose pose = SensorPose::Identity();
  pose.translation() = sensor_origin.head<3>();
  // Files may contain any quaternion; one of length 0 is ignored.
  if (sensor_orientation.norm() > 1e-6f)
    pose.linear() = sensor_orientation.normalized().toRotationMatrix();
  return pose;
}

DepthAxis
depthAxisOfSensor(const SensorPose& pose)
{
  return depthAxisOf(pose.cast<double>());
}

OctreeBox
octreeBox(const VoxelGrid& grid)
{
  const double side = static_cast<double>(grid.size()) * grid.resolution;
  OctreeBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels = std::abs(grid.origin[axis]) / grid.resolution +
                          std::abs(static_cast<double>(grid.first_index[axis])) +
                          static_cast<double>(grid.size());
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * voxels;
    box.min[axis] = grid.lowerCorner(axis) - rounding * grid.resolution;
    box.max[axis] = grid.lowerCorner(axis) + side;
  }
  return box;
}

} // namespace detail
} // namespace pcl_ext::PCL_EXT_ABI::io
