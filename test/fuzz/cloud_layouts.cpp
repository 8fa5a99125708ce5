// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: SensorPreprocessor on any PCLPointCloud2 reads no byte outside the
 * cloud's data. Each point is kept, cropped or not finite; what is kept is finite and
 * within the box. A refusal has a reason and leaves no point. That fields are read
 * right: test_cloud_layouts.cpp.
 *
 * The input describes a valid layout, then changes of it, then the bytes of the points.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/point_types.h>

#include "cloud_message.h"
#include "fuzz_input.h"

#include <pcl/PCLPointCloud2.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::fuzz;

using Output = pcl::PointCloud<PointXYZRGBI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;

void
requireWithin(const Output& output, const PreprocessorSettings& settings)
{
  for (const PointXYZRGBI& point : output)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      require(std::isfinite(point.data[axis]));
      if (settings.crop_box)
        require(point.data[axis] >= (*settings.crop_box)[0][axis] &&
                point.data[axis] <= (*settings.crop_box)[1][axis]);
    }
}

template <typename ModelT>
void
requirePoints(const pcl::PCLPointCloud2& cloud, const PreprocessorSettings& settings)
{
  const ModelT model(resolution);
  SensorPreprocessor<ModelT, PointXYZRGBI> preprocessor(model);
  preprocessor.setReadsColours(settings.reads_colours);
  preprocessor.setIntensityField(settings.intensity_field);
  preprocessor.setIntensityScale(settings.scale);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().setZero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    pose.linear()(row, static_cast<Eigen::Index>(settings.pose.source[axis])) =
        static_cast<double>(settings.pose.sign[axis]);
    pose.translation()[row] = static_cast<double>(settings.pose.translation[axis]);
  }
  preprocessor.setSensorPose(pose);
  if (settings.crop_box) {
    const auto& [min, max] = *settings.crop_box;
    preprocessor.setCropBox(Eigen::Vector3f(min.data()).cast<double>(),
                            Eigen::Vector3f(max.data()).cast<double>());
  }
  Output output;
  output.resize(3); // of an earlier call
  const PreprocessingStatus status = preprocessor.process(cloud, output);

  const PreprocessingStatistics& statistics = preprocessor.statistics();
  require(output.width == output.size());
  if (!status.ok()) {
    require(!status.message().empty() && output.empty() && statistics.points == 0);
    return;
  }
  require(output.height == 1 && output.is_dense);
  require(output.header.frame_id == cloud.header.frame_id &&
          output.header.stamp == cloud.header.stamp);
  require(statistics.points == std::size_t{cloud.width} * cloud.height);
  require(output.size() + statistics.points_not_finite + statistics.points_cropped ==
          statistics.points);
  requireWithin(output, settings);
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FuzzInput input(data, size);
  const std::uint8_t choices = input.byte();
  const PreprocessorSettings settings = settingsOf(input);
  pcl::PCLPointCloud2 cloud = layoutOf(input);
  for (int changes = choices / 4 % 4; changes > 0; --changes)
    falsify(cloud, input);
  fillData(cloud, input);
  // Ends where the memory ends, so that a sanitizer sees the first byte too many.
  cloud.data.shrink_to_fit();
  switch (choices % 4) {
  case 0:
    requirePoints<CountIntensity>(cloud, settings);
    break;
  case 1:
    requirePoints<QuadraticIntensity>(cloud, settings);
    break;
  default:
    requirePoints<NativeIntensity>(cloud, settings);
  }
  return 0;
}
