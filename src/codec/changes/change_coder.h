// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/changes/last_frame.h"
#include "codec/changes/models.h"
#include "codec/fast/frame_blocks.h"
#include "codec/payload_coder.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief Codes frames of changes, of any effort: what differs from the last frame
 * (doc/bitstream_changes.md). An instance is for one stream and one direction. After an
 * exception it may only be destroyed. */
class ChangeCoder {
public:
  /** \brief Copies another frame than one of changes, which learnWhole() has to
   * follow, or nothing if the frame is invalid. */
  void
  prepare(const VoxelFrame& frame);

  /** \brief Learns the frame that was copied last.
   * \param[in] is_i_frame the models start again
   */
  void
  learnWhole(bool is_i_frame) noexcept;

  /** \brief Whether the next frame may be one of changes. */
  bool
  hasLastFrame() const
  {
    return has_last_frame_;
  }

  /** \brief Drops the last frame, so that the next one cannot be one of changes. */
  void
  dropLastFrame() noexcept
  {
    has_last_frame_ = false;
  }

  /** \brief For an encoder: whether most of a sample of a frame's voxels are not in the
   * last one, if no frame of changes refers to that yet. Then comparing all is of no use:
   * those of a moving sensor cost hardly any time.
   * \param[in] frame with 1 voxel or more, of the grid and scale of the last one
   */
  bool
  hasOtherVoxels(const VoxelFrame& frame) const;

  /** \brief For an encoder: compares a frame with the last one.
   * \param[in,out] memory for the frame
   * \return number of cells that change; encode() may follow, with the same memory
   */
  std::size_t
  countChanges(CodingWorkspace& memory, const VoxelFrame& frame);

  /** \brief What is known of a frame by its changes. */
  struct ChangedFrame {
    std::size_t changes = 0; ///< cells
    std::size_t voxels = 0;
    std::size_t blocks = 0; ///< with voxels
  };

  /** \brief The same for a frame that is known by how it differs from the last one.
   * \param[in] changes of one grid, and of the intensities of the last frame
   * \return nothing if the last frame does not have what went, or has what came, or if a
   * voxel without an intensity is in both. Intensities of what went are not compared
   */
  std::optional<ChangedFrame>
  takeChanges(CodingWorkspace& memory, const VoxelChanges& changes);

  /** \brief Appends the payload of the frame that was compared or taken, and learns it.
   * \param[in] frame that was compared, or the voxels that came
   * \return false if symbols that came are those of the last frame, which changes nothing
   */
  bool
  encode(CodingWorkspace& memory,
         const VoxelFrame& frame,
         std::vector<std::uint8_t>& payload);

  /** \brief Inverse of encode(). listVoxels() or listChanges() may follow, with the same
   * memory; then either learn(), or the frame is taken as failed, which changes nothing.
   * \param[in,out] memory for the frame, not to be used for others before learn()
   * \param[in] payload 1 voxel or more
   * \param[in] frame its grid and scale are those of the frame
   * \return false if the bytes are not exactly one payload of that many voxels
   */
  bool
  decode(CodingWorkspace& memory, const CodedPayload& payload, const VoxelFrame& frame);

  /** \brief Sets the voxels of a frame to those of the frame that was decoded. */
  void
  listVoxels(CodingWorkspace& memory, VoxelFrame& frame) const;

  /** \brief Lists how the frame that was decoded differs from the last one.
   * \param[out] gone voxels of the last frame
   * \param[out] came voxels of the frame that was decoded
   */
  void
  listChanges(VoxelFrame& gone, VoxelFrame& came) const;

  /** \brief Sets the voxels of a frame to those of the last one, which there has to
   * be. */
  void
  listLastVoxels(VoxelFrame& frame) const;

  /** \brief Learns the frame that was decoded last. */
  void
  learn() noexcept;

  /** \brief The most blocks of the last frame, and of those that vanished lately. */
  std::size_t
  blockCount() const
  {
    return std::max(last_.blocks.size(), last_keys_.size());
  }

  /** \brief Releases memory that the last frame does not need. */
  void
  releaseMemory();

private:
  template <class Coder>
  bool
  code(Coder& coder, fast::Workspace& work, const std::uint16_t* targets);

  template <class Coder>
  bool
  codeOctants(Coder& coder);

  template <class Coder>
  bool
  codeCells(Coder& coder, std::uint64_t cells_in_grid);

  bool
  insertNewBlocks(const fast::FrameBlocks& blocks);

  std::size_t
  findFirstVoxels();

  template <class Coder>
  bool
  codeSymbols(Coder& coder, std::size_t voxel_count, const std::uint16_t* targets);

  void
  collectBlocks();

  bool has_last_frame_ = false;
  /** \brief The last frame if it was copied and no frame referred to it, else empty;
   * most streams need no more. */
  std::vector<std::uint64_t> last_keys_;
  LastFrame last_;
  std::unique_ptr<Models> models_ = std::make_unique<Models>();
  // A frame that was copied, until learnWhole().
  std::vector<std::uint64_t> next_keys_;
  std::vector<std::uint16_t> next_symbols_;

  // Of the current frame.
  FrameChanges* changes_ = nullptr; ///< memory for it
  std::int32_t highest_symbol_ = 0; ///< 0: no intensities
  std::size_t voxel_count_ = 0;     ///< encoder only
  bool is_taken_ = false;           ///< by takeChanges()
  BlockList now_; ///< the frame's, encoder only; or those of a frame that was copied
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io
