// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/zero_field.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>

namespace pcl_ext::tools {

bool
addZeros(const pcl::PCLPointCloud2& cloud,
         const std::string& name,
         pcl::PCLPointCloud2& with_zeros)
{
  const std::size_t row_step = rowStep(cloud);
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  if (row == 0 || row > row_step || cloud.data.size() < row ||
      (cloud.data.size() - row) / row_step + 1 < cloud.height)
    return false;
  const std::size_t new_row = row + std::size_t{cloud.width} * sizeof(float);
  if (new_row > std::numeric_limits<std::uint32_t>::max())
    return false;
  with_zeros.header = cloud.header;
  with_zeros.width = cloud.width;
  with_zeros.height = cloud.height;
  with_zeros.is_bigendian = cloud.is_bigendian;
  with_zeros.is_dense = cloud.is_dense;
  with_zeros.fields.clear();
  std::copy_if(cloud.fields.begin(),
               cloud.fields.end(),
               std::back_inserter(with_zeros.fields),
               [&name](const auto& field) { return field.name != name; });
  pcl::PCLPointField& zeros = with_zeros.fields.emplace_back();
  zeros.name = name;
  zeros.offset = cloud.point_step;
  zeros.datatype = pcl::PCLPointField::FLOAT32;
  zeros.count = 1;
  with_zeros.point_step = cloud.point_step + static_cast<std::uint32_t>(sizeof(float));
  with_zeros.row_step = static_cast<std::uint32_t>(new_row);
  with_zeros.data.assign(std::size_t{with_zeros.row_step} * cloud.height, 0);
  for (std::size_t i = 0; i < cloud.height; ++i)
    for (std::size_t k = 0; k < cloud.width; ++k)
      std::copy_n(
          &cloud.data[i * row_step + k * cloud.point_step],
          cloud.point_step,
          &with_zeros.data[i * with_zeros.row_step + k * with_zeros.point_step]);
  return true;
}

} // namespace pcl_ext::tools
