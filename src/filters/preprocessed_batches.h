// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/filters/impl/moved_points.hpp>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/PCLPointCloud2.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief The points of a sensor's cloud as SensorPreprocessor makes them, some at a
 * time, for io::CloudEncoder: from the sensor's cloud to voxels in one pass, without
 * the processed cloud in between.
 * \tparam IntensityModelT,OutputPointT as of SensorPreprocessor
 */
template <typename IntensityModelT, typename OutputPointT = pcl::PointXYZI>
class PreprocessedBatches : public io::PointBatches {
public:
  using Preprocessor = SensorPreprocessor<IntensityModelT, OutputPointT>;

  /** \param[in] preprocessor with its settings */
  explicit PreprocessedBatches(const Preprocessor& preprocessor)
  : preprocessor_(preprocessor)
  {}

  /** \brief See SensorPreprocessor::setSensorPose. Before open(). */
  void
  setSensorPose(const Eigen::Isometry3d& sensor_to_world)
  {
    preprocessor_.setSensorPose(sensor_to_world);
  }

  /** \brief Whether the batches have all fields of a cloud but x, y and z; not, if it
   * is not called. Before open(). */
  void
  setReadsFields(bool reads_fields)
  {
    reads_fields_ = reads_fields;
  }

  /** \brief Begins a cloud.
   * \param[in] cloud as for SensorPreprocessor::process; must not change while its
   * batches are read
   * \return as SensorPreprocessor::process; unless Ok there are no points
   */
  PreprocessingStatus
  open(const pcl::PCLPointCloud2& cloud);

  /** \brief Counts of the points that were read since the last restart() or split(). */
  PreprocessingStatistics
  statistics() const;

  std::size_t
  size() const override
  {
    return end_ - begin_;
  }

  /** \brief False for a model that gives each point 1, and for one without
   * intensities. */
  bool
  hasIntensities() const override
  {
    return IntensityModelT::uses_depth || IntensityModelT::uses_native;
  }

  bool
  hasColours() const override
  {
    return preprocessor_.statistics().has_colours;
  }

  std::vector<io::FieldDescription>
  fields() const override;

  io::ImageSize
  imageSize() const override
  {
    return cloud_ != nullptr && cloud_->height > 1
               ? io::ImageSize{cloud_->width, cloud_->height}
               : io::ImageSize();
  }

  void
  restart() override;

  bool
  next(io::PointView& points) override;

  std::size_t
  pointsBehindSensor() const override
  {
    return preprocessor_.statistics().points_behind_sensor;
  }

  std::vector<io::PointBatches*>
  split(std::size_t parts) override;

private:
  static constexpr std::size_t chunk = detail::MovedPoints::capacity;

  io::PointView
  viewOf(std::size_t count) const;

  Preprocessor preprocessor_;
  const pcl::PCLPointCloud2* cloud_ = nullptr;
  PointLayout layout_;
  std::size_t begin_ = 0; // first point of the cloud
  std::size_t end_ = 0;
  std::size_t next_ = 0;
  std::array<OutputPointT, 2 * chunk> points_;
  // Their coordinates, where the preprocessor moves them in double precision.
  std::array<std::array<double, 3>, 2 * chunk> doubles_;

  // Of the points of a batch, all bytes in the cloud, where fields are read.
  bool reads_fields_ = false;
  std::vector<FoundField> fields_;
  std::vector<std::uint32_t> sources_;
  std::vector<std::uint8_t> point_bytes_;
  std::vector<std::uint32_t> pixels_;

  std::vector<std::unique_ptr<PreprocessedBatches>> parts_; // keep their memory
  std::size_t part_count_ = 0; // since split(); 0: the instance itself is read
};

} // namespace pcl_ext::PCL_EXT_ABI

#include "filters/preprocessed_batches.hpp"
