// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/pending_changes.h"

#include "voxels/frame_parts.h"

#include <cstdint>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Sets a frame to the voxels of `above`, and to those of `below` of which
 * neither `above` nor `hidden` has the key. All are of one grid and scale. */
void
overlay(const io::VoxelFrame& above,
        const io::VoxelFrame& hidden,
        const io::VoxelFrame& below,
        io::VoxelFrame& frame)
{
  io::beginLike(above, frame);
  std::size_t i = 0;
  std::size_t j = 0;
  for (std::size_t voxel = 0; voxel < below.size(); ++voxel) {
    const std::uint64_t key = below.keys[voxel];
    while (i < above.size() && above.keys[i] < key)
      io::appendVoxel(above, i++, frame);
    while (j < hidden.size() && hidden.keys[j] < key)
      ++j;
    const bool is_above = i < above.size() && above.keys[i] == key;
    const bool is_hidden = j < hidden.size() && hidden.keys[j] == key;
    if (!is_above && !is_hidden)
      io::appendVoxel(below, voxel, frame);
  }
  while (i < above.size())
    io::appendVoxel(above, i++, frame);
}

std::size_t
capacityBytes(const io::VoxelFrame& frame)
{
  return frame.keys.capacity() * sizeof(frame.keys[0]) +
         frame.intensities.capacity() * sizeof(frame.intensities[0]) +
         frame.colours.capacity() * sizeof(frame.colours[0]);
}

} // namespace

void
PendingChanges::begin(std::size_t frame) noexcept
{
  begin_ = frame;
  frames_ = 0;
}

void
PendingChanges::add(io::VoxelChanges& changes)
{
  if (changes.is_from_nothing)
    end();
  if (!countFrame())
    return;
  if (frames_ == 1)
    std::swap(changes_, changes);
  else
    join(changes);
  are_whole_ = false;
}

void
PendingChanges::add(const io::VoxelFrame& before, const io::VoxelFrame& after)
{
  if (!countFrame())
    return;
  if (frames_ == 1 || are_whole_) {
    if (frames_ == 1)
      io::copyVoxels(before, changes_.gone);
    io::copyVoxels(after, changes_.came);
    are_whole_ = true;
    return;
  }
  io::VoxelChanges changes;
  io::copyVoxels(before, changes.gone);
  io::copyVoxels(after, changes.came);
  join(changes);
}

/** \brief Counts a frame that is added. \return false if no changes are kept */
bool
PendingChanges::countFrame()
{
  if (areKept() && ++frames_ > most_frames)
    end();
  return areKept();
}

/** \brief Sets the changes to the difference between the frame before them and that after
 * the next ones. */
void
PendingChanges::join(const io::VoxelChanges& next)
{
  // What was before both, and is after both, of the voxels that either has.
  const bool is_one_grid_first = changes_.areOfOneGrid();
  if (is_one_grid_first)
    overlay(changes_.gone, changes_.came, next.gone, before_);
  const bool is_one_grid_next = next.areOfOneGrid();
  if (is_one_grid_next)
    overlay(next.came, next.gone, changes_.came, after_);
  io::findChanges(is_one_grid_first ? before_ : changes_.gone,
                  is_one_grid_next ? after_ : next.came,
                  joined_);
  std::swap(changes_, joined_);
}

void
PendingChanges::take(std::size_t frame, io::VoxelChanges& changes)
{
  std::swap(changes_, changes);
  begin(frame);
}

std::size_t
PendingChanges::bytes() const
{
  return capacityBytes(changes_.gone) + capacityBytes(changes_.came) +
         capacityBytes(joined_.gone) + capacityBytes(joined_.came) +
         capacityBytes(before_) + capacityBytes(after_);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
