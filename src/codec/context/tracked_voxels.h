// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/models.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Models of tracked voxels (doc/bitstream_context.md, "Tracked voxels"). */
struct TrackedVoxelModels {
  explicit TrackedVoxelModels(bool is_small)
  : voxel(is_small, 6, {16 * 7 * 9 * 2, 32 * 4 * 3 * 5}, 24)
  {}

  DecisionModel<2> voxel; ///< a tracked voxel is occupied
};

/** \brief For each cell of a block how many of its neighbours are in a set: 0, 1, or
 * more. */
struct FewNeighbours {
  std::uint64_t one = 0; ///< cells with at least one
  std::uint64_t two = 0; ///< cells with at least two

  /** \brief Adds a neighbour of each of some cells. */
  void
  add(std::uint64_t cells)
  {
    two |= one & cells;
    one |= cells;
  }

  /** \brief 0, 1 or 2. */
  std::uint32_t
  of(unsigned int cell) const
  {
    return static_cast<std::uint32_t>((one >> cell & 1) + (two >> cell & 1));
  }
};

/** \brief Codes the occupancy of the tracked voxels, which have a record in the
 * history, for either direction.
 * \tparam CodingT DecisionCoding
 */
template <typename CodingT>
class TrackedVoxelPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] frame after FrameBlocks::begin() or match()
   * \param[in] parameters of the frame
   */
  TrackedVoxelPass(CodingT& coding,
                   TrackedVoxelModels& models,
                   FrameBlocks& frame,
                   const FrameParameters& parameters)
  : coding_(coding)
  , models_(models)
  , frame_(frame)
  , history_(parameters.history)
  , levels_(levelsAboveBlocks(parameters.grid_depth))
  , mean_shift_(parameters.history.fractionBits() -
                std::min(parameters.history.fractionBits(), 2u))
  {}

  /** \brief Codes the tracked voxels.
   * \return number of occupied ones
   */
  std::size_t
  run()
  {
    findNeighbours();
    std::size_t voxels = 0;
    // A copy, which stays in registers.
    CodingT coding = coding_;
    for (std::size_t i = 0; i < history_.blocks().size(); ++i) {
      frame_.blocks[i].present = codeBlock(coding, i, frame_.target_cells[i]);
      voxels += bitCount(frame_.blocks[i].present);
    }
    coding_ = coding;
    return voxels;
  }

private:
  using Contexts = DecisionModel<2>::Contexts;

  /** \brief The neighbours of the cells of a block. */
  struct Surroundings {
    NeighbourCounts before; ///< occupied in the last frame
    FewNeighbours came; ///< occupied now, but not in the last frame, as far as coded
    FewNeighbours went; ///< the other way round
  };

  std::uint64_t
  codeBlock(CodingT& coding, std::size_t index, std::uint64_t target)
  {
    const HistoryBlock& block = history_.blocks()[index];
    Surroundings around = lookAround(index);
    std::uint64_t occupied = 0;
    const VoxelRecord* record = history_.records() + block.first_record;
    for (std::uint64_t cells = block.tracked; cells != 0;
         cells &= cells - 1, ++record) {
      const unsigned int cell = lowestBit(cells);
      Contexts contexts;
      contexts.ways[0] =
          (((record->probability >> 12) * 7u + around.before.of(cell)) * 9 +
           around.came.of(cell) * 3 + around.went.of(cell)) *
              2 +
          (record->recent & 1u);
      if constexpr (CodingT::is_small) {
        const std::uint32_t age_class =
            age_classes[std::min<std::uint32_t>(record->age, 5)];
        contexts.ways[1] = recordContext(*record, age_class);
        contexts.weight_set = (record->probability >> 13) * 3u + age_class;
      }
      const bool is_occupied =
          coding.code(models_.voxel, contexts, (target >> cell & 1) != 0);
      occupied |= std::uint64_t{is_occupied} << cell;
      // Without a branch, which would be mispredicted.
      const std::uint64_t was = 0 - (block.last >> cell & 1);
      const std::uint64_t is = 0 - std::uint64_t{is_occupied};
      around.came.add(cells_beside[cell] & is & ~was);
      around.went.add(cells_beside[cell] & was & ~is);
    }
    return occupied;
  }

  /** \brief Context from the record alone: probability, last two frames, age and
   * mean. */
  std::uint32_t
  recordContext(const VoxelRecord& record, std::uint32_t age_class) const
  {
    const std::uint32_t mean_class =
        mean_classes[std::min<std::uint32_t>(record.mean >> mean_shift_, 20)];
    return (((record.probability >> 11) * 4u + (record.recent & 3u)) * 3 + age_class) *
               5 +
           mean_class;
  }

  /** \brief Classes of a mean in quarters of a point: bounds at 1.5, 2, 3 and 5
   * points. */
  static constexpr std::array<std::uint8_t, 21> mean_classes = {
      0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 4};
  static constexpr std::array<std::uint8_t, 6> age_classes = {0, 0, 1, 1, 1, 2};

  Surroundings
  lookAround(std::size_t index) const
  {
    const std::vector<HistoryBlock>& blocks = history_.blocks();
    Surroundings around;
    std::array<std::uint64_t, face_count> before;
    for (std::size_t face = 0; face < face_count; ++face) {
      // Without branches on whether there is a block, which would be mispredicted.
      const std::uint32_t found = frame_.neighbours[index][face];
      const bool is_there = found != BlockDirectory::not_found;
      const std::size_t other = is_there ? found : index;
      const std::uint64_t mask = 0 - std::uint64_t{is_there};
      before[face] = blocks[other].last & mask;
      if (face >= 3) // not coded yet
        continue;
      const std::uint64_t now = frame_.blocks[other].present & mask;
      around.came.add(occupiedAcross(0, now & ~before[face], face));
      around.went.add(occupiedAcross(0, before[face] & ~now, face));
    }
    around.before = countNeighbours(blocks[index].last, before);
    return around;
  }

  /** \brief Finds the blocks across the faces of each block. */
  void
  findNeighbours()
  {
    const std::vector<HistoryBlock>& blocks = history_.blocks();
    constexpr std::uint32_t none = BlockDirectory::not_found;
    // What is not there is written to the one after them, so that no branch is needed.
    reserveAhead(frame_.neighbours, blocks.size() + 1);
    frame_.neighbours.assign(blocks.size() + 1, {none, none, none, none, none, none});
    // Blocks with the same parent, by the last three bits of their keys.
    std::uint64_t parent = ~std::uint64_t{0};
    std::array<std::uint32_t, 8> siblings{};
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const std::uint64_t key = blocks[i].key;
      if (key >> 3 != parent) {
        parent = key >> 3;
        siblings.fill(none);
      }
      siblings[key & 7] = static_cast<std::uint32_t>(i);
      for (std::size_t face = 0; face < 3; ++face) {
        const unsigned int axis = 4u >> face;
        std::uint32_t other = none;
        std::uint64_t below = 0;
        if ((key & axis) != 0)
          other = siblings[(key ^ axis) & 7];
        else if (neighbourBlock(key, face, levels_, below))
          other = frame_.blocks.find(below);
        frame_.neighbours[i][face] = other;
        frame_.neighbours[std::min<std::size_t>(other, blocks.size())][face + 3] =
            static_cast<std::uint32_t>(i);
      }
    }
  }

  CodingT& coding_;
  TrackedVoxelModels& models_;
  FrameBlocks& frame_;
  const History& history_;
  unsigned int levels_;
  unsigned int mean_shift_; // from a mean's fixed point to quarters
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
