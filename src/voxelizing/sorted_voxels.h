// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/located_points.h"
#include "voxelizing/voxel_sums.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Same interface as PointBlocks, for sparse clouds whose blocks of voxels would
 * be nearly empty: sorts the points by their voxels. */
class SortedVoxels {
public:
  /** \brief Begins a cloud.
   * \param[in] fields what the points have and voxels sum up; with neither, sorting
   * takes half the memory
   * \param[in] expected number of points to come, at most
   */
  void
  begin(const SummedFields& fields, std::size_t expected);

  void
  add(const LocatedPoints& located);

  void
  writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums);

  std::size_t
  occupiedBlocks() const
  {
    return occupied_blocks_;
  }

private:
  struct Point {
    std::uint64_t key;
    float intensity;
    std::uint32_t colour;
  };

  bool
  keepsPoints() const
  {
    return fields_.intensities || fields_.colours;
  }

  template <typename EntryT>
  void
  writeSorted(const std::vector<EntryT>& sorted,
              std::vector<std::uint64_t>& keys,
              VoxelSums& sums);

  SummedFields fields_;
  // One of the two pairs is used.
  std::vector<Point> points_;
  std::vector<Point> spare_points_;
  std::vector<std::uint64_t> point_keys_;
  std::vector<std::uint64_t> spare_keys_;
  std::size_t occupied_blocks_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
