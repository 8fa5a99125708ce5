// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: SensorPreprocessor on any PCLPointCloud2 does what its header says,
 * which a reference does once more, one point and one field at a time: the same points,
 * or a refusal for a reason that is there; and no byte outside the cloud's data is
 * read.
 *
 * The input describes a valid layout, then changes of it, then the bytes of the points.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/point_types.h>

#include "cloud_message.h"
#include "cloud_reference.h"
#include "fuzz_input.h"

#include <pcl/PCLPointCloud2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::fuzz;

using Output = pcl::PointCloud<PointXYZRGBI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;

/** \brief What becomes of a point. */
struct MovedPoint {
  std::array<float, 3> place{};
  float depth = 0.0f;
  bool is_finite = true;
  bool is_within = true;
};

bool
isFloat(double number)
{
  return std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max());
}

/** \brief A sensor so far from the origin that its points are moved in double
 * precision. */
bool
isFar(const PreprocessorSettings& settings)
{
  return std::any_of(settings.pose.translation.begin(),
                     settings.pose.translation.end(),
                     [](float number) { return std::abs(number) > 1024.0f; });
}

/** \brief Whether floats have not each value of coordinates. */
bool
needDoubles(const Fields& fields)
{
  return std::any_of(fields.begin(), fields.begin() + 3, [](const auto* field) {
    return field->datatype > 4 && field->datatype != pcl::PCLPointField::FLOAT32;
  });
}

/** \brief Moves a point.
 * \tparam NumberT type of the arithmetic
 */
template <typename NumberT>
MovedPoint
movePoint(const std::uint8_t* point,
          const Fields& fields,
          const PreprocessorSettings& settings)
{
  const auto coordinate = [&](std::size_t axis) {
    return readField<NumberT>(point, *fields[axis]);
  };
  MovedPoint moved;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const NumberT place = static_cast<NumberT>(settings.pose.sign[axis]) *
                              coordinate(settings.pose.source[axis]) +
                          static_cast<NumberT>(settings.pose.translation[axis]);
    if (!isFloat(static_cast<double>(coordinate(axis))) ||
        !isFloat(static_cast<double>(place))) {
      moved.is_finite = false;
      return moved;
    }
    moved.place[axis] = static_cast<float>(place);
    if (settings.crop_box)
      moved.is_within = moved.is_within &&
                        place >= static_cast<NumberT>((*settings.crop_box)[0][axis]) &&
                        place <= static_cast<NumberT>((*settings.crop_box)[1][axis]);
  }
  moved.depth = static_cast<float>(coordinate(2));
  return moved;
}

template <typename ModelT>
void
requireSamePoints(const pcl::PCLPointCloud2& cloud,
                  const Fields& fields,
                  const PreprocessorSettings& settings,
                  const ModelT& model,
                  const Output& output,
                  const PreprocessingStatistics& statistics)
{
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  // Rows without points may be billions.
  const std::size_t rows = cloud.width == 0 ? 0 : cloud.height;
  const std::size_t bytes_of_row = bytesOfRow(cloud);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* const point =
          cloud.data.data() + row * bytes_of_row + column * cloud.point_step;
      const MovedPoint moved = isFar(settings) || needDoubles(fields)
                                   ? movePoint<double>(point, fields, settings)
                                   : movePoint<float>(point, fields, settings);
      not_finite += moved.is_finite ? 0 : 1;
      if (!moved.is_finite || !moved.is_within)
        continue;
      require(kept < output.size());
      const PointXYZRGBI& result = output[kept++];
      require(result.x == moved.place[0] && result.y == moved.place[1] &&
              result.z == moved.place[2]);
      const float native =
          fields[3] != nullptr ? readField<float>(point, *fields[3]) : 0.0f;
      require(isNear(result.intensity,
                     expectedIntensity(model, moved.depth, native),
                     settings.scale));
      const std::uint32_t colour =
          fields[4] != nullptr ? numberAt<std::uint32_t>(point + fields[4]->offset)
                               : 0xff000000u;
      require(result.rgba == colour);
    }
  require(output.size() == kept && output.width == kept && output.height == 1);
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  require(statistics.points == points);
  require(statistics.points_not_finite == not_finite);
  require(statistics.points_cropped == points - kept - not_finite);
  require(output.is_dense && output.header.frame_id == cloud.header.frame_id &&
          output.header.stamp == cloud.header.stamp);
}

template <typename ModelT>
void
requireSame(const pcl::PCLPointCloud2& cloud, const PreprocessorSettings& settings)
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

  Fields fields;
  const Faults faults = findFaults(cloud,
                                   settings.intensity_field,
                                   ModelT::uses_native,
                                   settings.reads_colours,
                                   fields);
  if (status.ok()) {
    require(settings.areValid() && faults.empty());
    requireSamePoints(
        cloud, fields, settings, model, output, preprocessor.statistics());
    return;
  }
  require(!status.message().empty());
  require(output.empty() && output.width == 0);
  require(preprocessor.statistics().points == 0);
  require(status.code() == PreprocessingCode::InvalidSettings
              ? !settings.areValid()
              : faults.count(status.code()) == 1);
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
    requireSame<CountIntensity>(cloud, settings);
    break;
  case 1:
    requireSame<QuadraticIntensity>(cloud, settings);
    break;
  default:
    requireSame<NativeIntensity>(cloud, settings);
  }
  return 0;
}
