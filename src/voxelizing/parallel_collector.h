// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>

#include "voxelizing/common_step.h"
#include "voxelizing/voxel_collector.h"
#include "voxelizing/voxel_locator.h"
#include "voxelizing/voxel_sums.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Collects the points of a cloud into voxels, in several threads if the cloud
 * is large enough and can be split: each thread collects consecutive points, and the
 * voxels of all are united.
 *
 * The result does not depend on the number of threads: sums of intensities that would,
 * as they are rounded, are computed by one thread.
 */
class ParallelCollector {
public:
  /** \param[in] threads most of them, at least 1 */
  explicit ParallelCollector(unsigned int threads) : threads_(threads), parts_(1) {}

  /** \brief As VoxelCollector::collect() and, with AllPoints, writeVoxels(). What
   * follows is valid then. */
  CollectionResult
  collect(PointBatches& points,
          const VoxelLocator& locator,
          const CollectedFields& fields,
          bool is_sparse,
          std::vector<std::uint64_t>& keys,
          VoxelSums& sums);

  /** \brief Sums that one thread had to compute are tried with all of them again. */
  void
  forgetRounding()
  {
    are_sums_rounded_ = false;
  }

  /** \brief For another grid, or after a cloud that was not collected. */
  void
  reset();

  /** \brief Releases memory of earlier clouds. */
  void
  releaseMemory()
  {
    parts_ = std::vector<Part>(1);
  }

  /** \brief Counts of the points. */
  const VoxelizationStatistics&
  statistics() const
  {
    return statistics_;
  }

  /** \brief Common step of the intensities, if it was collected. */
  const CommonStep&
  step() const
  {
    return step_;
  }

  /** \brief Number of occupied blocks of 4 x 4 x 4 voxels. */
  std::size_t
  occupiedBlocks() const
  {
    return occupied_blocks_;
  }

private:
  /** \brief Consecutive points and their voxels. */
  struct Part {
    VoxelCollector collector;
    CollectionResult result = CollectionResult::AllPoints;
    std::vector<std::uint64_t> keys;
    VoxelSums sums;
  };

  std::vector<PointBatches*>
  split(PointBatches& points) const;

  void
  uniteVoxels(const SummedFields& fields,
              std::size_t parts,
              std::vector<std::uint64_t>& keys,
              VoxelSums& sums);

  bool
  areSumsExact(std::size_t parts, const VoxelSums& sums) const;

  unsigned int threads_;
  std::vector<Part> parts_; // the first one is also that of a single thread
  std::vector<std::uint64_t> spare_keys_;
  bool are_sums_rounded_ = false;
  VoxelizationStatistics statistics_;
  CommonStep step_;
  std::size_t occupied_blocks_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
