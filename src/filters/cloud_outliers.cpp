// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "filters/cloud_outliers.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI {

std::size_t
CloudOutliers::offsetOf(const pcl::PCLPointCloud2& cloud, std::size_t point) const
{
  return point / cloud.width * rowStep(cloud) + point % cloud.width * cloud.point_step;
}

template <typename NumberT>
const NumberT*
CloudOutliers::readCoordinates(const pcl::PCLPointCloud2& cloud,
                               std::vector<NumberT>& coordinates) const
{
  const std::size_t count = std::size_t{cloud.width} * cloud.height;
  coordinates.resize(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* const bytes = cloud.data.data() + offsetOf(cloud, i);
    const Eigen::Matrix<NumberT, 3, 1> point =
        detail::readPoint<NumberT>(bytes, layout_);
    std::copy_n(point.data(), 3, &coordinates[3 * i]);
  }
  return coordinates.data();
}

OutlierRemovalStatus
CloudOutliers::find(const pcl::PCLPointCloud2& cloud, PointOutlierRemoval& removal)
{
  are_outliers_.clear();
  const PreprocessingStatus layout =
      findPointLayout(cloud, std::string(), false, false, layout_);
  if (!layout.ok())
    return {OutlierRemovalCode::InvalidCloud, layout.message()};
  io::PointView points;
  points.count = std::size_t{cloud.width} * cloud.height;
  if (layout_.is_double)
    points.double_coordinates = readCoordinates(cloud, double_coordinates_);
  else
    points.coordinates = readCoordinates(cloud, coordinates_);
  points.coordinate_stride = 3 * (layout_.is_double ? sizeof(double) : sizeof(float));
  if (cloud.height > 1)
    points.image = {cloud.width, cloud.height};
  // Of which a view has the same distance from each point to the next one.
  if (cloud.height == 1 ||
      rowStep(cloud) == std::size_t{cloud.width} * cloud.point_step)
    for (const FoundField& field : findFields(cloud))
      points.fields.push_back(
          {field.description, cloud.data.data() + field.offset, cloud.point_step});
  OutlierRemovalStatus status = removal.score(points, log_odds_);
  if (status.ok())
    for (const float log_odds : log_odds_)
      are_outliers_.push_back(log_odds < removal.settings().min_log_odds);
  return status;
}

template <typename NumberT>
void
CloudOutliers::makeReal(pcl::PCLPointCloud2& cloud)
{
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  const std::size_t step = cloud.point_step + 3 * sizeof(NumberT);
  std::vector<std::uint8_t> data(points * step);
  for (std::size_t i = 0; i < points; ++i) {
    const std::uint8_t* const from = cloud.data.data() + offsetOf(cloud, i);
    const Eigen::Matrix<NumberT, 3, 1> point =
        detail::readPoint<NumberT>(from, layout_);
    std::uint8_t* const to = std::copy_n(from, cloud.point_step, &data[i * step]);
    std::memcpy(to, point.data(), 3 * sizeof(NumberT));
  }
  std::uint32_t* const offsets[] = {&layout_.x, &layout_.y, &layout_.z};
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const auto field = std::find_if(
        cloud.fields.begin(), cloud.fields.end(), [axis](const auto& candidate) {
          return candidate.name == std::string(1, static_cast<char>('x' + axis));
        });
    *offsets[axis] = cloud.point_step + axis * std::uint32_t{sizeof(NumberT)};
    layout_.types[axis] = std::is_same_v<NumberT, double> ? pcl::PCLPointField::FLOAT64
                                                          : pcl::PCLPointField::FLOAT32;
    field->offset = *offsets[axis];
    field->datatype = layout_.types[axis];
  }
  cloud.data = std::move(data);
  cloud.point_step = static_cast<std::uint32_t>(step);
  cloud.row_step = cloud.width * cloud.point_step;
}

template <typename NumberT>
void
CloudOutliers::hideAs(pcl::PCLPointCloud2& cloud)
{
  if (!areReal(layout_.types))
    makeReal<NumberT>(cloud);
  constexpr NumberT missing = std::numeric_limits<NumberT>::quiet_NaN();
  for (std::size_t i = 0; i < are_outliers_.size(); ++i) {
    if (!are_outliers_[i])
      continue;
    std::uint8_t* const point = cloud.data.data() + offsetOf(cloud, i);
    for (const std::uint32_t offset : {layout_.x, layout_.y, layout_.z})
      std::memcpy(point + offset, &missing, sizeof(missing));
    cloud.is_dense = 0;
  }
}

void
CloudOutliers::hide(pcl::PCLPointCloud2& cloud)
{
  if (layout_.is_double)
    hideAs<double>(cloud);
  else
    hideAs<float>(cloud);
}

void
CloudOutliers::erase(pcl::PCLPointCloud2& cloud) const
{
  std::size_t kept = 0;
  for (std::size_t i = 0; i < are_outliers_.size(); ++i)
    if (!are_outliers_[i])
      std::memmove(cloud.data.data() + kept++ * cloud.point_step,
                   cloud.data.data() + offsetOf(cloud, i),
                   cloud.point_step);
  cloud.width = static_cast<std::uint32_t>(kept);
  cloud.height = 1;
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.data.resize(cloud.row_step);
}

} // namespace pcl_ext::PCL_EXT_ABI
