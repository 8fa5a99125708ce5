// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief From a cloud of the robot cell's sensors to voxels within the cell's crop box.
 */
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/impl/point_intensity.h>

#include "simulator/crop_box.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <stdexcept>

namespace pcl_ext {
namespace noise {

/** \brief One sensor's voxels under one law of intensity, as a decoder would have them:
 * what is in voxels is coded without loss. All voxelizers of one resolution have one
 * grid.
 * \tparam ModelT an IntensityModel
 */
template <typename ModelT>
class CellVoxelizer {
public:
  /** \brief For a sensor.
   * \param[in] pose sensor -> world
   */
  CellVoxelizer(const ModelT& model, const Eigen::Isometry3d& pose)
  : preprocessor_(model), encoder_(settings(model), ModelT::unit, io::depthLawOf(model))
  {
    setPose(pose);
    preprocessor_.setCropBox(cell::RobotCell::cropMin(), cell::RobotCell::cropMax());
  }

  /** \brief Sets the pose of the next clouds, sensor -> world. */
  void
  setPose(const Eigen::Isometry3d& pose)
  {
    pose_ = WorldPose(pose);
    preprocessor_.setSensorPose(pose);
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
    const io::PointView view = pointViewWithIntensities(points_);
    if (const auto status = encoder_.voxelize(view, pose_, frame); !status.ok())
      throw std::runtime_error(status.message());
  }

private:
  static io::EncoderSettings
  settings(const ModelT& model)
  {
    io::EncoderSettings settings;
    settings.resolution = model.resolution();
    settings.bounding_box = cell::cropBox();
    return settings;
  }

  WorldPose pose_;
  SensorPreprocessor<ModelT> preprocessor_;
  io::CloudEncoder encoder_;
  pcl::PointCloud<pcl::PointXYZI> points_;
};

} // namespace noise
} // namespace pcl_ext
