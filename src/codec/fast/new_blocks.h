// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/frame_blocks.h"
#include "codec/fast/models.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Codes the blocks that are not in the history (doc/bitstream_fast.md, "New
 * blocks"): an octree from the root to the voxels, level by level.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class NewBlocks {
public:
  /** \brief Codes a frame whose voxels in tracked blocks are coded.
   * \param[in,out] models of the octree's masks
   * \param[in,out] frame a decoder sets the new blocks
   * \return false if the bytes are invalid, or decode to more voxels than the frame
   * has; never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder, NodeModels& models, FrameBlocks& frame);

private:
  /** \brief The nodes of one level, ascending. Node 0 is none: it has no children, and
   * is the neighbour of nodes that have no other. */
  struct Level {
    std::size_t count = 0; ///< with node 0; elements from here on are unused
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> masks;                 ///< children
    std::vector<std::uint32_t> first_child;          ///< in the next level
    std::vector<std::array<std::uint32_t, 3>> lower; ///< neighbours at -x, -y and -z
    std::vector<std::uint8_t> upper; ///< 4, 2, 1 where there is one at +x, +y, +z

    void
    ensure(std::size_t size);
  };

  void
  collectMasks(const FrameBlocks& frame);

  template <class Coder>
  bool
  codeMasks(Coder& coder,
            NodeModels& models,
            const std::vector<std::uint8_t>& masks,
            bool is_root,
            std::size_t max_children);

  void
  descend();

  static std::uint32_t
  childOf(const Level& level, std::uint32_t node, unsigned int child);

  bool
  setCells(FrameBlocks& frame) const;

  Level level_;
  Level next_level_;
  std::size_t child_count_ = 0;
  std::vector<std::uint64_t> node_keys_;              // encoder only
  std::vector<std::vector<std::uint8_t>> node_masks_; // encoder only: by level
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
