// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/voxel_collector.h"

#include <cmath>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

CollectionResult
VoxelCollector::collect(PointBatches& points,
                        const VoxelLocator& locator,
                        const CollectedFields& fields,
                        bool is_sparse)
{
  fields_ = fields;
  is_sparse_ = is_sparse;
  statistics_ = VoxelizationStatistics();
  step_ = CommonStep();
  exactness_ = SumExactness();
  if (is_sparse_)
    sorted_voxels_.begin(fields, points.size());
  else
    blocks_.begin(fields);
  points.restart();
  for (PointView batch; points.next(batch);) {
    const CollectionResult result = collectBatch(batch, locator);
    if (result != CollectionResult::AllPoints)
      return result;
    statistics_.points += batch.count;
  }
  statistics_.points_behind_sensor = points.pointsBehindSensor();
  statistics_.points_used = statistics_.points - statistics_.points_not_finite -
                            statistics_.points_outside_box -
                            statistics_.points_outside_grid;
  return CollectionResult::AllPoints;
}

CollectionResult
VoxelCollector::collectBatch(const PointView& points, const VoxelLocator& locator)
{
  for (std::size_t i = 0; i < points.count; i += LocatedPoints::capacity) {
    if (!locator.find(points, i, located_, statistics_))
      return CollectionResult::PointOutsideGrid;
    if (fields_.intensities)
      readIntensities(points);
    if (fields_.colours)
      readColours(points);
    if (is_sparse_)
      sorted_voxels_.add(located_);
    else {
      blocks_.add(located_);
      if (blocks_.areTooSparse(statistics_.points + i))
        return CollectionResult::TooSparse;
    }
  }
  return CollectionResult::AllPoints;
}

/** \brief Reads the intensities of the points in located_. */
void
VoxelCollector::readIntensities(const PointView& points)
{
  bool are_whole = true;
  for (std::size_t i = 0; i < located_.count; ++i) {
    const float intensity = *detail::atOffset(
        points.intensities, located_.points[i] * points.intensity_stride);
    located_.intensities[i] = intensity;
    are_whole &= CommonStep::isSmallWholeNumber(intensity); // NaN is none
  }
  for (std::size_t i = 0; !are_whole && i < located_.count; ++i)
    if (!std::isfinite(located_.intensities[i])) {
      ++statistics_.intensities_not_finite;
      located_.intensities[i] = 0.0f;
    }
    else if (fields_.step)
      step_.add(located_.intensities[i]);
  if (fields_.exactness)
    exactness_.add(located_.intensities.data(), located_.count, are_whole);
}

/** \brief Reads the colours of the points in located_. */
void
VoxelCollector::readColours(const PointView& points)
{
  const auto* const bytes = static_cast<const unsigned char*>(points.colours);
  for (std::size_t i = 0; i < located_.count; ++i)
    std::memcpy(&located_.colours[i],
                bytes + located_.points[i] * points.colour_stride,
                sizeof(located_.colours[i]));
}

void
VoxelCollector::writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums)
{
  if (is_sparse_)
    sorted_voxels_.writeVoxels(keys, sums);
  else
    blocks_.writeVoxels(keys, sums);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
