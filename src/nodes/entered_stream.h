// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "nodes/merged_keys.h"
#include "nodes/summed_voxels.h"
#include "voxelizing/common_step.h"
#include "voxels/grid_fit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief Where the voxels of streams are in the merged frame, and what they add to its
 * sums. Updates with the same members can be taken away again. */
struct MergedScale {
  io::VoxelGrid grid; ///< of the merged frame
  float limit = 0.0f; ///< magnitudes of intensities above it are reduced to it
  double units = 1.0; ///< of a sum, for an intensity of 1: a power of two
};

/** \brief The voxels of a stream that are in a merged frame. For one thread at a time. */
class EnteredStream {
public:
  /** \brief Takes other voxels in place of those that are entered. To be updated
   * before the next time.
   * \param[in,out] voxels of the stream's next frame; afterwards those of an earlier one,
   * which are of no use
   */
  void
  replace(io::VoxelFrame& voxels);

  /** \brief The same without voxels. */
  void
  removeVoxels();

  const io::VoxelFrame&
  voxels() const
  {
    return voxels_;
  }

  /** \brief Whether there are other voxels since the last update. */
  bool
  isReplaced() const
  {
    return is_replaced_;
  }

  /** \brief Writes the updates for what has changed. Of a voxel that came outside of
   * the grid, but on the lattice, the result is false; the updates are not to be used
   * then. */
  bool
  writeUpdates(const MergedScale& scale);

  /** \brief Writes the updates that enter all voxels. */
  void
  writeAllUpdates(const MergedScale& scale);

  const VoxelUpdates&
  updates() const
  {
    return updates_;
  }

  /** \brief Ends the update. */
  void
  endUpdate();

  /** \brief Number of voxels that are outside of the lattice, after an update. */
  std::size_t
  outsideLattice() const
  {
    return outside_lattice_;
  }

  /** \brief Number of voxels on the lattice of an origin.
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
  countSymbols();

  void
  measureIntensities();

  void
  writeChanges(const MergedScale& scale);

  void
  skipSame(std::size_t& i, std::size_t& j) const;

  void
  writeOne(const io::VoxelFrame& voxels, bool is_added, const MergedScale& scale);

  void
  append(std::uint64_t key, const VoxelUpdate& update);

  float
  intensityOf(std::size_t symbol) const
  {
    return voxels_.hasIntensities()
               ? voxels_.intensity_scale.value(static_cast<std::uint16_t>(symbol))
               : 1.0f;
  }

  io::VoxelFrame voxels_;
  io::VoxelFrame before_; // that are in the sums, until the update
  bool is_replaced_ = false;
  MergedKeys keys_;
  VoxelUpdates updates_;
  bool has_written_all_ = false; // of all voxels
  std::size_t outside_lattice_ = 0;
  bool has_all_in_grid_ = true;
  // Of the intensities, by their symbols.
  std::vector<std::uint32_t> counts_;
  std::vector<std::uint8_t> are_there_; // 1 for those with a count
  bool are_other_symbols_ = false;      // than when the following were found
  float highest_ = 0.0f;
  io::CommonStep step_;
};

} // namespace nodes
} // namespace pcl_ext
