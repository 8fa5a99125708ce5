// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief How the voxels of a stream differ from one frame to the next: without those of
 * `gone` and with those of `came` the voxels of the one are those of the other.
 *
 * A voxel whose intensity or colour is another one is in both, as it was and as it is.
 * Where the two frames have the same grid and scale, the same kind of colours and the
 * same depth model, no other voxel is in both. Else `gone` has all voxels of the one
 * frame, in its own grid, and `came` all of the other.
 *
 * Both are frames as isConsistent() demands, without points, numbers of points and
 * fields.
 */
struct VoxelChanges {
  VoxelFrame gone; ///< with the intensities and colours that the voxels had
  VoxelFrame came; ///< with those that they have; its grid is that of the later frame

  /** \brief Whether no earlier frame was known, so that `came` has all voxels of the
   * later one, and `gone` none: who applies changes drops the voxels that it has. */
  bool is_from_nothing = false;

  /** \brief Whether both are of the same grid and scale, so that keys of voxels can be
   * compared. */
  bool
  areOfOneGrid() const
  {
    return gone.grid == came.grid && gone.intensity_scale == came.intensity_scale &&
           gone.colour_bits == came.colour_bits;
  }
};

/** \brief Compares two frames.
 * \param[in] before as isConsistent() demands
 * \param[in] after likewise
 * \param[out] changes its memory is reused; is_from_nothing is false
 */
PCL_EXT_CODEC_EXPORT void
findChanges(const VoxelFrame& before, const VoxelFrame& after, VoxelChanges& changes);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
