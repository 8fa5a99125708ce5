#include "labelled_voxels.h"

#include <pcl_ext/compression/symbol_intensities.h>
#include <pcl_ext/compression/voxel_centres.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace pcl_ext {
namespace report {

namespace {

/** \brief The voxels of a cloud under one law. */
template <typename ModelT, typename PointT>
io::VoxelFrame
voxelsOf(const pcl::PointCloud<PointT>& cloud,
         const Eigen::Isometry3d& pose,
         const io::BoundingBox& box,
         const ModelT& model)
{
  SensorPreprocessor<ModelT> preprocessor{model};
  preprocessor.setSensorPose(pose);
  preprocessor.setCropBox(
      Eigen::Map<const Eigen::Vector3d>(box.min.data()).cast<float>(),
      Eigen::Map<const Eigen::Vector3d>(box.max.data()).cast<float>());
  pcl::PointCloud<pcl::PointXYZI> points;
  if (const auto status = preprocessor.process(cloud, points); !status.ok())
    throw std::runtime_error(status.message());

  io::IntensityCompressionSettings settings;
  settings.resolution = model.resolution();
  settings.bounding_box = box;
  io::Voxelizer voxelizer(settings, ModelT::unit);
  io::PointView view;
  constexpr std::size_t floats_per_point = sizeof(pcl::PointXYZI) / sizeof(float);
  view.count = points.size();
  if (!points.empty()) {
    view.coordinates = &points.front().x;
    view.coordinate_stride = floats_per_point;
    view.intensities = &points.front().intensity;
    view.intensity_stride = floats_per_point;
  }
  io::VoxelFrame frame;
  voxelizer.voxelize(view, /* may_refit */ true, frame);
  return frame;
}

/** \brief The points that lie on a surface; the others become NaN. */
template <typename PointT>
pcl::PointCloud<PointT>
surfacePoints(const pcl::PointCloud<PointT>& cloud,
              const std::vector<cell::PointTruth>& truth)
{
  pcl::PointCloud<PointT> surface = cloud;
  surface.is_dense = false;
  for (std::size_t i = 0; i < surface.size(); ++i)
    if (truth[i] != cell::PointTruth::Surface)
      surface[i].getVector3fMap().setConstant(std::numeric_limits<float>::quiet_NaN());
  return surface;
}

/** \brief Places of a frame's voxels, and which of them hold no surface point.
 * \param[in] surface voxels of the surface points alone, on the same grid
 */
std::vector<LabelledVoxel>
labelVoxels(const io::VoxelFrame& frame, const io::VoxelFrame& surface)
{
  if (frame.grid != surface.grid)
    throw std::runtime_error("two frames of one box have different grids");
  io::SymbolIntensities intensities;
  intensities.setScale(frame.intensity_scale);
  std::vector<LabelledVoxel> voxels;
  io::VoxelCentres centres;
  for (std::size_t begin = 0; begin < frame.size();) {
    const std::size_t count = io::voxelCentres(frame, intensities, begin, centres);
    for (std::size_t i = 0; i < count; ++i) {
      LabelledVoxel voxel{};
      voxel.x = centres.x[i];
      voxel.y = centres.y[i];
      voxel.z = centres.z[i];
      voxel.is_noise = !std::binary_search(
          surface.keys.begin(), surface.keys.end(), frame.keys[begin + i]);
      voxels.push_back(voxel);
    }
    begin += count;
  }
  return voxels;
}

/** \brief Puts a frame's intensities into voxels of the same keys. */
void
setIntensities(const io::VoxelFrame& frame,
               float LabelledVoxel::*intensity,
               std::vector<LabelledVoxel>& voxels)
{
  if (frame.size() != voxels.size())
    throw std::runtime_error("the laws of intensity have different voxels");
  for (std::size_t i = 0; i < voxels.size(); ++i)
    voxels[i].*intensity = frame.intensity_scale.value(frame.intensities[i]);
}

} // namespace

std::vector<LabelledVoxel>
kinectVoxels(const cell::CellFrame& frame,
             const Eigen::Isometry3d& pose,
             const io::BoundingBox& box,
             double resolution)
{
  const CountIntensity count(resolution, UnspecifiedSensor());
  const io::VoxelFrame counted = voxelsOf(frame.cloud, pose, box, count);
  std::vector<LabelledVoxel> voxels = labelVoxels(
      counted, voxelsOf(surfacePoints(frame.cloud, frame.truth), pose, box, count));
  setIntensities(counted, &LabelledVoxel::count, voxels);
  setIntensities(
      voxelsOf(
          frame.cloud, pose, box, IntensityModel<KinectV2, QuadraticLaw>(resolution)),
      &LabelledVoxel::quadratic,
      voxels);
  setIntensities(
      voxelsOf(frame.cloud, pose, box, IntensityModel<KinectV2, LinearLaw>(resolution)),
      &LabelledVoxel::linear,
      voxels);
  return voxels;
}

std::vector<LabelledVoxel>
lidarVoxels(const cell::LidarFrame& frame,
            const Eigen::Isometry3d& pose,
            const io::BoundingBox& box,
            double resolution)
{
  const NativeIntensity native(resolution, UnspecifiedSensor());
  const io::VoxelFrame all = voxelsOf(frame.cloud, pose, box, native);
  std::vector<LabelledVoxel> voxels = labelVoxels(
      all, voxelsOf(surfacePoints(frame.cloud, frame.truth), pose, box, native));
  setIntensities(all, &LabelledVoxel::native, voxels);
  return voxels;
}

} // namespace report
} // namespace pcl_ext
