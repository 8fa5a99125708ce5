// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/point_batches.h"

#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

CompressionStatus
checkView(const PointView& points)
{
  const auto invalid = [](const std::string& message) {
    return CompressionStatus(CompressionCode::InvalidInput, message);
  };
  if (points.count == 0)
    return {};
  const bool are_doubles = points.double_coordinates != nullptr;
  if (points.coordinates == nullptr && !are_doubles)
    return invalid("the view has points, but coordinates is null");
  const std::size_t number = are_doubles ? sizeof(double) : sizeof(float);
  if (points.count > 1 &&
      (points.coordinate_stride < 3 * number || points.coordinate_stride % number != 0))
    return invalid("coordinate_stride is " + std::to_string(points.coordinate_stride) +
                   "; it must be the bytes from one point to the next, a multiple of " +
                   std::to_string(number) + " of at least " +
                   std::to_string(3 * number));
  if (points.image.width > 0 && points.pixels == nullptr &&
      std::uint64_t{points.image.width} * points.image.height != points.count)
    return invalid("the image has " + std::to_string(points.image.width) + " x " +
                   std::to_string(points.image.height) + " pixels, but " +
                   std::to_string(points.count) + " points");
  for (const FieldView& field : points.fields)
    if (field.first == nullptr)
      return invalid("field '" + field.description.name + "' of the view is null");
  if (points.intensities != nullptr && points.intensity_stride % sizeof(float) != 0)
    return invalid("intensity_stride is " + std::to_string(points.intensity_stride) +
                   "; it must be a multiple of 4 bytes");
  return {};
}

PointBatches::~PointBatches() = default;

ImageSize
PointBatches::imageSize() const
{
  return {};
}

std::vector<FieldDescription>
PointBatches::fields() const
{
  return {};
}

std::size_t
PointBatches::pointsBehindSensor() const
{
  return 0;
}

std::vector<PointBatches*>
PointBatches::split(std::size_t /*parts*/)
{
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io
