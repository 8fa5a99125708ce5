// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "nodes/merged_keys.h"
#include "nodes/summed_voxels.h"
#include "nodes/taken_changes.h"
#include "voxelizing/common_step.h"
#include "voxels/grid_fit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Where the voxels of streams are in the merged frame, and what they add to its
 * sums. Updates with the same members can be taken away again. */
struct MergedScale {
  io::VoxelGrid grid; ///< of the merged frame
  float limit = 0.0f; ///< magnitudes of intensities above it are reduced to it
  double units = 1.0; ///< of a sum, for an intensity of 1: a power of two
};

/** \brief What of a stream is in a merged frame: how many voxels of which intensities. The
 * voxels themselves are the stream's, and their sums those of the merged frame. For one
 * thread at a time. */
class EnteredStream {
public:
  /** \brief Where to take the stream's changes, before follow(). */
  TakenChanges&
  taken()
  {
    return taken_;
  }

  /** \brief Follows the changes that were taken. To be updated before the next time. */
  void
  follow();

  /** \brief Forgets what is entered, as all will be entered anew. */
  void
  forget();

  /** \brief Number of voxels. */
  std::size_t
  size() const
  {
    return size_;
  }

  const io::VoxelGrid&
  grid() const
  {
    return grid_;
  }

  /** \brief Whether there are changes since the last update. */
  bool
  isChanged() const
  {
    return taken_.begin() != taken_.end();
  }

  /** \brief Writes the updates for what has changed. Of a voxel that came outside of
   * the grid, but on the lattice, the result is false; the updates are not to be used
   * then. */
  bool
  writeUpdates(const MergedScale& scale);

  const VoxelUpdates&
  updates() const
  {
    return updates_;
  }

  void
  endUpdate();

  /** \brief Number of voxels that are outside of the lattice, after an update. */
  std::size_t
  outsideLattice() const
  {
    return outside_lattice_;
  }

  /** \brief Number of voxels that came, which have to be all, on the lattice of an
   * origin.
   * \param[in,out] range is extended to contain them; nothing: there is none so far
   */
  std::size_t
  measure(double resolution,
          const std::array<double, 3>& origin,
          std::optional<io::LatticeRange>& range) const;

  /** \brief The largest magnitude of an intensity. */
  float
  highest() const
  {
    return highest_;
  }

  /** \brief Adds the intensities to those that have a common step.
   * \param[in] limit of their magnitude
   */
  void
  addTo(io::CommonStep& step, float limit) const;

  /** \brief The same without a limit. */
  void
  addTo(io::CommonStep& step) const
  {
    step.add(step_);
  }

  /** \brief Number of intensities of a larger magnitude. */
  std::size_t
  countAbove(float limit) const;

  /** \brief The median of the magnitudes of intensities that are not 0, of two the lower
   * one; nothing if all are. */
  std::optional<float>
  medianMagnitude() const;

private:
  void
  countSymbols(const io::VoxelChanges& changes);

  void
  measureIntensities();

  void
  writeOne(const io::VoxelFrame& voxels, bool is_added, const MergedScale& scale);

  void
  writeDifferences(const io::VoxelChanges& changes, const MergedScale& scale);

  void
  append(std::uint64_t key, const VoxelUpdate& update);

  float
  intensityOf(std::size_t symbol) const
  {
    return scale_.bits > 0 ? scale_.value(static_cast<std::uint16_t>(symbol)) : 1.0f;
  }

  TakenChanges taken_;
  std::size_t size_ = 0;
  io::VoxelGrid grid_;
  io::IntensityScale scale_;
  MergedKeys keys_;
  VoxelUpdates updates_;
  std::size_t outside_lattice_ = 0;
  bool has_all_in_grid_ = true;
  bool is_entered_anew_ = false;
  // Of the intensities, by their symbols.
  std::vector<std::uint32_t> counts_;
  bool are_other_symbols_ = false; // than when the following were found
  float highest_ = 0.0f;
  io::CommonStep step_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
