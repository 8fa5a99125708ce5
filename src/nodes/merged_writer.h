// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "nodes/entered_stream.h"
#include "nodes/summed_voxels.h"
#include "voxelizing/common_step.h"
#include "voxelizing/intensity_quantiser.h"

#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Sums of the voxels of streams, and how they lie in the merged frame. */
struct MergedSums {
  const SummedVoxels& voxels;
  const MergedScale& scale;
  io::CommonStep step; ///< of the intensities of the streams
};

/** \brief Writes sums as merged frames, see CentralNode::merge. */
class MergedWriter {
public:
  MergedWriter();

  /** \brief Writes all voxels. */
  void
  write(const MergedSums& sums, io::VoxelFrame& merged);

  /** \brief Lists the changed sums as how their frame differs from the one before, which
   * was written or listed last.
   * \return false if the two have no scale in common, or colours; then all is to be
   * written
   */
  bool
  listChanges(const MergedSums& sums, io::VoxelChanges& changes);

  void
  releaseMemory() noexcept;

private:
  void
  writeScaled(const MergedSums& sums, io::VoxelFrame& merged);

  // Of voxels whose intensities are whole numbers of 0 to 65535, when they were written or
  // listed last; else nothing.
  std::optional<io::IntensityScale> whole_scale_;
  io::IntensityQuantiser quantiser_;
  std::vector<double> intensities_; // a member so that its memory is reused
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
