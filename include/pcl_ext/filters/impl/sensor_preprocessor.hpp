// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/saturated_float.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/rigid_pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI {

namespace detail {

/** \brief Datatypes that pcl::PCLPointField names only since PCL 1.13. */
constexpr std::uint8_t int64_datatype = 9;
constexpr std::uint8_t uint64_datatype = 10;
constexpr std::uint8_t bool_datatype = 11;

/** \brief Reads a number that need not be aligned. */
template <typename NumberT>
NumberT
readNumber(const std::uint8_t* bytes)
{
  NumberT number;
  std::memcpy(&number, bytes, sizeof(number));
  return number;
}

/** \brief Reads a number of a datatype of pcl::PCLPointField as another type. */
template <typename NumberT>
NumberT
readScalar(const std::uint8_t* bytes, std::uint8_t datatype)
{
  switch (datatype) {
  case pcl::PCLPointField::INT8:
    return static_cast<NumberT>(readNumber<std::int8_t>(bytes));
  case pcl::PCLPointField::UINT8:
    return static_cast<NumberT>(readNumber<std::uint8_t>(bytes));
  case pcl::PCLPointField::INT16:
    return static_cast<NumberT>(readNumber<std::int16_t>(bytes));
  case pcl::PCLPointField::UINT16:
    return static_cast<NumberT>(readNumber<std::uint16_t>(bytes));
  case pcl::PCLPointField::INT32:
    return static_cast<NumberT>(readNumber<std::int32_t>(bytes));
  case pcl::PCLPointField::UINT32:
    return static_cast<NumberT>(readNumber<std::uint32_t>(bytes));
  case pcl::PCLPointField::FLOAT64:
    return static_cast<NumberT>(readNumber<double>(bytes));
  case int64_datatype:
    return static_cast<NumberT>(readNumber<std::int64_t>(bytes));
  case uint64_datatype:
    return static_cast<NumberT>(readNumber<std::uint64_t>(bytes));
  case bool_datatype:
    return static_cast<NumberT>(readNumber<std::uint8_t>(bytes) != 0 ? 1 : 0);
  default:
    return static_cast<NumberT>(readNumber<float>(bytes));
  }
}

/** \brief Reads x, y and z of a point. */
template <typename NumberT>
Eigen::Matrix<NumberT, 3, 1>
readPoint(const std::uint8_t* bytes, const PointLayout& layout)
{
  return {readScalar<NumberT>(bytes + layout.x, layout.types[0]),
          readScalar<NumberT>(bytes + layout.y, layout.types[1]),
          readScalar<NumberT>(bytes + layout.z, layout.types[2])};
}

/** \brief True if x, y and z of each point are consecutive floats, as in all of PCL's
 * types; false for an empty cloud. */
template <typename PointT>
bool
hasConsecutiveFloats([[maybe_unused]] const pcl::PointCloud<PointT>& cloud)
{
  if constexpr (std::is_same<decltype(PointT::x), float>::value &&
                std::is_same<decltype(PointT::y), float>::value &&
                std::is_same<decltype(PointT::z), float>::value)
    return !cloud.empty() && &cloud[0].y == &cloud[0].x + 1 &&
           &cloud[0].z == &cloud[0].y + 1;
  else
    return false;
}

} // namespace detail

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT, OutputPointT>::process(
    const pcl::PCLPointCloud2& cloud, Output& output)
{
  startOutput(cloud.header, output);
  PointLayout layout;
  if (PreprocessingStatus status = start(cloud, layout); !status.ok())
    return status;
  output.reserve(statistics_.points);
  // An empty cloud may declare any number of rows.
  const std::size_t rows = cloud.width == 0 ? 0 : cloud.height;
  for (std::size_t row = 0; row < rows; ++row)
    addChunks(
        cloud.width,
        [&](std::size_t column, std::size_t most, OutputPointT* results) {
          return readChunk(cloud, layout, row, column, most, results, nullptr);
        },
        output);
  finishOutput(output);
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
template <typename PointT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT, OutputPointT>::process(
    const pcl::PointCloud<PointT>& cloud, Output& output)
{
  if constexpr (std::is_same<PointT, OutputPointT>::value)
    if (&cloud == &output) {
      // Swapped to reuse the memory of both.
      input_.swap(output);
      return process(input_, output);
    }
  startOutput(cloud.header, output);
  if (PreprocessingStatus status = checkSettings(); !status.ok())
    return status;
  if (IntensityModelT::uses_native && !has_intensity_field<PointT>)
    return {PreprocessingCode::MissingField,
            "the intensity model is native, but the point type has no intensity"};
  startPoints(cloud.size(), reads_colours_ && has_colour_field<PointT>);
  output.reserve(cloud.size());
  const bool is_consecutive = detail::hasConsecutiveFloats(cloud);
  const auto move_chunk =
      [&](std::size_t begin, std::size_t most, OutputPointT* results) {
        const auto native_of = [&](std::size_t i) {
          return nativeIntensity(cloud[begin + i], 0.0f);
        };
        const auto colour_of = [&]([[maybe_unused]] std::size_t i) {
          if constexpr (has_colour_field<PointT>)
            return packedColour(cloud[begin + i]);
          else
            return std::uint32_t{0};
        };
        if (is_consecutive)
          return moveChunk({reinterpret_cast<const unsigned char*>(&cloud[begin].x),
                            sizeof(PointT),
                            most},
                           native_of,
                           colour_of,
                           results);
        return gatherChunk(
            most,
            [&](std::size_t i) {
              const PointT& point = cloud[begin + i];
              return Eigen::Vector3f(point.x, point.y, point.z);
            },
            native_of,
            colour_of,
            results);
      };
  addChunks(cloud.size(), move_chunk, output);
  finishOutput(output);
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT, OutputPointT>::start(
    const pcl::PCLPointCloud2& cloud, PointLayout& layout)
{
  if (PreprocessingStatus status = checkSettings(); !status.ok())
    return status;
  if (PreprocessingStatus status = findPointLayout(cloud,
                                                   intensity_field_,
                                                   IntensityModelT::uses_native,
                                                   reads_colours_,
                                                   layout);
      !status.ok())
    return status;
  startPoints(std::size_t{cloud.width} * cloud.height, layout.has_colour);
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT, OutputPointT>::checkSettings() const
{
  if (!isRigid(sensor_pose_.cast<float>()))
    return {PreprocessingCode::InvalidSettings,
            "the sensor pose is not a rotation and a translation"};
  if (crop_box_ && !(crop_box_->min.array() <= crop_box_->max.array()).all())
    return {PreprocessingCode::InvalidSettings,
            "the crop box has a min above its max, or is not a number"};
  if (!std::isfinite(intensity_scale_) || !(intensity_scale_ > 0.0f))
    return {PreprocessingCode::InvalidSettings,
            "the intensity scale is " + std::to_string(intensity_scale_) +
                "; it must be above 0"};
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
void
SensorPreprocessor<IntensityModelT, OutputPointT>::startOutput(
    const pcl::PCLHeader& header, Output& output)
{
  statistics_ = PreprocessingStatistics();
  output.clear();
  output.header = header;
  output.is_dense = true;
  const Eigen::Isometry3f sensor_pose = sensor_pose_.cast<float>();
  output.sensor_origin_ << sensor_pose.translation(), 1.0f;
  output.sensor_orientation_ = Eigen::Quaternionf(sensor_pose.linear());
  kept_ = 0;
}

template <typename IntensityModelT, typename OutputPointT>
void
SensorPreprocessor<IntensityModelT, OutputPointT>::startPoints(std::size_t points,
                                                               bool has_colours)
{
  statistics_ = PreprocessingStatistics();
  statistics_.points = points;
  statistics_.has_colours = has_colours;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (Eigen::Index row = 0; row < 3; ++row) {
    const auto axis = static_cast<std::size_t>(row);
    for (Eigen::Index column = 0; column < 4; ++column)
      move_.rows[axis][static_cast<std::size_t>(column)] =
          detail::saturatedFloat(sensor_pose_.matrix()(row, column));
    move_.min[axis] =
        crop_box_ ? detail::saturatedFloat(crop_box_->min[row]) : -infinity;
    move_.max[axis] =
        crop_box_ ? detail::saturatedFloat(crop_box_->max[row]) : infinity;
  }
}

template <typename IntensityModelT, typename OutputPointT>
template <typename MoveChunkT>
void
SensorPreprocessor<IntensityModelT, OutputPointT>::addChunks(
    std::size_t count, const MoveChunkT& move_chunk, Output& output)
{
  for (std::size_t begin = 0; begin < count; begin += detail::MovedPoints::capacity) {
    const std::size_t most = std::min(detail::MovedPoints::capacity, count - begin);
    if (output.points.size() < kept_ + most)
      output.points.resize(kept_ + most);
    kept_ += move_chunk(begin, most, &output.points[kept_]);
  }
}

template <typename IntensityModelT, typename OutputPointT>
std::size_t
SensorPreprocessor<IntensityModelT, OutputPointT>::readChunk(
    const pcl::PCLPointCloud2& cloud,
    const PointLayout& layout,
    std::size_t row,
    std::size_t column,
    std::size_t most,
    OutputPointT* results,
    DoublePoint* doubles)
{
  const std::uint8_t* const bytes =
      cloud.data.data() + row * rowStep(cloud) + column * cloud.point_step;
  const auto native_of = [&](std::size_t i) {
    return layout.has_intensity ? detail::readScalar<float>(
                                      bytes + i * cloud.point_step + layout.intensity,
                                      layout.intensity_datatype)
                                : 0.0f;
  };
  const auto colour_of = [&](std::size_t i) {
    return detail::readNumber<std::uint32_t>(bytes + i * cloud.point_step +
                                             layout.colour);
  };
  if (movesDoubles(layout))
    return moveDoubles(
        most,
        [&](std::size_t i) {
          return detail::readPoint<double>(bytes + i * cloud.point_step, layout);
        },
        native_of,
        colour_of,
        results,
        doubles);
  const bool is_consecutive = areReal(layout.types) &&
                              layout.y == layout.x + sizeof(float) &&
                              layout.z == layout.y + sizeof(float);
  if (is_consecutive)
    return moveChunk(
        {bytes + layout.x, cloud.point_step, most}, native_of, colour_of, results);
  return gatherChunk(
      most,
      [&](std::size_t i) {
        return detail::readPoint<float>(bytes + i * cloud.point_step, layout);
      },
      native_of,
      colour_of,
      results);
}

template <typename IntensityModelT, typename OutputPointT>
template <typename NativeOfT, typename ColourOfT>
std::size_t
SensorPreprocessor<IntensityModelT, OutputPointT>::moveChunk(
    const detail::PointBytes& points,
    const NativeOfT& native_of,
    const ColourOfT& colour_of,
    OutputPointT* results)
{
  static_assert(
      sizeof(OutputPointT) == detail::moved_point_floats * sizeof(float) &&
          pcl::traits::offset<OutputPointT, pcl::fields::x>::value == 0,
      "the output type has to have 32 bytes and to begin with PCL_ADD_POINT4D, "
      "as pcl::PointXYZI and pcl_ext::PointXYZRGBI");
  detail::MovedPoints moved;
  detail::movePoints(points, move_, results->data, moved);
  finishChunk(points.count, moved, native_of, colour_of, results);
  return moved.count;
}

template <typename IntensityModelT, typename OutputPointT>
template <typename NativeOfT, typename ColourOfT>
void
SensorPreprocessor<IntensityModelT, OutputPointT>::finishChunk(
    std::size_t count,
    const detail::MovedPoints& moved,
    const NativeOfT& native_of,
    const ColourOfT& colour_of,
    OutputPointT* results)
{
  for (std::size_t i = 0; i < moved.count; ++i) {
    const float native =
        IntensityModelT::uses_native ? native_of(moved.sources[i]) : 0.0f;
    setNativeIntensity(results[i],
                       intensity_scale_ * intensity_model_(moved.depths[i], native));
    if (IntensityModelT::uses_depth)
      statistics_.points_behind_sensor += moved.depths[i] < 0.0f ? 1 : 0;
  }
  if (statistics_.has_colours)
    for (std::size_t i = 0; i < moved.count; ++i)
      setPackedColour(results[i], colour_of(moved.sources[i]));
  if (sources_ != nullptr)
    sources_->insert(
        sources_->end(), moved.sources.begin(), moved.sources.begin() + moved.count);
  statistics_.points_not_finite += moved.not_finite;
  statistics_.points_cropped += count - moved.count - moved.not_finite;
}

/** \brief Whether floats would cost precision: those of the global coordinate frame
 * have steps of 0.1 mm and more beyond 1024 m. */
template <typename IntensityModelT, typename OutputPointT>
bool
SensorPreprocessor<IntensityModelT, OutputPointT>::movesDoubles(
    const PointLayout& layout) const
{
  constexpr double farthest = 1024.0; // m
  return layout.is_double ||
         sensor_pose_.translation().template lpNorm<Eigen::Infinity>() > farthest;
}

/** \brief Moves points in double precision.
 * \param[out] doubles the coordinates of the results; may be null
 */
template <typename IntensityModelT, typename OutputPointT>
template <typename PointOfT, typename NativeOfT, typename ColourOfT>
std::size_t
SensorPreprocessor<IntensityModelT, OutputPointT>::moveDoubles(
    std::size_t count,
    const PointOfT& point_of,
    const NativeOfT& native_of,
    const ColourOfT& colour_of,
    OutputPointT* results,
    DoublePoint* doubles)
{
  // NaN is not within their range.
  const auto is_in_range_of_floats = [](const Eigen::Vector3d& position) {
    return (position.array().abs() <= double{std::numeric_limits<float>::max()}).all();
  };
  detail::MovedPoints moved;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d point = point_of(i);
    const Eigen::Vector3d position = sensor_pose_ * point;
    if (!is_in_range_of_floats(point) || !is_in_range_of_floats(position)) {
      ++moved.not_finite;
      continue;
    }
    if (crop_box_ && !((position.array() >= crop_box_->min.array()).all() &&
                       (position.array() <= crop_box_->max.array()).all()))
      continue;
    results[moved.count].getVector4fMap() << position.cast<float>(), 1.0f;
    if (doubles != nullptr)
      doubles[moved.count] = {position.x(), position.y(), position.z()};
    moved.depths[moved.count] = static_cast<float>(point.z());
    moved.sources[moved.count] = static_cast<std::uint32_t>(i);
    ++moved.count;
  }
  finishChunk(count, moved, native_of, colour_of, results);
  return moved.count;
}

template <typename IntensityModelT, typename OutputPointT>
template <typename PointOfT, typename NativeOfT, typename ColourOfT>
std::size_t
SensorPreprocessor<IntensityModelT, OutputPointT>::gatherChunk(
    std::size_t count,
    const PointOfT& point_of,
    const NativeOfT& native_of,
    const ColourOfT& colour_of,
    OutputPointT* results)
{
  std::array<std::array<float, 3>, detail::MovedPoints::capacity> points;
  for (std::size_t i = 0; i < count; ++i)
    Eigen::Map<Eigen::Vector3f>(points[i].data()) = point_of(i);
  return moveChunk(
      {reinterpret_cast<const unsigned char*>(points.data()), sizeof(points[0]), count},
      native_of,
      colour_of,
      results);
}

template <typename IntensityModelT, typename OutputPointT>
void
SensorPreprocessor<IntensityModelT, OutputPointT>::finishOutput(Output& output) const
{
  output.points.resize(kept_);
  output.width = static_cast<std::uint32_t>(kept_);
  output.height = 1;
}

} // namespace pcl_ext::PCL_EXT_ABI
