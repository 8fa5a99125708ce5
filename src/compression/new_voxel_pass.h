#pragma once

#include "context_models.h"
#include "occupancy_workspace.h"
#include "payload_context.h"
#include "voxel_block.h"
#include "voxel_history.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief What is learnt about new voxels (doc/bitstream.md, "New voxels"). */
struct NewVoxelModels {
  explicit NewVoxelModels(bool is_mixing)
  : branch(is_mixing, 5, {144})
  , known_block(is_mixing, 5, {96})
  , new_block(is_mixing, 5, {24})
  , octant(is_mixing, 5, {432, 1944, 5120}, 6)
  , cell(is_mixing, 5, {672, 3072, 1792, 896}, 14)
  {}

  DecisionModel<1> branch;      ///< new voxels are in a branch above blocks
  DecisionModel<1> known_block; ///< new voxels are in a block of the history
  DecisionModel<1> new_block;   ///< new voxels are in another block
  DecisionModel<3> octant;      ///< new voxels are in an octant of a block
  DecisionModel<4> cell;        ///< a cell is a new voxel
};

/** \brief Codes the voxels that the history does not know, as a small octree of the
 * blocks that have any, for either direction.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class NewVoxelPass {
public:
  /** \brief A pass over one frame.
   * \param[in] workspace its known voxels have been coded
   * \param[in] context what both sides know before the frame
   * \param[in] max_voxels of the pass; where decoding gives up
   */
  NewVoxelPass(CodingT& coding,
               NewVoxelModels& models,
               OccupancyWorkspace& workspace,
               const PayloadContext& context,
               std::size_t max_voxels)
  : coding_(coding)
  , models_(models)
  , work_(workspace)
  , history_(context.history)
  , is_i_frame_(context.is_i_frame ? 1 : 0)
  , levels_(levelsAboveBlocks(context.grid_depth))
  , cells_in_grid_(cellsInGrid(context.grid_depth))
  , max_voxels_(max_voxels)
  {}

  /** \brief Codes the new voxels.
   * \return false if what was decoded are no voxels, or more than there may be
   */
  bool
  run()
  {
    if (!coding_.codeRaw(!work_.target_keys.empty()))
      return true;
    const Range all{0, 0, history_.blocks().size(), 0, work_.target_keys.size()};
    return levels_ == 0 ? codeBlock(all) : codeBranch(all, levels_);
  }

private:
  /** \brief A branch of the octree, and what lies in it: blocks of the history, and of
   * the encoder's target. */
  struct Range {
    std::uint64_t key;
    std::size_t known_begin;
    std::size_t known_end;
    std::size_t target_begin;
    std::size_t target_end;
  };

  /** \brief Codes in which of a branch's eight parts new voxels are, and these parts.
   * \param[in] branch at least one new voxel is in it
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
    std::uint32_t parts = 0; // with new voxels so far, one bit each
    for (unsigned int child = 0; child < 8; ++child) {
      part.key = branch.key << 3 | child;
      part.known_begin = part.known_end;
      while (part.known_end < branch.known_end &&
             known[part.known_end].key >> shift == part.key)
        ++part.known_end;
      part.target_begin = part.target_end;
      while (part.target_end < branch.target_end &&
             work_.target_keys[part.target_end] >> shift == part.key)
        ++part.target_end;
      const bool has_new_voxels = part.target_end > part.target_begin;
      // One of the parts has new voxels; if none before it has, the last one does.
      const bool is_implied = child == 7 && parts == 0;
      const bool decision =
          is_implied ||
          (levels == 1 ? codeIsBlockNew(part, parts, present | parts, has_new_voxels)
                       : codeIsBranchNew(part, levels, parts, has_new_voxels));
      if (!decision)
        continue;
      parts |= 1u << child;
      if (!(levels == 1 ? codeBlock(part) : codeBranch(part, levels - 1)))
        return false;
    }
    return true;
  }

  /** \brief Which of the eight blocks of a branch the history knows and are occupied. */
  std::uint32_t
  presentBlocks(const Range& branch) const
  {
    std::uint32_t present = 0;
    for (std::size_t i = branch.known_begin; i < branch.known_end; ++i)
      if (work_.occupied[i] != 0)
        present |= 1u << (history_.blocks()[i].key & 7);
    return present;
  }

  static std::uint32_t
  upTo(std::uint32_t number, std::uint32_t highest)
  {
    return std::min(number, highest);
  }

  bool
  codeIsBranchNew(const Range& part,
                  unsigned int levels,
                  std::uint32_t parts,
                  bool has_new_voxels)
  {
    const std::size_t blocks = part.known_end - part.known_begin;
    const std::uint32_t block_class = blocks == 0   ? 0
                                      : blocks < 2  ? 1
                                      : blocks < 4  ? 2
                                      : blocks < 8  ? 3
                                      : blocks < 16 ? 4
                                                    : 5;
    const std::uint32_t context =
        ((block_class * 3 + upTo(bit_counts[parts], 2)) * 4 + upTo(levels - 2, 3)) * 2 +
        is_i_frame_;
    return coding_.code(models_.branch, {{context}}, has_new_voxels);
  }

  bool
  codeIsBlockNew(const Range& part,
                 std::uint32_t parts,
                 std::uint32_t present,
                 bool has_new_voxels)
  {
    const std::uint32_t part_class = upTo(bit_counts[parts], 2);
    if (part.known_end > part.known_begin) {
      const HistoryBlock& block = history_.blocks()[part.known_begin];
      const unsigned int known = cellCount(block.known);
      const std::uint32_t known_class = known < 4    ? 0
                                        : known < 10 ? 1
                                        : known < 20 ? 2
                                                     : 3;
      const std::uint32_t context =
          (block.activity * 4u + known_class) * 3 + part_class;
      return coding_.code(models_.known_block, {{context}}, has_new_voxels);
    }
    const auto child = static_cast<unsigned int>(part.key & 7);
    const std::uint32_t neighbours = (present >> (child ^ 1) & 1) +
                                     (present >> (child ^ 2) & 1) +
                                     (present >> (child ^ 4) & 1);
    const std::uint32_t context = (neighbours * 3 + part_class) * 2 + is_i_frame_;
    return coding_.code(models_.new_block, {{context}}, has_new_voxels);
  }

  /** \brief Codes the new voxels of a block that has at least one. */
  bool
  codeBlock(const Range& range)
  {
    const bool is_known = range.known_end > range.known_begin;
    Block block;
    block.unknown = cells_in_grid_;
    block.target = CodingT::is_decoder ? 0 : work_.target_masks[range.target_begin];
    if (is_known) {
      const std::uint64_t known = history_.blocks()[range.known_begin].known;
      block.unknown &= ~known;
      block.occupied = work_.occupied[range.known_begin];
      block.empty = countNeighbours(known & ~block.occupied, {});
      block.activity = history_.blocks()[range.known_begin].activity;
    }
    if (block.unknown == 0)
      return false;
    findNeighbours(range.key, block);
    const std::uint64_t before = block.occupied;
    // A copy, whose numbers can stay in registers.
    CodingT coding = coding_;
    codeOctants(coding, block);
    coding_ = coding;
    const std::uint64_t new_voxels = block.occupied & ~before;
    voxels_ += cellCount(new_voxels);
    if (is_known)
      work_.occupied[range.known_begin] = block.occupied;
    else {
      work_.directory.insert(range.key,
                             static_cast<std::uint32_t>(work_.occupied.size()));
      work_.occupied.push_back(block.occupied);
      work_.new_keys.push_back(range.key);
    }
    return voxels_ <= max_voxels_;
  }

  /** \brief A block while its new voxels are coded. */
  struct Block {
    std::uint64_t unknown = 0;  // cells without record
    std::uint64_t occupied = 0; // known ones, and new ones so far
    std::uint64_t target = 0;   // the encoder's: new ones
    NeighbourCounts empty;      // known cells around a cell, in the block, now empty
    NeighbourCounts full;       // occupied cells around a cell
    std::uint8_t activity = 0;  // of the history
    std::array<std::uint64_t, face_count> neighbours{};
  };

  void
  findNeighbours(std::uint64_t key, Block& block) const
  {
    for (std::size_t face = 0; face < face_count; ++face) {
      std::uint64_t neighbour = 0;
      if (!neighbourBlock(key, face, levels_, neighbour))
        continue;
      const std::uint32_t index = work_.directory.find(neighbour);
      if (index != BlockDirectory::not_found)
        block.neighbours[face] = work_.occupied[index];
    }
    block.full = countNeighbours(block.occupied, block.neighbours);
  }

  void
  codeOctants(CodingT& coding, Block& block)
  {
    std::uint32_t octants = 0; // with new voxels so far
    for (unsigned int octant = 0; octant < 8; ++octant) {
      const std::uint64_t cells = std::uint64_t{0xff} << (8 * octant);
      if ((block.unknown & cells) == 0)
        continue;
      const bool is_last =
          8 * octant + 8 >= block_cells || block.unknown >> (8 * octant + 8) == 0;
      const bool has_new_voxels =
          (is_last && octants == 0) ||
          codeIsOctantNew(coding, block, octant, octants, (block.target & cells) != 0);
      if (!has_new_voxels)
        continue;
      ++octants;
      codeCells(coding, block, block.unknown & cells);
    }
  }

  bool
  codeIsOctantNew(CodingT& coding,
                  const Block& block,
                  unsigned int octant,
                  std::uint32_t octants,
                  bool has_new_voxels)
  {
    const unsigned int neighbours = block.full.sum(octant);
    const unsigned int known = 8 - octantCount(block.unknown, octant);
    const unsigned int occupied = octantCount(block.occupied, octant);
    const std::uint32_t neighbour_class = neighbours < 2    ? neighbours
                                          : neighbours < 4  ? 2
                                          : neighbours < 7  ? 3
                                          : neighbours < 12 ? 4
                                                            : 5;
    const std::uint32_t known_class = known == 0  ? 0
                                      : known < 3 ? 1
                                      : known < 6 ? 2
                                                  : 3;
    const std::uint32_t occupied_class = occupied == 0 ? 0 : occupied < 3 ? 1 : 2;
    const std::uint32_t octant_class = upTo(octants, 2);
    typename decltype(models_.octant)::Contexts contexts;
    contexts.ways[0] = (((neighbour_class * 4 + known_class) * 3 + occupied_class) * 3 +
                        octant_class) *
                           2 +
                       is_i_frame_;
    if constexpr (CodingT::is_mixing) {
      contexts.ways[1] = ((upTo(neighbours, 23) * 9 + known) * 9 + occupied) % 1944;
      contexts.ways[2] =
          ((block.activity * 8u + octant) * 10 + upTo(neighbours, 9)) * 8 +
          upTo(octants, 3) * 2 + is_i_frame_;
      contexts.weight_set = octant_class * 2 + is_i_frame_;
    }
    return coding.code(models_.octant, contexts, has_new_voxels);
  }

  /** \brief Codes which cells of an octant are new voxels, of which there is one. */
  void
  codeCells(CodingT& coding, Block& block, std::uint64_t cells)
  {
    std::uint32_t found = 0;
    std::uint32_t left = cellCount(cells);
    for (; cells != 0; cells &= cells - 1) {
      --left;
      const std::uint64_t cell_bit = cells & (~cells + 1);
      const unsigned int cell = lowestCell(cells);
      const std::uint32_t full = block.full.of(cell);
      typename decltype(models_.cell)::Contexts contexts;
      contexts.ways[0] =
          (((full * 3 + upTo(found, 2)) * 4 + upTo(left, 3)) * 2 + is_i_frame_) * 4 +
          upTo(block.empty.of(cell), 3);
      if constexpr (CodingT::is_mixing) {
        const std::uint32_t octant_mask =
            static_cast<std::uint32_t>(block.occupied >> (cell & ~7u) & 0xff);
        contexts.ways[1] = (octant_mask * 8 + (cell & 7)) + 2048 * (is_i_frame_ & 0);
        contexts.ways[2] = facePattern(block, cell) * 28 + upTo(found, 3) * 7 +
                           upTo(block.empty.of(cell), 6);
        contexts.ways[3] =
            ((block.activity * 7u + full) * 8 + upTo(left, 7)) * 2 + is_i_frame_;
        contexts.weight_set = full * 2 + is_i_frame_;
      }
      const bool is_implied = left == 0 && found == 0;
      if (!is_implied &&
          !coding.code(models_.cell, contexts, (block.target & cell_bit) != 0))
        continue;
      ++found;
      block.occupied |= cell_bit;
      block.full = countNeighbours(block.occupied, block.neighbours);
    }
  }

  /** \brief Which of a cell's six neighbours are occupied, one bit each. */
  static std::uint32_t
  facePattern(const Block& block, unsigned int cell)
  {
    std::uint32_t pattern = 0;
    for (std::size_t face = 0; face < face_count; ++face)
      pattern |=
          static_cast<std::uint32_t>(
              occupiedAcross(block.occupied, block.neighbours[face], face) >> cell & 1)
          << face;
    return pattern;
  }

  CodingT& coding_;
  NewVoxelModels& models_;
  OccupancyWorkspace& work_;
  const VoxelHistory& history_;
  std::uint32_t is_i_frame_;
  unsigned int levels_;
  std::uint64_t cells_in_grid_;
  std::size_t max_voxels_;
  std::size_t voxels_ = 0;
};

} // namespace io
} // namespace pcl_ext
