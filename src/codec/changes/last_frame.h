// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/changes/models.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief A block of the last frame, or one whose voxels vanished lately. */
struct Block {
  std::uint64_t key;              ///< Morton key of the block
  std::uint64_t cells;            ///< occupied
  std::uint64_t recently_changed; ///< cells; not valid without a change history
};

/** \brief A block that a frame changes, or a new one. */
struct ChangedBlock {
  std::uint64_t key;
  std::uint64_t cells_before;
  std::uint64_t recently_changed; ///< before
  std::uint64_t changed;          ///< cells
  std::uint64_t cells;            ///< in the frame
  std::uint32_t index;      ///< in the last frame; of a new one: of the block behind it
  std::uint32_t next_index; ///< in the frame
  std::uint32_t first_before; ///< its first voxel in the last frame
  std::uint8_t octant_symbol;
  std::uint8_t change_history; ///< after the frame
  bool is_new;
};

/** \brief Elements of the last frame that stay together in the next one. */
struct Run {
  std::uint32_t begin; ///< in the last frame
  std::uint32_t end;
  std::uint32_t next_begin; ///< in the frame
};

/** \brief The symbol of a voxel that appeared, or whose symbol has changed. */
struct NewSymbol {
  std::uint32_t voxel; ///< in the frame
  std::uint16_t symbol;
};

/** \brief How a frame differs from the last one, and memory for that; may be used by
 * several streams in turn. */
struct FrameChanges {
  std::vector<ChangedBlock> blocks; ///< ascending
  std::vector<Run> block_runs;      ///< all blocks that are not new and not removed
  std::size_t block_count = 0;      ///< of the frame
  std::size_t occupied_blocks = 0;
  std::vector<NewSymbol> symbols;    ///< ascending; none without intensities
  std::vector<Run> symbol_runs;      ///< all voxels that do not vanish, likewise
  std::size_t voxel_count = 0;       ///< of the frame
  std::size_t symbol_count = 0;      ///< as many, or 0
  std::vector<Block> all_blocks;     ///< of the frame, where all voxels are listed
  std::vector<std::uint8_t> is_kept; ///< by block of the last frame: 0 if it is removed
  std::unique_ptr<Models> models = std::make_unique<Models>(); ///< after the frame
};

/** \brief What a frame of changes refers to (doc/bitstream_changes.md, "Last frame"). Of
 * blocks that a frame does not change only what is a byte is read. */
struct LastFrame {
  std::vector<Block> blocks; ///< ascending
  // By block.
  /** \brief A bit for each of the last frames, the last one lowest: 1 if it changed. */
  std::vector<std::uint8_t> change_histories;
  std::vector<std::uint8_t> voxels; ///< number of occupied cells

  std::vector<std::uint16_t> symbols; ///< of the voxels; empty without intensities
  std::size_t voxel_count = 0;
  std::size_t occupied_blocks = 0;

  /** \brief Sets the number of blocks. Those that are added have no voxels. */
  void
  resizeBlocks(std::size_t count);

  /** \brief Sets what is known of a change of a block.
   * \param[out] change with zeros
   */
  void
  beginChange(std::size_t index, ChangedBlock& change) const
  {
    const std::uint8_t history = change_histories[index];
    const Block& block = blocks[index];
    change.key = block.key;
    change.cells_before = block.cells;
    change.recently_changed = history != 0 ? block.recently_changed : 0;
    change.index = static_cast<std::uint32_t>(index);
    change.change_history = static_cast<std::uint8_t>(history << 1 | 1);
  }

  /** \brief Finds out where the blocks of the frame and its symbols will be, and makes
   * room for them. Blocks without voxels that no frame has changed lately are removed.
   * \param[in,out] changes its blocks and symbols are given
   */
  void
  prepare(FrameChanges& changes);

  /** \brief Makes this the frame that was prepared. */
  void
  apply(const FrameChanges& changes) noexcept;
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io
