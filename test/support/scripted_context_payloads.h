// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Writes payloads of the effort balanced with the encoder's own passes and,
 * where an encoder would not, decision by decision (doc/bitstream_context.md).
 */
#pragma once

#include "codec/context/entropy_coder.h"
#include "codec/context/frame_blocks.h"
#include "codec/context/intensities.h"
#include "codec/context/models.h"
#include "codec/context/new_blocks.h"
#include "codec/context/new_voxels.h"
#include "codec/context/tracked_voxels.h"
#include "codec/payload_coder.h"
#include "support/voxel_frames.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

using namespace context;

struct ContextState {
  TrackedVoxelModels tracked_voxels{false};
  NewVoxelModels new_voxels{false};
  ChildModels children{false};
  IntensityContexts intensity{false};
  History history;
  bool is_i_frame = true; // the next frame
};

class ContextScript {
public:
  using Coding = DecisionCoding<BinaryRangeEncoder, false>;
  using Decision = DecisionModel<1>;

  /** \param[in] before what was learnt of the frames before
   * \param[in] like grid, scale and depth model of the frame
   */
  ContextScript(const ContextState& before, const VoxelFrame& like)
  : state(before)
  , parameters_{state.history,
                like.grid.depth,
                like.intensity_scale.bits,
                like.depth_model ? &*like.depth_model : nullptr}
  {
    if (state.is_i_frame)
      state.history.clear(like.intensity_scale.bits);
    else
      coding.codeBypass(true); // the history is used
  }

  ContextScript(const ContextScript&) = delete;
  ContextScript&
  operator=(const ContextScript&) = delete;

  /** \brief Which voxels there are.
   * \return false where an encoder can go no further
   */
  bool
  occupancy(const BlockList& blocks)
  {
    frame_.match(state.history, blocks);
    TrackedVoxelPass(coding, state.tracked_voxels, frame_, parameters_).run();
    return newVoxels();
  }

  /** \brief The same with a block that is coded as new even if it is tracked. */
  bool
  occupancyWithNewBlock(const BlockList& blocks, std::uint64_t key, std::uint64_t mask)
  {
    frame_.match(state.history, blocks);
    frame_.target_keys = {key};
    frame_.target_masks = {mask};
    TrackedVoxelPass(coding, state.tracked_voxels, frame_, parameters_).run();
    return newVoxels();
  }

  /** \brief The octant and the cell of a new block of one voxel without neighbours, of
   * a frame whose other blocks have no new voxels. */
  void
  newVoxel(unsigned int cell)
  {
    for (const unsigned int target : {cell >> 3, cell & 7}) {
      ParentNode parent;
      parent.target = 1u << target;
      codeChildren(coding, state.children, parent, NodeSurroundings());
    }
  }

  void
  numbers(const BlockList& blocks, std::vector<std::uint16_t> numbers)
  {
    IntensityPass(coding, state.intensity, frame_.directory, parameters_)
        .run(blocks, numbers);
  }

  /** \brief Decisions to go on, from one number up to another, where it is a no unless
   * it is the last number of all. */
  template <typename ModelT>
  void
  unary(ModelT& model,
        std::uint32_t row,
        std::uint32_t from,
        std::uint32_t end,
        std::uint32_t last)
  {
    for (std::uint32_t t = from; t < last && t <= end; ++t) {
      typename ModelT::Contexts contexts{};
      contexts.ways[0] = row + t;
      coding.code(model, contexts, t < end);
    }
  }

  /** \brief An escape with more bits than there may be. */
  void
  longEscape()
  {
    unary(state.intensity.escape,
          0,
          0,
          IntensityContexts::longest_escape,
          IntensityContexts::longest_escape);
  }

  void
  escape(std::uint32_t number)
  {
    std::uint32_t bits = 0;
    while ((number + 1) >> bits > 1)
      ++bits;
    unary(state.intensity.escape, 0, 0, bits, IntensityContexts::longest_escape);
    while (bits-- > 0)
      coding.codeBypass(((number + 1) >> bits & 1) != 0);
  }

  /** \brief The payload; the frame is learnt. */
  Bytes
  finish(const BlockList& blocks, const std::vector<std::uint16_t>& numbers)
  {
    state.history.update(blocks, numbers, nullptr, state.is_i_frame);
    state.is_i_frame = false;
    return finish();
  }

  /** \brief The payload of a frame that is not learnt. */
  Bytes
  finish()
  {
    coding.coder().finish();
    return bytes_;
  }

  ContextState state;

private:
  bool
  newVoxels()
  {
    return NewVoxelPass(coding, state.new_voxels, frame_, parameters_, most_blocks)
               .run() &&
           NewBlockPass(
               coding, state.children, frame_, parameters_, most_blocks, most_blocks)
               .run();
  }

  FrameParameters parameters_;
  FrameBlocks frame_;
  Bytes bytes_;

public:
  Coding coding{BinaryRangeEncoder(bytes_)};
};

inline BlockList
blocksOf(const std::vector<std::uint64_t>& keys)
{
  BlockList blocks;
  blocks.assign(keys);
  return blocks;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
