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
  : known_block(is_mixing, 5, {64})
  , branch(is_mixing, 5, {432})
  , new_block(is_mixing, 5, {72})
  , octant(is_mixing, 5, {1296, 1944, 5120}, 6)
  , more_octants(is_mixing, 5, {16})
  , cell(is_mixing, 5, {840, 2048, 1792, 896}, 14)
  , more_cells(is_mixing, 5, {32})
  {}

  DecisionModel<1> known_block;  ///< new voxels are in a block of the history
  DecisionModel<1> branch;       ///< new blocks are in a branch above blocks
  DecisionModel<1> new_block;    ///< a block is new
  DecisionModel<3> octant;       ///< new voxels are in an octant of a block
  DecisionModel<1> more_octants; ///< and in another one
  DecisionModel<4> cell;         ///< a cell is a new voxel
  DecisionModel<1> more_cells;   ///< and another one
};

/** \brief Codes the voxels that the history does not know, for either direction: those in
 * blocks that it knows, then new blocks as a small octree.
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
    if (!codeKnownBlocks())
      return false;
    if (!coding_.codeRaw(!work_.target_keys.empty()))
      return true;
    const Range all{0, 0, history_.blocks().size(), 0, work_.target_keys.size()};
    if (levels_ > 0)
      return codeBranch(all, levels_);
    // A grid of one block, which is not to be both known and new.
    return history_.blocks().empty() && codeNewBlock(all);
  }

private:
  /** \brief A block while its new voxels are coded. */
  struct Block {
    std::uint64_t unknown = 0;  // cells without record
    std::uint64_t occupied = 0; // known ones, and new ones so far
    std::uint64_t target = 0;   // the encoder's: new ones
    NeighbourCounts empty;      // known cells around a cell, in the block, now empty
    NeighbourCounts full;       // occupied cells around a cell
    std::uint8_t activity = 0;  // of the history
    bool is_known = false;
    std::array<std::uint64_t, face_count> neighbours{};
  };

  /** \brief Codes the new voxels of the blocks that the history knows. Few of these have
   * any, and most of them one. */
  bool
  codeKnownBlocks()
  {
    const std::vector<HistoryBlock>& known = history_.blocks();
    std::uint32_t before = 0; // whether the last blocks had new voxels, the last lowest
    for (std::size_t i = 0; i < known.size(); ++i) {
      Block block;
      block.unknown = cells_in_grid_ & ~known[i].known;
      if (block.unknown == 0)
        continue;
      const unsigned int count = cellCount(known[i].known);
      const std::uint32_t known_class = count < 4    ? 0
                                        : count < 10 ? 1
                                        : count < 20 ? 2
                                                     : 3;
      const std::uint32_t context =
          (known[i].activity * 4u + known_class) * 2 + (before & 1);
      const bool has_new_voxels =
          coding_.code(models_.known_block, {{context}}, work_.new_cells[i] != 0);
      before = before << 1 | (has_new_voxels ? 1 : 0);
      if (!has_new_voxels)
        continue;
      block.is_known = true;
      block.occupied = work_.occupied[i];
      block.empty = countNeighbours(known[i].known & ~block.occupied, {});
      block.activity = known[i].activity;
      block.target = work_.new_cells[i];
      if (!codeCellsOf(block, known[i].key))
        return false;
      work_.occupied[i] = block.occupied;
    }
    return true;
  }

  /** \brief A branch of the octree, and what lies in it: blocks of the history, and of
   * the encoder's target. */
  struct Range {
    std::uint64_t key;
    std::size_t known_begin;
    std::size_t known_end;
    std::size_t target_begin;
    std::size_t target_end;
  };

  /** \brief Codes in which of a branch's eight parts new blocks are, and these parts.
   * \param[in] branch at least one new block is in it
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
    std::uint32_t parts = 0; // with new blocks so far, one bit each
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
      const bool is_known_block = levels == 1 && part.known_end > part.known_begin;
      const bool has_new_blocks = part.target_end > part.target_begin;
      // One of the parts has new blocks; if none before it has, the last one does.
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

  /** \brief Class 0..8 of one of up to eight candidates, of which one at least is it: how
   * many are left behind it while none was found, as the odds rise with each that is none;
   * else how many were.
   */
  static std::uint32_t
  candidateClass(std::uint32_t found, std::uint32_t left)
  {
    return found == 0 ? 7 - upTo(left, 7) : 6 + upTo(found, 2);
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
        ((block_class * 9 + candidateClass(bit_counts[parts], 7 - child)) * 4 +
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
        (neighbours * 9 + candidateClass(bit_counts[parts], 7 - child)) * 2 +
        is_i_frame_;
    return coding_.code(models_.new_block, {{context}}, has_new_blocks);
  }

  bool
  codeNewBlock(const Range& range)
  {
    Block block;
    block.unknown = cells_in_grid_;
    block.target = CodingT::is_decoder ? 0 : work_.target_masks[range.target_begin];
    if (!codeCellsOf(block, range.key))
      return false;
    work_.directory.insert(range.key);
    work_.occupied.push_back(block.occupied);
    work_.new_keys.push_back(range.key);
    return true;
  }

  /** \brief Codes the new voxels of a block that has at least one. */
  bool
  codeCellsOf(Block& block, std::uint64_t key)
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
    const std::uint64_t before = block.occupied;
    // A copy, whose numbers can stay in registers.
    CodingT coding = coding_;
    codeOctants(coding, block);
    coding_ = coding;
    voxels_ += cellCount(block.occupied & ~before);
    return voxels_ <= max_voxels_;
  }

  /** \brief Class of an octant by how many occupied cells are around its own. */
  static std::uint32_t
  neighbourClass(std::uint32_t neighbours)
  {
    constexpr std::array<std::uint8_t, 13> classes = {
        0, 1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4, 5};
    return classes[upTo(neighbours, 12)];
  }

  /** \brief Codes in which octants new voxels are. In a known block those with the most
   * neighbours come first, and after each that has any it is said whether there is another
   * one. */
  void
  codeOctants(CodingT& coding, Block& block)
  {
    std::array<std::uint8_t, 6> octants_of_class{}; // masks
    std::uint32_t left = 0;
    for (unsigned int octant = 0; octant < 8; ++octant) {
      if ((block.unknown >> (8 * octant) & 0xff) == 0)
        continue;
      // In a new block, where most octants have voxels, all are in one class, and what is
      // found counts as a neighbour of what comes.
      const std::uint32_t octant_class =
          block.is_known ? neighbourClass(block.full.sum(octant)) : 0;
      octants_of_class[octant_class] |= static_cast<std::uint8_t>(1u << octant);
      ++left;
    }
    std::uint32_t found = 0;
    bool is_one_left = true; // with new voxels
    for (std::size_t octant_class = 6; octant_class-- > 0;)
      for (unsigned int octants = octants_of_class[octant_class]; octants != 0;
           octants &= octants - 1) {
        const unsigned int octant = lowestCell(octants);
        --left;
        const bool is_implied = is_one_left && left == 0;
        if (!is_implied && !codeIsOctantNew(coding, block, octant, found, left))
          continue;
        ++found;
        if (block.is_known)
          codeFewCells(coding, block, octant);
        else
          codeManyCells(coding, block, octant);
        is_one_left = false;
        if (!block.is_known || left == 0)
          continue;
        is_one_left =
            coding.code(models_.more_octants,
                        {{upTo(found, 4) * 4 - 4 + upTo(left - 1, 3)}},
                        hasMoreOctants(block, octants, octant_class, octants_of_class));
        if (!is_one_left)
          return;
        block.full = countNeighbours(block.occupied, block.neighbours);
      }
  }

  /** \brief The encoder's: whether an octant behind the current one has new voxels. */
  static bool
  hasMoreOctants(const Block& block,
                 unsigned int octants,
                 std::size_t octant_class,
                 const std::array<std::uint8_t, 6>& octants_of_class)
  {
    unsigned int rest = octants & (octants - 1);
    while (octant_class-- > 0)
      rest |= octants_of_class[octant_class];
    for (; rest != 0; rest &= rest - 1)
      if ((block.target >> (8 * lowestCell(rest)) & 0xff) != 0)
        return true;
    return false;
  }

  bool
  codeIsOctantNew(CodingT& coding,
                  const Block& block,
                  unsigned int octant,
                  std::uint32_t found,
                  std::uint32_t left)
  {
    const std::uint32_t neighbours = block.full.sum(octant);
    const unsigned int known = 8 - octantCount(block.unknown, octant);
    const unsigned int occupied = octantCount(block.occupied, octant);
    constexpr std::array<std::uint8_t, 9> known_classes = {0, 1, 1, 2, 2, 2, 3, 3, 3};
    constexpr std::array<std::uint8_t, 9> occupied_classes = {
        0, 1, 1, 2, 2, 2, 2, 2, 2};
    const std::uint32_t found_class = upTo(found, 2);
    typename decltype(models_.octant)::Contexts contexts;
    contexts.ways[0] = (((neighbourClass(neighbours) * 4 + known_classes[known]) * 3 +
                         occupied_classes[occupied]) *
                            9 +
                        candidateClass(found, left)) *
                           2 +
                       is_i_frame_;
    if constexpr (CodingT::is_mixing) {
      contexts.ways[1] = (upTo(neighbours, 23) * 9 + known) * 9 + occupied;
      contexts.ways[2] =
          ((block.activity * 8u + octant) * 10 + upTo(neighbours, 9)) * 8 +
          upTo(found, 3) * 2 + is_i_frame_;
      contexts.weight_set = found_class * 2 + is_i_frame_;
    }
    return coding.code(
        models_.octant, contexts, (block.target >> (8 * octant) & 0xff) != 0);
  }

  /** \brief Codes which cells of a new block's octant are voxels, of which there is one;
   * what is found counts as a neighbour of what comes. */
  void
  codeManyCells(CodingT& coding, Block& block, unsigned int octant)
  {
    std::uint64_t cells = block.unknown & std::uint64_t{0xff} << (8 * octant);
    std::uint32_t found = 0;
    for (std::uint32_t left = octantCount(cells, octant); cells != 0;
         cells &= cells - 1) {
      --left;
      const unsigned int cell = lowestCell(cells);
      const bool is_implied = left == 0 && found == 0;
      if (!is_implied &&
          !codeIsCellNew(coding, block, cell, block.full.of(cell), found, left))
        continue;
      ++found;
      block.occupied |= std::uint64_t{1} << cell;
      block.full = countNeighbours(block.occupied, block.neighbours);
    }
  }

  /** \brief Codes which cells of a known block's octant are new voxels, of which there is
   * one: those with the most neighbours first, and after each that is one it is said
   * whether there is another one. */
  void
  codeFewCells(CodingT& coding, Block& block, unsigned int octant)
  {
    const std::uint64_t unknown = block.unknown & std::uint64_t{0xff} << (8 * octant);
    std::uint64_t cells_left = unknown;
    std::uint32_t found = 0;
    bool is_one_left = true;
    for (std::uint32_t neighbours = 7; neighbours-- > 0;)
      for (std::uint64_t cells = unknown & block.full.cellsWith(neighbours); cells != 0;
           cells &= cells - 1) {
        const std::uint64_t cell_bit = cells & (~cells + 1);
        cells_left &= ~cell_bit;
        const std::uint32_t left = octantCount(cells_left, octant);
        const bool is_implied = is_one_left && left == 0;
        if (!is_implied &&
            !codeIsCellNew(coding, block, lowestCell(cells), neighbours, found, left))
          continue;
        ++found;
        block.occupied |= cell_bit;
        if (left == 0)
          return;
        is_one_left = coding.code(models_.more_cells,
                                  {{upTo(found, 4) * 8 - 8 + upTo(left - 1, 7)}},
                                  (block.target & cells_left) != 0);
        if (!is_one_left)
          return;
      }
  }

  bool
  codeIsCellNew(CodingT& coding,
                const Block& block,
                unsigned int cell,
                std::uint32_t neighbours,
                std::uint32_t found,
                std::uint32_t left)
  {
    const std::uint32_t empty = block.empty.of(cell);
    const std::uint32_t candidate =
        found == 0 ? 7 - upTo(left, 7) : 3 + 4 * upTo(found, 2) + upTo(left, 3);
    typename decltype(models_.cell)::Contexts contexts;
    contexts.ways[0] =
        ((neighbours * 15 + candidate) * 2 + is_i_frame_) * 4 + upTo(empty, 3);
    if constexpr (CodingT::is_mixing) {
      const auto octant_mask =
          static_cast<std::uint32_t>(block.occupied >> (cell & ~7u) & 0xff);
      contexts.ways[1] = octant_mask * 8 + (cell & 7);
      contexts.ways[2] =
          facePattern(block, cell) * 28 + upTo(found, 3) * 7 + upTo(empty, 6);
      contexts.ways[3] =
          ((block.activity * 7u + neighbours) * 8 + upTo(left, 7)) * 2 + is_i_frame_;
      contexts.weight_set = neighbours * 2 + is_i_frame_;
    }
    return coding.code(models_.cell, contexts, (block.target >> cell & 1) != 0);
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
