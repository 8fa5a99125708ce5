// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>

#include "voxels/frame_parts.h"

#include <array>
#include <cstddef>
#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Which frames are merged: the latest one of a stream, if it was decoded between
 * two times or has one of some stamps. */
struct FrameSelection {
  Time oldest = Time::min();
  Time newest = Time::max();
  std::optional<StampRange> stamps = std::nullopt;
};

/** \brief What is taken of a stream: how its voxels have changed since the last time, in
 * steps that follow each other. */
class TakenChanges {
public:
  /** \brief False if it is not known what has changed: what was taken before is to be
   * dropped. */
  bool are_known = true;

  void
  clear()
  {
    are_known = true;
    size_ = 0;
  }

  /** \brief Releases the memory. */
  void
  release() noexcept
  {
    *this = TakenChanges();
  }

  /** \brief Adds a step, which is to be set. */
  io::VoxelChanges&
  add()
  {
    return steps_[size_++];
  }

  /** \brief Adds a step after which there are no voxels. */
  void
  addGone(io::VoxelFrame& all)
  {
    io::VoxelChanges& step = add();
    std::swap(step.gone, all);
    io::beginLike(step.gone, step.came);
  }

  /** \brief Adds a step before which there are no voxels. */
  void
  addCame(io::VoxelFrame& all)
  {
    io::VoxelChanges& step = add();
    std::swap(step.came, all);
    io::beginLike(step.came, step.gone);
  }

  const io::VoxelChanges*
  begin() const
  {
    return steps_.data();
  }

  const io::VoxelChanges*
  end() const
  {
    return steps_.data() + size_;
  }

private:
  std::array<io::VoxelChanges, 2> steps_; // keep their memory
  std::size_t size_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
