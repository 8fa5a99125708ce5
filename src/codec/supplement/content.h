// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief What frames have besides voxels and intensities. */
struct Content {
  unsigned int refinement_levels =
      0;                        ///< of the octree within a coarse voxel, 0..20; 0: none
  unsigned int colour_bits = 0; ///< of a channel, 1..8; 0: no colours
  bool has_point_counts = false;
  bool has_fields = false;
  bool has_scan = false; ///< points in the order of a sensor, in place of all others

  /** \brief Whether the voxels are in the supplement, with all that they have. */
  bool
  hasVoxels() const
  {
    return refinement_levels > 0;
  }

  /** \brief Whether there is a supplement. */
  bool
  hasSupplement() const
  {
    return !has_scan && (hasVoxels() || colour_bits > 0 || has_fields);
  }

  /** \brief Whether frames have voxels and their intensities, and nothing else. */
  bool
  hasVoxelsAlone() const
  {
    return colour_bits == 0 && !has_point_counts && !has_fields && !has_scan;
  }

  bool
  operator!=(const Content& other) const
  {
    return refinement_levels != other.refinement_levels ||
           colour_bits != other.colour_bits ||
           has_point_counts != other.has_point_counts ||
           has_fields != other.has_fields || has_scan != other.has_scan;
  }
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
