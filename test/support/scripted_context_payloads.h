/** \file
 * \brief Writes payloads of the effort balanced with the encoder's own passes and, where
 * an encoder would not, decision by decision (doc/bitstream_context.md).
 */
#pragma once

#include "codec/context/entropy_coder.h"
#include "codec/context/frame.h"
#include "codec/context/intensities.h"
#include "codec/context/known_voxels.h"
#include "codec/context/models.h"
#include "codec/context/new_voxels.h"
#include "support/voxel_frames.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace test {

using namespace context;

/** \brief What both ends have learnt of a stream. */
struct ContextState {
  KnownVoxelModels known_voxels{false};
  NewVoxelModels new_voxels{false};
  IntensityModels intensity{false};
  History history;
  bool is_i_frame = true; // the next frame
};

/** \brief One frame's payload. */
class ContextScript {
public:
  using Coding = SingleContextCoding<BinaryRangeEncoder>;
  using Decision = DecisionModel<1>;

  /** \param[in] before what was learnt of the frames before
   * \param[in] like grid, scale and depth model of the frame
   */
  ContextScript(const ContextState& before, const VoxelFrame& like)
  : state(before)
  , context_{state.history,
             state.is_i_frame,
             like.grid.depth,
             like.intensity_scale.bits,
             like.depth_model ? &*like.depth_model : nullptr}
  {
    if (state.is_i_frame)
      state.history.clear(like.intensity_scale.bits, forgotten_below);
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
    KnownVoxelPass(coding, state.known_voxels, frame_, context_).run();
    return newVoxels();
  }

  /** \brief The same with a block that is coded as new even if it is known. */
  bool
  occupancyWithNewBlock(const BlockList& blocks, std::uint64_t key, std::uint64_t mask)
  {
    frame_.match(state.history, blocks);
    frame_.target_keys = {key};
    frame_.target_masks = {mask};
    KnownVoxelPass(coding, state.known_voxels, frame_, context_).run();
    return newVoxels();
  }

  /** \brief The cells of a new block without neighbours. */
  void
  newBlock(std::uint64_t mask)
  {
    NewVoxelBlock block;
    block.unknown = ~std::uint64_t{0};
    block.target = mask;
    NewCellPass<Coding>(state.new_voxels.cells, state.is_i_frame).run(coding, block);
  }

  void
  numbers(const BlockList& blocks, std::vector<std::uint16_t> numbers)
  {
    IntensityPass(coding, state.intensity, frame_.directory, context_)
        .run(blocks, false, numbers);
  }

  /** \brief What comes in front of numbers none of which is 0. */
  void
  beginNumbers()
  {
    coding.codeBypass(false);
    coding.codeBypass(false);
  }

  /** \brief An I-frame's first number above 0, as decisions to go on.
   * \param[in] end the first one that is a no; above 24 all are a yes
   */
  void
  firstNumber(std::uint32_t end)
  {
    constexpr std::uint32_t row = (20 + 16 / 16) * 8;
    unary(state.intensity.more, row * IntensityModels::longest_count, 1, end, 24);
  }

  /** \brief Decisions to go on, from one number up to another, where it is a no unless
   * it is the last number of all. */
  template <std::size_t WayCount>
  void
  unary(DecisionModel<WayCount>& model,
        std::uint32_t row,
        std::uint32_t from,
        std::uint32_t end,
        std::uint32_t last)
  {
    for (std::uint32_t t = from; t < last && t <= end; ++t) {
      typename DecisionModel<WayCount>::Contexts contexts{};
      contexts.ways[0] = row + t;
      coding.code(model, contexts, t < end);
    }
  }

  /** \brief An escape with more bits than there may be. */
  void
  longEscape(std::uint32_t kind)
  {
    unary(state.intensity.escape,
          kind * IntensityModels::longest_escape,
          0,
          IntensityModels::longest_escape,
          IntensityModels::longest_escape);
  }

  /** \brief An escape with a number. */
  void
  escape(std::uint32_t kind, std::uint32_t number)
  {
    std::uint32_t bits = 0;
    while ((number + 1) >> bits > 1)
      ++bits;
    unary(state.intensity.escape,
          kind * IntensityModels::longest_escape,
          0,
          bits,
          IntensityModels::longest_escape);
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
  static constexpr std::uint16_t forgotten_below = 3000;

  bool
  newVoxels()
  {
    return NewVoxelPass(coding, state.new_voxels, frame_, context_, 1000).run();
  }

  FrameContext context_;
  Frame frame_;
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

} // namespace test
} // namespace io
} // namespace pcl_ext
