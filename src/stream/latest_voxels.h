// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "voxels/frame_parts.h"
#include "voxels/memory_rule.h"
#include "voxels/point_voxels.h"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Releases memory that the voxels and fields of a frame do not need. */
inline void
releaseExcess(VoxelFrame& frame)
{
  frame.keys.shrink_to_fit();
  frame.intensities.shrink_to_fit();
  frame.colours.shrink_to_fit();
  frame.point_counts.shrink_to_fit();
  for (FrameField& field : frame.fields)
    field.numbers.shrink_to_fit();
}

/** \brief The voxels of the last frame of a stream whose changes are asked for, if the
 * coder of frames of changes does not keep them. Empty and without memory until then. */
class LatestVoxels {
public:
  /** \brief Whether the last frame is kept. */
  bool
  areKept() const
  {
    return are_kept_;
  }

  const VoxelFrame&
  kept() const
  {
    return kept_;
  }

  /** \brief Where to decode the next frame, for keepDecoded(). */
  VoxelFrame&
  decoded()
  {
    return decoded_;
  }

  /** \brief Keeps the voxels that a function sets. */
  template <class ListVoxels>
  void
  keep(const ListVoxels& list_voxels)
  {
    are_kept_ = false;
    list_voxels(kept_);
    are_kept_ = true;
    frames_in_coder_ = 0;
  }

  /** \brief Keeps the voxels of a frame that a caller has. */
  void
  keepCopy(const VoxelFrame& frame)
  {
    keep([&frame](VoxelFrame& kept) {
      kept = frame;
      setVoxels(kept);
      removePoints(kept);
    });
  }

  /** \brief Compares the decoded frame, which has voxels, with the kept one, and keeps
   * it in its place. */
  void
  keepDecoded(VoxelChanges& changes)
  {
    const bool is_from_nothing = !are_kept_;
    removePoints(decoded_);
    if (is_from_nothing)
      beginLike(decoded_, kept_);
    findChanges(kept_, decoded_, changes);
    changes.is_from_nothing = is_from_nothing;
    std::swap(kept_, decoded_);
    are_kept_ = true;
    frames_in_coder_ = 0;
  }

  /** \brief Tells that the coder has the last frame. Releases the memory after several
   * such frames in a row, as the next ones are likely to be the same. */
  void
  leaveToCoder() noexcept
  {
    are_kept_ = false;
    if (++frames_in_coder_ == MemoryRule::frames)
      drop();
  }

  /** \brief Forgets the voxels and releases the memory. */
  void
  drop() noexcept
  {
    are_kept_ = false;
    kept_ = VoxelFrame();
    decoded_ = VoxelFrame();
  }

  /** \brief Releases memory that the kept frame does not need. */
  void
  releaseMemory()
  {
    releaseExcess(kept_);
    decoded_ = VoxelFrame();
  }

  /** \brief Bytes that are allocated. */
  std::size_t
  memoryBytes() const
  {
    return bytesOf(kept_) + bytesOf(decoded_);
  }

private:
  /** \brief Removes all but the voxels, their intensities and colours. */
  static void
  removePoints(VoxelFrame& frame)
  {
    frame.has_point_counts = false;
    frame.point_counts.clear();
    frame.fields.clear();
    frame.viewpoint = {};
    frame.points = FramePoints();
  }

  static std::size_t
  bytesOf(const VoxelFrame& frame)
  {
    // Values of fields stay after a frame that failed.
    std::size_t of_fields = 0;
    for (const FrameField& field : frame.fields)
      of_fields += field.numbers.capacity() * sizeof(field.numbers[0]);
    return of_fields + frame.keys.capacity() * sizeof(std::uint64_t) +
           frame.intensities.capacity() * sizeof(std::uint16_t) +
           frame.colours.capacity() * sizeof(VoxelColour) +
           frame.point_counts.capacity() * sizeof(std::uint32_t);
  }

  bool are_kept_ = false;
  std::size_t frames_in_coder_ = 0; // in a row
  VoxelFrame kept_;
  VoxelFrame decoded_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
