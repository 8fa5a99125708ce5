// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_cloud.h"

#include "codec/scan/scan_frame.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/ring_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief One row or column is no image. */
bool
isImage(const ImageSize& size)
{
  return size.width > 1 && size.height > 1;
}

/** \brief Makes room for so many elements, of which some are there. */
template <typename ElementT>
void
grow(std::vector<ElementT>& elements, std::size_t size)
{
  if (elements.size() < size)
    elements.resize(size);
}

/** \brief Clears what is appended to; the rest is overwritten. */
void
clear(SensorCloud& cloud, std::size_t field_count)
{
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
  cloud.columns = cloud.image.width;
  if (cloud.image.width > scan::most_side || cloud.image.height > scan::most_side ||
      std::uint64_t{cloud.image.width} * cloud.image.height > scan::most_pixels)
    return false;
  ring_ = cloud.image.width > 0 ? std::nullopt : findRing(points.fields());
  if (!ring_)
    cloud.rings.clear();
  if (cloud.image.width == 0)
    cloud.pixels.clear();
  // Not filled before, as many points may be missing.
  cloud.positions.reserve(points.size());
  (cloud.image.width > 0 ? cloud.pixels : cloud.rings).reserve(points.size());
  first_ = 0;
  used_ = 0;
  points.restart();
  for (PointView batch; points.next(batch); first_ += batch.count) {
    const bool has_order = batch.double_coordinates != nullptr
                               ? readBatch(batch, batch.double_coordinates, cloud)
                               : readBatch(batch, batch.coordinates, cloud);
    if (!has_order)
      return false;
    readAttributes(batch, cloud);
  }
  cloud.positions.resize(used_);
  cloud.rings.resize(std::min(cloud.rings.size(), used_));
  cloud.pixels.resize(std::min(cloud.pixels.size(), used_));
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
  constexpr std::size_t points_at_once = 4096;
  batch_.clear();
  cloud.statistics.points += points.count;
  for (std::size_t begin = 0; begin < points.count; begin += points_at_once) {
    const std::size_t end = std::min(begin + points_at_once, points.count);
    if (!readPart(points, coordinates, begin, end, cloud))
      return false;
  }
  return true;
}

/** \brief Reads some of the points of a batch. */
template <typename NumberT>
bool
SensorCloudReader::readPart(const PointView& points,
                            const NumberT* coordinates,
                            std::size_t begin,
                            std::size_t end,
                            SensorCloud& cloud)
{
  std::optional<RingReader> rings;
  if (ring_)
    rings.emplace(points.fields[*ring_]);
  const bool has_pixels = cloud.image.width > 0;
  const std::size_t pixel_count = std::size_t{cloud.image.width} * cloud.image.height;
  const bool has_attributes = contents_.intensities || contents_.colours ||
                              !contents_.fields->selected().empty();
  const std::size_t before = batch_.size();
  batch_.resize(has_attributes ? before + end - begin : 0);
  grow(cloud.positions, used_ + end - begin);
  if (rings)
    grow(cloud.rings, used_ + end - begin);
  if (has_pixels)
    grow(cloud.pixels, used_ + end - begin);
  // By pointers that nothing else changes, as there are many points.
  std::array<double, 3>* const positions = cloud.positions.data() + used_;
  std::uint32_t* const cloud_rings = rings ? cloud.rings.data() + used_ : nullptr;
  std::uint32_t* const pixels = has_pixels ? cloud.pixels.data() + used_ : nullptr;
  std::uint32_t* const batch = batch_.data() + before;
  std::size_t not_finite = 0;
  std::size_t outside_box = 0;
  std::size_t used = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const NumberT* const xyz =
        detail::atOffset(coordinates, i * points.coordinate_stride);
    if (!isFinite(xyz)) {
      ++not_finite;
      continue;
    }
    const std::array<double, 3> position = {static_cast<double>(xyz[0]),
                                            static_cast<double>(xyz[1]),
                                            static_cast<double>(xyz[2])};
    if (contents_.box && !isInside(*contents_.box, xyz)) {
      ++outside_box;
      continue;
    }
    if (rings)
      cloud_rings[used] = rings->row(i);
    else if (has_pixels) {
      const std::size_t pixel =
          points.pixels != nullptr ? points.pixels[i] : first_ + i;
      if (pixel >= pixel_count)
        return false;
      pixels[used] = static_cast<std::uint32_t>(pixel);
    }
    if (has_attributes)
      batch[used] = static_cast<std::uint32_t>(i);
    positions[used++] = position;
  }
  batch_.resize(has_attributes ? before + used : 0);
  used_ += used;
  cloud.statistics.points_not_finite += not_finite;
  cloud.statistics.points_outside_box += outside_box;
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
      cloud.statistics.alphas_left_out +=
          contents_.fields->losesAlpha() && colour >> 24 != 0xff ? 1 : 0;
    }
  contents_.fields->readPoints(points, batch_, cloud.numbers);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
