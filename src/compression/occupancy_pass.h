#pragma once

#include "block_directory.h"
#include "context_models.h"
#include "payload_context.h"
#include "voxel_block.h"
#include "voxel_history.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief What is learnt about occupancy (doc/bitstream.md, "Occupancy"). */
struct OccupancyModels {
  DecisionModel<1> known_voxel{{1920}, 6}; ///< a known voxel is occupied
  DecisionModel<1> branch{{144}, 5};       ///< new voxels are in a branch above blocks
  DecisionModel<1> known_block{{96}, 5};   ///< new voxels are in a block of the history
  DecisionModel<1> new_block{{24}, 5};     ///< new voxels are in another block
  DecisionModel<1> octant{{432}, 5};       ///< new voxels are in an octant of a block
  DecisionModel<1> cell{{672}, 5};         ///< a cell is a new voxel
};

/** \brief Blocks of a frame while they are coded; kept from frame to frame so that
 * their memory is reused. */
struct OccupancyWorkspace {
  /** \brief Occupied cells: of the blocks of the history, then of the new blocks. */
  std::vector<std::uint64_t> occupied;
  std::vector<std::uint64_t> new_keys; ///< of the new blocks, ascending
  BlockDirectory directory;            ///< into `occupied`

  // The encoder's: blocks with new voxels, ascending, and their new voxels.
  std::vector<std::uint64_t> target_keys;
  std::vector<std::uint64_t> target_masks;
};

/** \brief Codes which voxels are occupied, for either direction.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class OccupancyPass {
public:
  /** \brief A pass over one frame.
   * \param[in] context what both sides know before the frame
   * \param[in] max_voxels where decoding gives up
   */
  OccupancyPass(CodingT& coding,
                OccupancyModels& models,
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

  /** \brief Codes the frame.
   * \param[in] frame its blocks; the decoder gives null
   * \return false if what was decoded is no frame of at most that many voxels
   */
  bool
  run(const BlockList* frame)
  {
    prepare(frame);
    codeKnownVoxels();
    const bool has_new_voxels = coding_.codeRaw(!work_.target_keys.empty());
    Range all{0, 0, history_.blocks().size(), 0, work_.target_keys.size()};
    return !has_new_voxels ||
           (levels_ == 0 ? codeBlock(all) : codeBranch(all, levels_));
  }

  /** \brief The blocks that were coded, ascending. */
  void
  collect(BlockList& frame) const
  {
    frame.clear();
    const std::vector<HistoryBlock>& known = history_.blocks();
    std::size_t old = 0;
    std::size_t added = 0;
    std::uint32_t voxels = 0;
    while (old < known.size() || added < work_.new_keys.size()) {
      const bool is_old =
          added == work_.new_keys.size() ||
          (old < known.size() && known[old].key < work_.new_keys[added]);
      const std::uint64_t key = is_old ? known[old].key : work_.new_keys[added];
      const std::uint64_t mask = work_.occupied[is_old ? old : known.size() + added];
      (is_old ? old : added) += 1;
      if (mask == 0)
        continue;
      frame.append(key, mask, voxels);
      voxels += cellCount(mask);
    }
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

  void
  prepare(const BlockList* frame)
  {
    const std::vector<HistoryBlock>& known = history_.blocks();
    work_.new_keys.clear();
    work_.target_keys.clear();
    work_.target_masks.clear();
    work_.occupied.assign(known.size(), 0);
    work_.directory.clear(known.size() + (frame != nullptr ? frame->size() : 0));
    for (std::size_t i = 0; i < known.size(); ++i)
      work_.directory.insert(known[i].key, static_cast<std::uint32_t>(i));
    if (frame == nullptr)
      return;
    std::size_t old = 0;
    for (std::size_t i = 0; i < frame->size(); ++i) {
      while (old < known.size() && known[old].key < frame->keys[i])
        ++old;
      std::uint64_t new_voxels = frame->masks[i];
      if (old < known.size() && known[old].key == frame->keys[i]) {
        work_.occupied[old] = frame->masks[i] & known[old].known;
        new_voxels &= ~known[old].known;
      }
      if (new_voxels != 0) {
        work_.target_keys.push_back(frame->keys[i]);
        work_.target_masks.push_back(new_voxels);
      }
    }
  }

  void
  codeKnownVoxels()
  {
    const std::vector<HistoryBlock>& known = history_.blocks();
    for (std::size_t i = 0; i < known.size(); ++i) {
      const std::uint64_t target = work_.occupied[i];
      std::uint64_t occupied = 0;
      std::size_t record = known[i].first_record;
      for (std::uint64_t cells = known[i].known; cells != 0; cells &= cells - 1) {
        const std::uint64_t cell = cells & (~cells + 1);
        if (coding_.code(
                models_.known_voxel, {knownContext(record++)}, (target & cell) != 0))
          occupied |= cell;
      }
      work_.occupied[i] = occupied;
      voxels_ += cellCount(occupied);
    }
  }

  /** \brief Context of a known voxel: how often it was occupied, its last two frames,
   * how long it is known, and how many points it used to hold. */
  std::uint32_t
  knownContext(std::size_t record) const
  {
    const VoxelHistory::Records& records = history_.records();
    const std::uint32_t mean = static_cast<std::uint32_t>(records.mean[record])
                               << (4 - history_.fractionBits());
    const std::uint32_t age = records.age[record];
    const std::uint32_t age_class = age < 2 ? 0 : age < 5 ? 1 : 2;
    const std::uint32_t mean_class = mean <= 20  ? 0
                                     : mean < 32 ? 1
                                     : mean < 48 ? 2
                                     : mean < 80 ? 3
                                                 : 4;
    return (((records.probability[record] >> 11) * 4u + (records.recent[record] & 3u)) *
                3 +
            age_class) *
               5 +
           mean_class;
  }

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
    return coding_.code(models_.branch, {context}, has_new_voxels);
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
      return coding_.code(models_.known_block, {context}, has_new_voxels);
    }
    const auto child = static_cast<unsigned int>(part.key & 7);
    const std::uint32_t neighbours = (present >> (child ^ 1) & 1) +
                                     (present >> (child ^ 2) & 1) +
                                     (present >> (child ^ 4) & 1);
    const std::uint32_t context = (neighbours * 3 + part_class) * 2 + is_i_frame_;
    return coding_.code(models_.new_block, {context}, has_new_voxels);
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
    }
    if (block.unknown == 0)
      return false;
    findNeighbours(range.key, block);
    const std::uint64_t before = block.occupied;
    codeOctants(block);
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
  codeOctants(Block& block)
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
          codeIsOctantNew(block, octant, octants, (block.target & cells) != 0);
      if (!has_new_voxels)
        continue;
      ++octants;
      codeCells(block, block.unknown & cells);
    }
  }

  bool
  codeIsOctantNew(const Block& block,
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
    const std::uint32_t context =
        (((neighbour_class * 4 + known_class) * 3 + occupied_class) * 3 +
         upTo(octants, 2)) *
            2 +
        is_i_frame_;
    return coding_.code(models_.octant, {context}, has_new_voxels);
  }

  /** \brief Codes which cells of an octant are new voxels, of which there is one. */
  void
  codeCells(Block& block, std::uint64_t cells)
  {
    std::uint32_t found = 0;
    std::uint32_t left = cellCount(cells);
    for (; cells != 0; cells &= cells - 1) {
      --left;
      const std::uint64_t cell_bit = cells & (~cells + 1);
      const unsigned int cell = lowestCell(cells);
      const std::uint32_t context =
          (((block.full.of(cell) * 3 + upTo(found, 2)) * 4 + upTo(left, 3)) * 2 +
           is_i_frame_) *
              4 +
          upTo(block.empty.of(cell), 3);
      const bool is_implied = left == 0 && found == 0;
      if (!is_implied &&
          !coding_.code(models_.cell, {context}, (block.target & cell_bit) != 0))
        continue;
      ++found;
      block.occupied |= cell_bit;
      block.full = countNeighbours(block.occupied, block.neighbours);
    }
  }

  CodingT& coding_;
  OccupancyModels& models_;
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
