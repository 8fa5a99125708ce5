// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <cstddef>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief How the voxels of a stream have changed since somebody took them. Of several
 * frames it has the difference between the first and the last one, or both of them, so
 * that its memory is bounded by the voxels of two frames. */
class PendingChanges {
public:
  /** \brief After as many frames that nobody took, changes are not kept any more. */
  static constexpr std::size_t most_frames = 64;

  /** \brief Begins anew without changes.
   * \param[in] frame number of the frame whose voxels were taken
   */
  void
  begin(std::size_t frame) noexcept;

  /** \brief Keeps no changes until begin(), and no memory. */
  void
  end() noexcept
  {
    *this = PendingChanges();
  }

  /** \brief Whether changes are kept. */
  bool
  areKept() const
  {
    return begin_.has_value();
  }

  /** \brief Whether there are changes since a frame. */
  bool
  areSince(std::size_t frame) const
  {
    return begin_ == frame;
  }

  /** \brief Whether no frame was added since begin(). */
  bool
  areEmpty() const
  {
    return frames_ == 0;
  }

  /** \brief Adds those of the next frame.
   * \param[in,out] changes unspecified afterwards
   */
  void
  add(io::VoxelChanges& changes);

  /** \brief Adds those of a frame whose voxels are all known, which is not compared: what
   * is taken may have voxels that did not change, as gone and as come.
   * \param[in] before the voxels of the frame before
   * \param[in] after those of the frame
   */
  void
  add(const io::VoxelFrame& before, const io::VoxelFrame& after);

  /** \brief Takes the changes, of which there have to be some, and begins anew.
   * \param[in] frame number of the frame that they lead to
   * \param[out] changes its memory is reused
   */
  void
  take(std::size_t frame, io::VoxelChanges& changes);

  /** \brief Bytes of the voxels. */
  std::size_t
  bytes() const;

private:
  bool
  countFrame();

  void
  join(const io::VoxelChanges& next);

  std::optional<std::size_t> begin_;
  std::size_t frames_ = 0; // since begin_
  io::VoxelChanges changes_;
  bool are_whole_ = false; // changes_ has all voxels of the first and of the last frame
  // For join(), so that their memory is reused.
  io::VoxelChanges joined_;
  io::VoxelFrame before_;
  io::VoxelFrame after_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
