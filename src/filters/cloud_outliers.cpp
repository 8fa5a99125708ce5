// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "filters/cloud_outliers.h"

#include <cstring>
#include <limits>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

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
  NumberT* number = coordinates.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* const point = cloud.data.data() + offsetOf(cloud, i);
    for (const std::uint32_t offset : {layout_.x, layout_.y, layout_.z})
      std::memcpy(number++, point + offset, sizeof(NumberT));
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

void
CloudOutliers::hide(pcl::PCLPointCloud2& cloud) const
{
  const auto set = [](std::uint8_t* bytes, auto number) {
    std::memcpy(bytes, &number, sizeof(number));
  };
  for (std::size_t i = 0; i < are_outliers_.size(); ++i) {
    if (!are_outliers_[i])
      continue;
    std::uint8_t* const point = cloud.data.data() + offsetOf(cloud, i);
    for (const std::uint32_t offset : {layout_.x, layout_.y, layout_.z})
      if (layout_.is_double)
        set(point + offset, std::numeric_limits<double>::quiet_NaN());
      else
        set(point + offset, std::numeric_limits<float>::quiet_NaN());
    cloud.is_dense = 0;
  }
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

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
