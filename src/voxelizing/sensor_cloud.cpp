// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_cloud.h"

#include "codec/scan/scan_frame.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/ring_field.h"

#include <cmath>
#include <cstring>

namespace pcl_ext {
namespace io {

namespace {

/** \brief One row or column is no image. */
bool
isImage(const ImageSize& size)
{
  return size.width > 1 && size.height > 1;
}

bool
isInside(const std::optional<BoundingBox>& box, const std::array<double, 3>& position)
{
  for (std::size_t axis = 0; box && axis < 3; ++axis)
    if (position[axis] < box->min[axis] || position[axis] > box->max[axis])
      return false;
  return true;
}

void
clear(SensorCloud& cloud, std::size_t field_count)
{
  cloud.pixels.clear();
  cloud.rings.clear();
  cloud.positions.clear();
  cloud.intensities.clear();
  cloud.intensity_step = CommonStep();
  cloud.colours.clear();
  cloud.numbers.resize(field_count);
  for (std::vector<std::uint64_t>& numbers : cloud.numbers)
    numbers.clear();
  cloud.statistics = VoxelizationStatistics();
}

} // namespace

bool
SensorCloudReader::read(PointBatches& points,
                        const Contents& contents,
                        SensorCloud& cloud)
{
  contents_ = contents;
  clear(cloud, contents.fields->selected().size());
  cloud.image = isImage(points.imageSize()) ? points.imageSize() : ImageSize();
  if (cloud.image.width > scan::most_side || cloud.image.height > scan::most_side ||
      std::uint64_t{cloud.image.width} * cloud.image.height > scan::most_pixels)
    return false;
  ring_ = cloud.image.width > 0 ? std::nullopt : findRing(points.fields());
  cloud.positions.reserve(points.size());
  first_ = 0;
  points.restart();
  for (PointView batch; points.next(batch); first_ += batch.count) {
    const bool has_order = batch.double_coordinates != nullptr
                               ? readBatch(batch, batch.double_coordinates, cloud)
                               : readBatch(batch, batch.coordinates, cloud);
    if (!has_order)
      return false;
    readAttributes(batch, cloud);
  }
  cloud.statistics.points_behind_sensor = points.pointsBehindSensor();
  cloud.statistics.points += cloud.statistics.points_behind_sensor;
  cloud.statistics.points_used = cloud.size();
  return true;
}

/** \brief Reads which points are usable, where they are, and their pixels or rings. */
template <typename NumberT>
bool
SensorCloudReader::readBatch(const PointView& points,
                             const NumberT* coordinates,
                             SensorCloud& cloud)
{
  batch_.clear();
  std::optional<RingReader> rings;
  if (ring_)
    rings.emplace(points.fields[*ring_]);
  const std::size_t pixel_count = std::size_t{cloud.image.width} * cloud.image.height;
  cloud.statistics.points += points.count;
  for (std::size_t i = 0; i < points.count; ++i) {
    const NumberT* const xyz =
        detail::atOffset(coordinates, i * points.coordinate_stride);
    if (!isFinite(xyz)) {
      ++cloud.statistics.points_not_finite;
      continue;
    }
    const std::array<double, 3> position = {static_cast<double>(xyz[0]),
                                            static_cast<double>(xyz[1]),
                                            static_cast<double>(xyz[2])};
    if (!isInside(contents_.box, position)) {
      ++cloud.statistics.points_outside_box;
      continue;
    }
    if (rings)
      cloud.rings.push_back(rings->row(i));
    else if (pixel_count > 0) {
      const std::size_t pixel =
          points.pixels != nullptr ? points.pixels[i] : first_ + i;
      if (pixel >= pixel_count)
        return false;
      cloud.pixels.push_back(static_cast<std::uint32_t>(pixel));
    }
    cloud.positions.push_back(position);
    batch_.push_back(static_cast<std::uint32_t>(i));
  }
  return true;
}

/** \brief Reads what else the usable points of a batch have. */
void
SensorCloudReader::readAttributes(const PointView& points, SensorCloud& cloud) const
{
  if (contents_.intensities)
    for (const std::uint32_t i : batch_) {
      float intensity =
          points.intensities != nullptr
              ? *detail::atOffset(points.intensities, i * points.intensity_stride)
              : 1.0f;
      if (!std::isfinite(intensity)) {
        ++cloud.statistics.intensities_not_finite;
        intensity = 0.0f;
      }
      cloud.intensity_step.add(intensity);
      cloud.intensities.push_back(static_cast<double>(intensity));
    }
  if (contents_.colours)
    for (const std::uint32_t i : batch_) {
      std::uint32_t colour = 0;
      std::memcpy(&colour,
                  static_cast<const unsigned char*>(points.colours) +
                      i * points.colour_stride,
                  sizeof(colour));
      cloud.colours.push_back(colour);
    }
  contents_.fields->readPoints(points, batch_, cloud.numbers);
}

} // namespace io
} // namespace pcl_ext
