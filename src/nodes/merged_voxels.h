// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>

#include "nodes/entered_stream.h"
#include "nodes/merged_writer.h"
#include "nodes/received_stream.h"
#include "nodes/summed_voxels.h"
#include "voxelizing/common_step.h"
#include "voxels/memory_rule.h"

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Merges the voxels of streams on a common grid, see CentralNode::merge.
 *
 * What streams have in common is kept from one merged frame to the next: sums of
 * integers, to which voxels that came are added and from which those that went are
 * taken away. All is entered anew only where the common grid, its origin or the limit of
 * intensities changes. For one thread at a time.
 */
class MergedVoxels {
public:
  using Origin = std::array<double, 3>;
  using Streams = std::map<std::string, std::shared_ptr<ReceivedStream>>;

  /** \param[in] resolution voxel edge of the common grid, metres
   * \param[in] origin of the common grid, metres; none: chosen from the voxels
   * \param[in] threads that enter streams, 1 or more; the result does not depend on it
   */
  MergedVoxels(double resolution,
               const std::optional<Origin>& origin,
               unsigned int threads);

  /** \brief Merges streams. Tells them how many of their voxels are outside the common
   * grid, and how many intensities were reduced.
   * \return what of each stream is merged */
  std::vector<MergedStream>
  merge(const Streams& streams, const FrameSelection& selection);

  /** \brief Lists how the merged voxels differ from those merged before.
   * \return false if that is not known of all */
  bool
  listChanges(io::VoxelChanges& changes);

  void
  write(io::VoxelFrame& merged);

  /** \brief Drops all memory. To be called when merge() threw, which may have entered a
   * part of the voxels. */
  void
  releaseMemory() noexcept;

private:
  /** \brief A stream of which voxels are, or were, merged. */
  struct Entry {
    std::shared_ptr<ReceivedStream> source; ///< null: it is removed
    std::weak_ptr<ReceivedStream> stream;   ///< whose voxels are entered
    std::optional<LatestFrame> frame;       ///< that its voxels are from
    bool has_any_time = false;              ///< is merged whenever its frame is from
    EnteredStream voxels;
  };

  void
  setEntries(const Streams& streams, const FrameSelection& selection);

  bool
  follow(const FrameSelection& selection);

  static bool
  followStream(const FrameSelection& selection, Entry& entry);

  template <typename WorkT>
  void
  forEachEntry(const WorkT& work);

  void
  updateSums(const FrameSelection& selection);

  bool
  updateChanged();

  bool
  areUpdatesFew() const;

  bool
  writeUpdates();

  void
  addUpdates(bool lists_changes);

  void
  enterAll(const FrameSelection& selection);

  std::size_t
  measureAll(const Origin& origin, std::optional<io::LatticeRange>& range) const;

  std::size_t
  outsideLattice() const;

  void
  endUpdate();

  bool
  moveOrigin(std::size_t on_lattice);

  std::optional<io::LatticeRange>
  rangeOfSums() const;

  bool
  isGridFarTooLarge() const;

  std::size_t
  voxelCount() const;

  double
  typicalIntensity() const;

  float
  intensityLimit() const;

  bool
  setScale();

  io::CommonStep
  commonStep() const;

  const bool has_fixed_origin_;
  const std::size_t threads_;
  std::map<std::string, Entry> entries_;
  std::vector<Entry*> all_; // the same, to be shared among threads
  MergedScale scale_;
  bool has_grid_ = false;               // whether it is that of voxels
  std::optional<int> highest_exponent_; // magnitudes are below 2 to this power
  SummedVoxels sums_;
  bool are_changes_listed_ = false; // sums_ has those of the last update
  MergedWriter writer_;
  io::MemoryRule memory_rule_;
  bool is_release_due_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
