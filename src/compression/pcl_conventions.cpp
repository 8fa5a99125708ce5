#include <pcl_ext/compression/impl/pcl_conventions.h>

#include <cmath>
#include <limits>

namespace pcl_ext {
namespace io {
namespace detail {

IntensityCompressionSettings
settingsOfProfile(pcl::io::compression_Profiles_e profile,
                  bool show_statistics,
                  double octree_resolution,
                  unsigned int i_frame_rate)
{
  IntensityCompressionSettings settings;
  settings.show_statistics = show_statistics;
  settings.resolution = octree_resolution;
  settings.i_frame_rate = i_frame_rate;
  // Values outside the enumeration count as MANUAL_CONFIGURATION.
  const int index = static_cast<int>(profile);
  if (index >= 0 && index < static_cast<int>(pcl::io::COMPRESSION_PROFILE_COUNT)) {
    const auto& configuration = pcl::io::compressionProfiles_[index];
    settings.resolution = configuration.octreeResolution;
    settings.i_frame_rate = configuration.iFrameRate;
    if (profile >= pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR)
      settings.effort = Effort::Small;
  }
  return settings;
}

double
octreeResolution(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings.resolution
                                      : IntensityCompressionSettings().resolution;
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

OctreeBox
octreeBox(const VoxelGrid& grid)
{
  const double side = static_cast<double>(grid.size()) * grid.resolution;
  OctreeBox box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels = std::abs(static_cast<double>(grid.first_index[axis])) +
                          static_cast<double>(grid.size());
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * voxels;
    box.min[axis] = grid.lowerCorner(axis) - rounding * grid.resolution;
    box.max[axis] = grid.lowerCorner(axis) + side;
  }
  return box;
}

} // namespace detail
} // namespace io
} // namespace pcl_ext
