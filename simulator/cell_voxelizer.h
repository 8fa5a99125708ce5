/** \file
 * \brief From a cloud of the robot cell's sensors to voxels within the cell's crop box.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "simulator/crop_box.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <array>
#include <cstddef>
#include <stdexcept>

namespace pcl_ext {
namespace noise {

/** \brief One sensor's voxels under one law of intensity, as a decoder would have them:
 * what is in voxels is coded without loss. All voxelizers of one resolution have one grid.
 * \tparam ModelT an IntensityModel
 */
template <typename ModelT>
class CellVoxelizer {
public:
  /** \brief For a sensor.
   * \param[in] pose sensor -> world
   */
  CellVoxelizer(const ModelT& model, const Eigen::Isometry3d& pose)
  : model_(model)
  , pose_(pose)
  , preprocessor_(model_)
  , voxelizer_(settings(model.resolution()), ModelT::unit)
  {
    preprocessor_.setSensorPose(pose);
    preprocessor_.setCropBox(cell::RobotCell::cropMin().cast<float>(),
                             cell::RobotCell::cropMax().cast<float>());
  }

  /** \brief The voxels of a cloud in the sensor's frame, NaN where there is no return.
   * \throws std::runtime_error if the cloud cannot be preprocessed
   */
  template <typename PointT>
  void
  voxelize(const pcl::PointCloud<PointT>& cloud, io::VoxelFrame& frame)
  {
    if (const auto status = preprocessor_.process(cloud, points_); !status.ok())
      throw std::runtime_error(status.message());
    io::PointView view;
    view.count = points_.size();
    if (!points_.empty()) {
      constexpr std::size_t stride = sizeof(pcl::PointXYZI) / sizeof(float);
      view.coordinates = &points_.front().x;
      view.coordinate_stride = stride;
      view.intensities = &points_.front().intensity;
      view.intensity_stride = stride;
    }
    voxelizer_.voxelize(view, /* may_refit */ false, frame);
    frame.depth_model.reset();
    if constexpr (ModelT::uses_depth)
      frame.depth_model =
          io::depthModelOf({ModelT::Law::depth_exponent, model_.cutOffDepth(), 255.0},
                           elements(pose_.translation()),
                           elements(pose_.linear().col(2)),
                           frame.grid,
                           frame.intensity_scale);
  }

private:
  static io::IntensityCompressionSettings
  settings(double resolution)
  {
    io::IntensityCompressionSettings settings;
    settings.resolution = resolution;
    settings.bounding_box = cell::cropBox();
    return settings;
  }

  static std::array<double, 3>
  elements(const Eigen::Vector3d& vector)
  {
    return {vector.x(), vector.y(), vector.z()};
  }

  ModelT model_;
  Eigen::Isometry3d pose_;
  SensorPreprocessor<ModelT> preprocessor_;
  io::Voxelizer voxelizer_;
  pcl::PointCloud<pcl::PointXYZI> points_;
};

} // namespace noise
} // namespace pcl_ext
