// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>

#include "voxelizing/common_step.h"
#include "voxelizing/located_points.h"
#include "voxelizing/point_blocks.h"
#include "voxelizing/sorted_voxels.h"
#include "voxelizing/sum_exactness.h"
#include "voxelizing/voxel_locator.h"
#include "voxelizing/voxel_sums.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What is collected of the points of a cloud. */
struct CollectedFields : SummedFields {
  bool step = false;      ///< the common step of the intensities
  bool exactness = false; ///< whether sums of the intensities may be rounded
};

enum class CollectionResult { AllPoints, TooSparse, PointOutsideGrid };

/** \brief Collects the points of a cloud, or of a part of one, into voxels; in one
 * thread. */
class VoxelCollector {
public:
  /** \brief Collects the usable points.
   * \param[in] points the cloud
   * \param[in] locator computes their voxels
   * \param[in] fields what is collected besides the number of points
   * \param[in] is_sparse the cloud is known to have few points per block of voxels
   * \return TooSparse: to be called again with is_sparse; PointOutsideGrid: a usable
   * point is outside the locator's grid. In both cases reset() is required first.
   */
  CollectionResult
  collect(PointBatches& points,
          const VoxelLocator& locator,
          const CollectedFields& fields,
          bool is_sparse);

  /** \brief Writes the voxels, and removes the points.
   * \param[out] keys Morton keys of the voxels, strictly ascending
   * \param[out] sums of the points in each voxel
   */
  void
  writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums);

  /** \brief For another grid, or after points that were not written. */
  void
  reset()
  {
    blocks_.reset();
  }

  /** \brief Counts of the points. */
  const VoxelizationStatistics&
  statistics() const
  {
    return statistics_;
  }

  const CommonStep&
  step() const
  {
    return step_;
  }

  const SumExactness&
  exactness() const
  {
    return exactness_;
  }

  /** \brief Number of occupied blocks of 4 x 4 x 4 voxels, after writeVoxels(). */
  std::size_t
  occupiedBlocks() const
  {
    return is_sparse_ ? sorted_voxels_.occupiedBlocks() : blocks_.occupiedBlocks();
  }

private:
  CollectionResult
  collectBatch(const PointView& points, const VoxelLocator& locator);

  void
  readIntensities(const PointView& points);

  void
  readColours(const PointView& points);

  PointBlocks blocks_;
  SortedVoxels sorted_voxels_;
  bool is_sparse_ = false;
  CollectedFields fields_;
  VoxelizationStatistics statistics_;
  CommonStep step_; // of the intensities
  SumExactness exactness_;
  LocatedPoints located_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
