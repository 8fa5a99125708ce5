// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxelizing/colour_sum.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What is summed of the points of a cloud in each voxel, besides their
 * number. */
struct SummedFields {
  bool intensities = false;
  bool colours = false;
};

/** \brief Sums over the points of each voxel. */
struct VoxelSums {
  std::vector<std::uint32_t> counts; ///< number of points
  std::vector<double> intensities;   ///< empty unless summed
  std::vector<ColourSum> colours;    ///< empty unless summed

  void
  resize(std::size_t voxels, const SummedFields& fields)
  {
    counts.resize(voxels);
    intensities.resize(fields.intensities ? voxels : 0);
    colours.resize(fields.colours ? voxels : 0);
  }

  void
  clear()
  {
    resize(0, SummedFields());
  }
};

} // namespace pcl_ext::PCL_EXT_ABI::io
