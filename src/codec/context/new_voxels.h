#pragma once

#include "codec/context/frame.h"
#include "codec/context/history.h"
#include "codec/context/models.h"
#include "codec/context/new_cells.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Models of new voxels (doc/bitstream_context.md, "New blocks"). */
struct NewVoxelModels {
  explicit NewVoxelModels(bool is_mixing)
  : known_block(is_mixing, 5, {64})
  , branch(is_mixing, 5, {432})
  , new_block(is_mixing, 5, {72})
  , cells(is_mixing)
  {}

  DecisionModel<1> known_block; ///< a block of the history has new voxels
  DecisionModel<1> branch;      ///< a branch above the blocks has new blocks
  DecisionModel<1> new_block;   ///< a block is new
  NewCellModels cells;
};

/** \brief Codes the voxels without a record in the history, for either direction: those in
 * known blocks, then the new blocks as an octree.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class NewVoxelPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] frame its known voxels have been coded
   * \param[in] context of the frame
   * \param[in] max_voxels of the pass; a decoder fails where there are more
   */
  NewVoxelPass(CodingT& coding,
               NewVoxelModels& models,
               Frame& frame,
               const FrameContext& context,
               std::size_t max_voxels)
  : coding_(coding)
  , models_(models)
  , frame_(frame)
  , history_(context.history)
  , is_i_frame_(context.is_i_frame ? 1 : 0)
  , levels_(levelsAboveBlocks(context.grid_depth))
  , cells_in_grid_(cellsInGrid(context.grid_depth))
  , max_voxels_(max_voxels)
  {}

  /** \brief Codes the new voxels.
   * \return false if the decoded voxels are invalid or more than max_voxels
   */
  bool
  run()
  {
    if (!codeKnownBlocks())
      return false;
    if (!coding_.codeBypass(!frame_.target_keys.empty()))
      return true;
    const Range all{0, 0, history_.blocks().size(), 0, frame_.target_keys.size()};
    if (levels_ > 0)
      return codeBranch(all, levels_);
    // A grid of one block: it is new only if the history is empty.
    return history_.blocks().empty() && codeNewBlock(all);
  }

private:
  /** \brief Codes the new voxels of known blocks. Few blocks have any, and most of these
   * one. */
  bool
  codeKnownBlocks()
  {
    const std::vector<HistoryBlock>& known = history_.blocks();
    bool had_new_voxels = false; // the previous block
    for (std::size_t i = 0; i < known.size(); ++i) {
      NewVoxelBlock block;
      block.unknown = cells_in_grid_ & ~known[i].known;
      if (block.unknown == 0)
        continue;
      const unsigned int count = bitCount(known[i].known);
      const std::uint32_t known_class = count < 4    ? 0
                                        : count < 10 ? 1
                                        : count < 20 ? 2
                                                     : 3;
      const std::uint32_t context =
          (known[i].activity * 4u + known_class) * 2 + (had_new_voxels ? 1 : 0);
      const bool has_new_voxels =
          coding_.code(models_.known_block, {{context}}, frame_.new_cells[i] != 0);
      had_new_voxels = has_new_voxels;
      if (!has_new_voxels)
        continue;
      block.is_known = true;
      block.occupied = frame_.occupied[i];
      block.empty = countNeighbours(known[i].known & ~block.occupied, {});
      block.activity = known[i].activity;
      block.target = frame_.new_cells[i];
      if (!codeCellsOf(block, known[i].key))
        return false;
      frame_.occupied[i] = block.occupied;
    }
    return true;
  }

  /** \brief A branch of the octree with its blocks of the history and, in an encoder, its
   * new blocks. */
  struct Range {
    std::uint64_t key;
    std::size_t known_begin;
    std::size_t known_end;
    std::size_t target_begin;
    std::size_t target_end;
  };

  /** \brief Codes which of the eight parts of a branch have new blocks, and these parts.
   * \param[in] branch with at least one new block
   * \param[in] levels octree levels from the branch to the blocks, 1..19
   */
  bool
  codeBranch(const Range& branch, unsigned int levels)
  {
    const std::vector<HistoryBlock>& known = history_.blocks();
    const unsigned int shift = 3 * (levels - 1);
    const std::uint32_t present = levels == 1 ? presentBlocks(branch) : 0;
    Range part = branch;
    part.known_end = branch.known_begin;
    part.target_end = branch.target_begin;
    std::uint32_t parts = 0; // those with new blocks so far, one bit each
    for (unsigned int child = 0; child < 8; ++child) {
      part.key = branch.key << 3 | child;
      part.known_begin = part.known_end;
      while (part.known_end < branch.known_end &&
             known[part.known_end].key >> shift == part.key)
        ++part.known_end;
      part.target_begin = part.target_end;
      while (part.target_end < branch.target_end &&
             frame_.target_keys[part.target_end] >> shift == part.key)
        ++part.target_end;
      const bool is_known_block = levels == 1 && part.known_end > part.known_begin;
      const bool has_new_blocks = part.target_end > part.target_begin;
      // At least one part has new blocks: it is the last one if no other has.
      const bool decision =
          (child == 7 && parts == 0) ||
          (!is_known_block &&
           (levels == 1 ? codeIsBlockNew(child, parts, present | parts, has_new_blocks)
                        : codeIsBranchNew(part, levels, parts, has_new_blocks)));
      if (!decision)
        continue;
      if (is_known_block)
        return false;
      parts |= 1u << child;
      if (!(levels == 1 ? codeNewBlock(part) : codeBranch(part, levels - 1)))
        return false;
    }
    return true;
  }

  /** \brief The known and occupied blocks of the eight of a branch, one bit each. */
  std::uint32_t
  presentBlocks(const Range& branch) const
  {
    std::uint32_t present = 0;
    for (std::size_t i = branch.known_begin; i < branch.known_end; ++i)
      if (frame_.occupied[i] != 0)
        present |= 1u << (history_.blocks()[i].key & 7);
    return present;
  }

  bool
  codeIsBranchNew(const Range& part,
                  unsigned int levels,
                  std::uint32_t parts,
                  bool has_new_blocks)
  {
    const auto child = static_cast<std::uint32_t>(part.key & 7);
    const std::size_t blocks = part.known_end - part.known_begin;
    const std::uint32_t block_class = blocks == 0   ? 0
                                      : blocks < 2  ? 1
                                      : blocks < 4  ? 2
                                      : blocks < 8  ? 3
                                      : blocks < 16 ? 4
                                                    : 5;
    const std::uint32_t context =
        ((block_class * 9 + candidateClass(child_masks.count[parts], 7 - child)) * 4 +
         upTo(levels - 2, 3)) *
            2 +
        is_i_frame_;
    return coding_.code(models_.branch, {{context}}, has_new_blocks);
  }

  bool
  codeIsBlockNew(unsigned int child,
                 std::uint32_t parts,
                 std::uint32_t present,
                 bool has_new_blocks)
  {
    const std::uint32_t neighbours = (present >> (child ^ 1) & 1) +
                                     (present >> (child ^ 2) & 1) +
                                     (present >> (child ^ 4) & 1);
    const std::uint32_t context =
        (neighbours * 9 + candidateClass(child_masks.count[parts], 7 - child)) * 2 +
        is_i_frame_;
    return coding_.code(models_.new_block, {{context}}, has_new_blocks);
  }

  bool
  codeNewBlock(const Range& range)
  {
    NewVoxelBlock block;
    block.unknown = cells_in_grid_;
    block.target = CodingT::is_decoder ? 0 : frame_.target_masks[range.target_begin];
    if (!codeCellsOf(block, range.key))
      return false;
    frame_.directory.insert(range.key);
    frame_.occupied.push_back(block.occupied);
    frame_.new_keys.push_back(range.key);
    return true;
  }

  /** \brief Codes the new voxels of a block that has at least one. */
  bool
  codeCellsOf(NewVoxelBlock& block, std::uint64_t key)
  {
    for (std::size_t face = 0; face < face_count; ++face) {
      std::uint64_t neighbour = 0;
      if (!neighbourBlock(key, face, levels_, neighbour))
        continue;
      const std::uint32_t index = frame_.directory.find(neighbour);
      if (index != BlockDirectory::not_found)
        block.neighbours[face] = frame_.occupied[index];
    }
    block.full = countNeighbours(block.occupied, block.neighbours);
    const std::uint64_t before = block.occupied;
    // A copy, which stays in registers.
    CodingT coding = coding_;
    NewCellPass<CodingT>(models_.cells, is_i_frame_ != 0).run(coding, block);
    coding_ = coding;
    voxels_ += bitCount(block.occupied & ~before);
    return voxels_ <= max_voxels_;
  }

  CodingT& coding_;
  NewVoxelModels& models_;
  Frame& frame_;
  const History& history_;
  std::uint32_t is_i_frame_;
  unsigned int levels_;
  std::uint64_t cells_in_grid_;
  std::size_t max_voxels_;
  std::size_t voxels_ = 0;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
