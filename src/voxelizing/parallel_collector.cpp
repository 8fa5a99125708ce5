// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/parallel_collector.h"

#include "platforms/run_at_once.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <iterator>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

void
add(VoxelizationStatistics& sum, const VoxelizationStatistics& part)
{
  sum.points += part.points;
  sum.points_used += part.points_used;
  sum.points_not_finite += part.points_not_finite;
  sum.points_behind_sensor += part.points_behind_sensor;
  sum.points_outside_box += part.points_outside_box;
  sum.points_outside_grid += part.points_outside_grid;
  sum.intensities_not_finite += part.intensities_not_finite;
}

/** \brief Adds the sums of voxels to those of the same voxels among more. */
void
addSums(const std::vector<std::uint64_t>& part_keys,
        const VoxelSums& part,
        const std::vector<std::uint64_t>& keys,
        VoxelSums& sums)
{
  std::size_t voxel = 0;
  for (std::size_t i = 0; i < part_keys.size(); ++i, ++voxel) {
    while (keys[voxel] != part_keys[i])
      ++voxel;
    sums.counts[voxel] += part.counts[i];
    if (!sums.intensities.empty())
      sums.intensities[voxel] += part.intensities[i];
    if (!sums.colours.empty())
      sums.colours[voxel].add(part.colours[i]);
  }
}

} // namespace

void
ParallelCollector::reset()
{
  for (Part& part : parts_)
    part.collector.reset();
}

CollectionResult
ParallelCollector::collect(PointBatches& points,
                           const VoxelLocator& locator,
                           const CollectedFields& fields,
                           bool is_sparse,
                           std::vector<std::uint64_t>& keys,
                           VoxelSums& sums)
{
  const std::vector<PointBatches*> batches = split(points);
  const std::size_t parts = std::max<std::size_t>(1, batches.size());
  const bool is_split = parts > 1;
  if (parts_.size() < parts)
    parts_.resize(parts);
  CollectedFields part_fields = fields;
  part_fields.exactness = is_split && fields.intensities;
  runAtOnce(parts, [&](std::size_t i) {
    Part& part = parts_[i];
    PointBatches& part_points = is_split ? *batches[i] : points;
    part.result = part.collector.collect(part_points, locator, part_fields, is_sparse);
    if (part.result == CollectionResult::AllPoints)
      part.collector.writeVoxels(is_split ? part.keys : keys,
                                 is_split ? part.sums : sums);
  });
  statistics_ = VoxelizationStatistics();
  step_ = CommonStep();
  for (std::size_t i = 0; i < parts; ++i) {
    if (parts_[i].result != CollectionResult::AllPoints)
      return parts_[i].result;
    add(statistics_, parts_[i].collector.statistics());
    step_.add(parts_[i].collector.step());
  }
  occupied_blocks_ = parts_.front().collector.occupiedBlocks();
  if (!is_split)
    return CollectionResult::AllPoints;
  uniteVoxels(fields, parts, keys, sums);
  if (fields.intensities && !areSumsExact(parts, sums)) {
    are_sums_rounded_ = true; // nothing is split any more
    return collect(points, locator, fields, is_sparse, keys, sums);
  }
  occupied_blocks_ = countBlocks(keys);
  return CollectionResult::AllPoints;
}

std::vector<PointBatches*>
ParallelCollector::split(PointBatches& points) const
{
  const std::size_t parts =
      std::min<std::size_t>(points.size() / least_points_per_part, threads_);
  if (are_sums_rounded_ || parts < 2)
    return {};
  return points.split(parts);
}

void
ParallelCollector::uniteVoxels(const SummedFields& fields,
                               std::size_t parts,
                               std::vector<std::uint64_t>& keys,
                               VoxelSums& sums)
{
  keys = parts_.front().keys;
  for (std::size_t i = 1; i < parts; ++i) {
    spare_keys_.clear();
    std::set_union(keys.begin(),
                   keys.end(),
                   parts_[i].keys.begin(),
                   parts_[i].keys.end(),
                   std::back_inserter(spare_keys_));
    keys.swap(spare_keys_);
  }
  sums.clear();
  sums.resize(keys.size(), fields);
  for (std::size_t i = 0; i < parts; ++i)
    addSums(parts_[i].keys, parts_[i].sums, keys, sums);
}

bool
ParallelCollector::areSumsExact(std::size_t parts, const VoxelSums& sums) const
{
  if (sums.counts.empty())
    return true;
  SumExactness exactness;
  for (std::size_t i = 0; i < parts; ++i)
    exactness.add(parts_[i].collector.exactness());
  return exactness.areExact(*std::max_element(sums.counts.begin(), sums.counts.end()));
}

} // namespace pcl_ext::PCL_EXT_ABI::io
