#pragma once

#include "codec/context/models.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief A number clamped to an upper bound, for contexts. */
constexpr std::uint32_t
upTo(std::uint32_t number, std::uint32_t highest)
{
  return std::min(number, highest);
}

/** \brief Context 0..8 of one of up to eight candidates, at least one of which is new. As
 * long as none was found it is 7 less the number of candidates left, at least 0, as the
 * probability rises with each that is not new; then 6 plus the number of those found, at
 * most 8. */
constexpr std::uint32_t
candidateClass(std::uint32_t found, std::uint32_t left)
{
  return found == 0 ? 7 - upTo(left, 7) : 6 + upTo(found, 2);
}

/** \brief A block while its new voxels are coded. */
struct NewVoxelBlock {
  std::uint64_t unknown = 0;  ///< cells without record
  std::uint64_t occupied = 0; ///< occupied cells: known ones, and new ones coded so far
  std::uint64_t target = 0;   ///< encoder only: all new cells
  NeighbourCounts empty;      ///< known, but empty neighbours of a cell in the block
  NeighbourCounts full;       ///< occupied neighbours of a cell
  std::uint8_t activity = 0;  ///< see HistoryBlock
  bool is_known = false;      ///< in the history
  std::array<std::uint64_t, face_count> neighbours{}; ///< occupied cells across faces
};

/** \brief Models of the new voxels of a block (doc/bitstream_context.md, "New
 * voxels in known blocks"). */
struct NewCellModels {
  explicit NewCellModels(bool is_mixing)
  : octant(is_mixing, 5, {1296, 1944, 5120}, 6)
  , more_octants(is_mixing, 5, {16})
  , cell(is_mixing, 5, {840, 2048, 1792, 896}, 14)
  , more_cells(is_mixing, 5, {32})
  {}

  DecisionModel<3> octant;       ///< an octant has new voxels
  DecisionModel<1> more_octants; ///< a further octant has new voxels
  DecisionModel<4> cell;         ///< a cell is a new voxel
  DecisionModel<1> more_cells;   ///< a further cell is a new voxel
};

/** \brief Codes which cells of a block, at least one, are new voxels, for either
 * direction.
 * \tparam CodingT SingleContextCoding or MixedContextCoding
 */
template <typename CodingT>
class NewCellPass {
public:
  NewCellPass(NewCellModels& models, bool is_i_frame)
  : models_(models), is_i_frame_(is_i_frame ? 1 : 0)
  {}

  /** \brief Codes the new voxels of a block by octants. In a known block octants with more
   * neighbours are coded first, and after each octant with new voxels, whether there is a
   * further one. */
  void
  run(CodingT& coding, NewVoxelBlock& block)
  {
    std::array<std::uint8_t, 6> octants_of_class{}; // masks
    std::uint32_t left = 0;
    for (unsigned int octant = 0; octant < 8; ++octant) {
      if ((block.unknown >> (8 * octant) & 0xff) == 0)
        continue;
      // In a new block, where most octants have voxels, all are in one class.
      const std::uint32_t octant_class =
          block.is_known ? neighbourClass(block.full.sum(octant)) : 0;
      octants_of_class[octant_class] |= static_cast<std::uint8_t>(1u << octant);
      ++left;
    }
    std::uint32_t found = 0;
    bool is_one_left = true; // an octant with new voxels that is not coded yet
    for (std::size_t octant_class = 6; octant_class-- > 0;)
      for (unsigned int octants = octants_of_class[octant_class]; octants != 0;
           octants &= octants - 1) {
        const unsigned int octant = lowestBit(octants);
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

private:
  /** \brief Class of an octant by the number of occupied neighbours of its cells. */
  static std::uint32_t
  neighbourClass(std::uint32_t neighbours)
  {
    constexpr std::array<std::uint8_t, 13> classes = {
        0, 1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4, 5};
    return classes[upTo(neighbours, 12)];
  }

  /** \brief Encoder only: whether an octant after the current one has new voxels. */
  static bool
  hasMoreOctants(const NewVoxelBlock& block,
                 unsigned int octants,
                 std::size_t octant_class,
                 const std::array<std::uint8_t, 6>& octants_of_class)
  {
    unsigned int behind = octants & (octants - 1);
    while (octant_class-- > 0)
      behind |= octants_of_class[octant_class];
    for (; behind != 0; behind &= behind - 1)
      if ((block.target >> (8 * lowestBit(behind)) & 0xff) != 0)
        return true;
    return false;
  }

  bool
  codeIsOctantNew(CodingT& coding,
                  const NewVoxelBlock& block,
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

  /** \brief Codes which cells of an octant of a new block, at least one, are voxels. Each
   * counts as a neighbour of the following ones. */
  void
  codeManyCells(CodingT& coding, NewVoxelBlock& block, unsigned int octant)
  {
    std::uint64_t cells = block.unknown & std::uint64_t{0xff} << (8 * octant);
    std::uint32_t found = 0;
    for (std::uint32_t left = octantCount(cells, octant); cells != 0;
         cells &= cells - 1) {
      --left;
      const unsigned int cell = lowestBit(cells);
      const bool is_implied = left == 0 && found == 0;
      if (!is_implied &&
          !codeIsCellNew(coding, block, cell, block.full.of(cell), found, left))
        continue;
      ++found;
      block.occupied |= std::uint64_t{1} << cell;
      block.full = countNeighbours(block.occupied, block.neighbours);
    }
  }

  /** \brief Codes which cells of an octant of a known block, at least one, are new voxels:
   * cells with more neighbours first, and after each new voxel, whether there is a further
   * one. */
  void
  codeFewCells(CodingT& coding, NewVoxelBlock& block, unsigned int octant)
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
            !codeIsCellNew(coding, block, lowestBit(cells), neighbours, found, left))
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
                const NewVoxelBlock& block,
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
  facePattern(const NewVoxelBlock& block, unsigned int cell)
  {
    std::uint32_t pattern = 0;
    for (std::size_t face = 0; face < face_count; ++face)
      pattern |=
          static_cast<std::uint32_t>(
              occupiedAcross(block.occupied, block.neighbours[face], face) >> cell & 1)
          << face;
    return pattern;
  }

  NewCellModels& models_;
  std::uint32_t is_i_frame_;
};

} // namespace context
} // namespace io
} // namespace pcl_ext
