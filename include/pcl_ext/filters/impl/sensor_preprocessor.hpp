#pragma once

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/rigid_pose.h>

#include <cmath>
#include <cstring>
#include <type_traits>

namespace pcl_ext {

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

/** \brief Reads a number of a datatype of pcl::PCLPointField as a float. */
inline float
readScalar(const std::uint8_t* bytes, std::uint8_t datatype)
{
  switch (datatype) {
  case pcl::PCLPointField::INT8:
    return static_cast<float>(readNumber<std::int8_t>(bytes));
  case pcl::PCLPointField::UINT8:
    return static_cast<float>(readNumber<std::uint8_t>(bytes));
  case pcl::PCLPointField::INT16:
    return static_cast<float>(readNumber<std::int16_t>(bytes));
  case pcl::PCLPointField::UINT16:
    return static_cast<float>(readNumber<std::uint16_t>(bytes));
  case pcl::PCLPointField::INT32:
    return static_cast<float>(readNumber<std::int32_t>(bytes));
  case pcl::PCLPointField::UINT32:
    return static_cast<float>(readNumber<std::uint32_t>(bytes));
  case pcl::PCLPointField::FLOAT64:
    return static_cast<float>(readNumber<double>(bytes));
  case int64_datatype:
    return static_cast<float>(readNumber<std::int64_t>(bytes));
  case uint64_datatype:
    return static_cast<float>(readNumber<std::uint64_t>(bytes));
  case bool_datatype:
    return readNumber<std::uint8_t>(bytes) != 0 ? 1.0f : 0.0f;
  default:
    return readNumber<float>(bytes);
  }
}

} // namespace detail

template <typename IntensityModelT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT>::process(const pcl::PCLPointCloud2& cloud,
                                             Output& output)
{
  startOutput(cloud.header, 0, output);
  if (PreprocessingStatus status = checkSettings(); !status.ok())
    return status;
  PointLayout layout;
  if (PreprocessingStatus status = findPointLayout(
          cloud, intensity_field_, IntensityModelT::uses_native, layout);
      !status.ok())
    return status;

  startOutput(cloud.header, std::size_t{cloud.width} * cloud.height, output);
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* bytes = cloud.data.data() + row * cloud.row_step;
    for (std::size_t column = 0; column < cloud.width;
         ++column, bytes += cloud.point_step) {
      Eigen::Vector3f point;
      if (layout.is_double)
        point = Eigen::Vector3d(detail::readNumber<double>(bytes + layout.x),
                                detail::readNumber<double>(bytes + layout.y),
                                detail::readNumber<double>(bytes + layout.z))
                    .cast<float>();
      else
        point = {detail::readNumber<float>(bytes + layout.x),
                 detail::readNumber<float>(bytes + layout.y),
                 detail::readNumber<float>(bytes + layout.z)};
      addPoint(point,
               layout.has_intensity ? detail::readScalar(bytes + layout.intensity,
                                                         layout.intensity_datatype)
                                    : 0.0f,
               output);
    }
  }
  finishOutput(output);
  return {};
}

template <typename IntensityModelT>
template <typename PointT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT>::process(const pcl::PointCloud<PointT>& cloud,
                                             Output& output)
{
  if constexpr (std::is_same<PointT, pcl::PointXYZI>::value)
    if (&cloud == &output) {
      const Output copy = cloud;
      return process(copy, output);
    }
  startOutput(cloud.header, 0, output);
  if (PreprocessingStatus status = checkSettings(); !status.ok())
    return status;
  if (IntensityModelT::uses_native && !has_intensity_field<PointT>)
    return {PreprocessingCode::MissingField,
            "the intensity model is native, but the point type has no intensity"};
  startOutput(cloud.header, cloud.size(), output);
  for (const PointT& point : cloud)
    addPoint({point.x, point.y, point.z}, nativeIntensity(point, 0.0f), output);
  finishOutput(output);
  return {};
}

template <typename IntensityModelT>
PreprocessingStatus
SensorPreprocessor<IntensityModelT>::checkSettings() const
{
  if (!isRigid(sensor_pose_))
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

template <typename IntensityModelT>
void
SensorPreprocessor<IntensityModelT>::startOutput(const pcl::PCLHeader& header,
                                                 std::size_t points,
                                                 Output& output)
{
  statistics_ = PreprocessingStatistics();
  statistics_.points = points;
  output.clear();
  output.reserve(points);
  output.header = header;
  output.is_dense = true;
  output.sensor_origin_ << sensor_pose_.translation(), 1.0f;
  output.sensor_orientation_ = Eigen::Quaternionf(sensor_pose_.linear());
}

template <typename IntensityModelT>
void
SensorPreprocessor<IntensityModelT>::addPoint(const Eigen::Vector3f& point,
                                              float native,
                                              Output& output)
{
  // A point that is not finite does not become so, and a finite one may stop being it.
  const Eigen::Vector3f moved = sensor_pose_ * point;
  if (!moved.allFinite()) {
    ++statistics_.points_not_finite;
    return;
  }
  if (crop_box_ && !((moved.array() >= crop_box_->min.array()).all() &&
                     (moved.array() <= crop_box_->max.array()).all())) {
    ++statistics_.points_cropped;
    return;
  }
  pcl::PointXYZI result;
  result.getVector3fMap() = moved;
  result.intensity = intensity_scale_ * intensity_model_(point.z(), native);
  output.points.push_back(result);
}

template <typename IntensityModelT>
void
SensorPreprocessor<IntensityModelT>::finishOutput(Output& output) const
{
  output.width = static_cast<std::uint32_t>(output.points.size());
  output.height = 1;
}

} // namespace pcl_ext
