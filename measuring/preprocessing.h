// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_law.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <functional>
#include <optional>
#include <stdexcept>
#include <type_traits>

namespace pcl_ext {
namespace measuring {

/** \brief Decoded intensity of a full voxel face, for the laws that share it out: the
 * top of the 8-bit scale of the published layout. */
constexpr float full_face = 255.0f;

/** \brief SensorPreprocessor of a law that is chosen at run time.
 * \tparam CloudT pcl::PCLPointCloud2 or pcl::PointCloud
 */
template <typename CloudT>
using Preprocessing = std::function<PreprocessingStatistics(
    const CloudT&, pcl::PointCloud<pcl::PointXYZI>&)>;

/** \brief Makes the preprocessing of one sensor.
 * \param[in] law intensity of a point; the shares of a voxel face are times full_face
 * \param[in] resolution voxel edge, metres
 * \param[in] sensor for laws that need one
 * \param[in] sensor_pose sensor -> world
 * \param[in] crop_box what to keep, world; none: everything
 * \return a function that throws std::runtime_error if a cloud cannot be preprocessed
 */
template <typename CloudT>
Preprocessing<CloudT>
makePreprocessing(IntensityLaw law,
                  double resolution,
                  const std::optional<RuntimeSensor>& sensor,
                  const Eigen::Isometry3d& sensor_pose,
                  const std::optional<io::BoundingBox>& crop_box)
{
  return visitIntensityModel(
      law, resolution, sensor, [&](const auto& model) -> Preprocessing<CloudT> {
        using Model = std::decay_t<decltype(model)>;
        SensorPreprocessor<Model, pcl::PointXYZI> preprocessor(model);
        preprocessor.setSensorPose(sensor_pose);
        if (crop_box)
          preprocessor.setCropBox(Eigen::Vector3d(crop_box->min.data()),
                                  Eigen::Vector3d(crop_box->max.data()));
        if (Model::unit == IntensityUnit::Share)
          preprocessor.setIntensityScale(full_face);
        return [preprocessor](const CloudT& cloud,
                              pcl::PointCloud<pcl::PointXYZI>& output) mutable {
          const PreprocessingStatus status = preprocessor.process(cloud, output);
          if (!status.ok())
            throw std::runtime_error("preprocessing failed: " + status.message());
          return preprocessor.statistics();
        };
      });
}

} // namespace measuring
} // namespace pcl_ext
