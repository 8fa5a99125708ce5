// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/context/choices.h"
#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/models.h"
#include "simd/bit_operations.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Models of new voxels in tracked blocks (doc/bitstream_context.md, "New
 * voxels"). */
struct NewVoxelModels {
  /** \brief Classes of cells, by their neighbours.
   *
   *     neighbours in this frame             0   1   2   3 or more
   *     next three cells after a new voxel   12  13  14  15
   *     others, of 0 tracked neighbours      0   3   6   9
   *             of 1                         1   4   7   10
   *             of 2 or more                 2   5   8   11
   */
  static constexpr std::size_t cell_classes = 16;
  static constexpr std::size_t near_classes = 12; ///< the first of the next three cells
  /** \brief After the classes of cells: the block has no further new voxels. */
  static constexpr std::size_t end_of_block = cell_classes;
  using Cells = ChoiceModel<cell_classes + 1>;

  explicit NewVoxelModels(bool is_small)
  : block(is_small, 5, {8 * 4})
  , cell({2, 2, 2, 16, 16, 16, 128, 128, 128, 512, 512, 512, 2, 16, 128, 512, 256})
  {}

  DecisionModel<1> block; ///< a block of the history has new voxels
  Cells cell;             ///< which cell is the next of these
};

/** \brief Codes the voxels without a record in blocks of the history, for either
 * direction.
 * \tparam CodingT DecisionCoding
 */
template <typename CodingT>
class NewVoxelPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] frame its tracked voxels have been coded
   * \param[in] parameters of the frame
   * \param[in] max_voxels of the pass; a decoder fails where there are more
   */
  NewVoxelPass(CodingT& coding,
               NewVoxelModels& models,
               FrameBlocks& frame,
               const FrameParameters& parameters,
               std::size_t max_voxels)
  : coding_(coding)
  , models_(models)
  , frame_(frame)
  , tracked_(parameters.history.blocks())
  , grid_cells_(cellsInGrid(parameters.grid_depth))
  , max_voxels_(max_voxels)
  {}

  /** \brief Codes the new voxels.
   * \return false if there are more than max_voxels
   */
  bool
  run()
  {
    for (std::size_t i = 0; i < tracked_.size() && voxels_ <= max_voxels_; ++i) {
      const std::uint64_t open = grid_cells_ & ~tracked_[i].tracked;
      const std::uint64_t target = frame_.target_cells[i] & open;
      if (open != 0 &&
          coding_.code(models_.block, {{contextOf(tracked_[i])}}, target != 0))
        codeBlock(i, open, target);
    }
    return voxels_ <= max_voxels_;
  }

  /** \brief Number of new voxels so far. */
  std::size_t
  voxelCount() const
  {
    return voxels_;
  }

private:
  using Cells = NewVoxelModels::Cells;
  static constexpr std::size_t end_of_block = NewVoxelModels::end_of_block;

  /** \brief The cells of each class. */
  using CellClasses = std::array<std::uint64_t, NewVoxelModels::cell_classes>;

  static std::uint32_t
  contextOf(const HistoryBlock& block)
  {
    const unsigned int count = bitCount(block.tracked);
    const std::uint32_t tracked_class = count < 4    ? 0
                                        : count < 10 ? 1
                                        : count < 20 ? 2
                                                     : 3;
    return block.activity * 4u + tracked_class;
  }

  /** \brief Codes the new voxels of a block that has some, ascending.
   * \param[in] open cells that may be new voxels
   * \param[in] target encoder only: those that are
   */
  void
  codeBlock(std::size_t index, std::uint64_t open, std::uint64_t target)
  {
    std::array<std::uint64_t, face_count> now{};
    std::array<std::uint64_t, face_count> tracked{};
    for (std::size_t face = 0; face < face_count; ++face) {
      const std::uint32_t other = frame_.neighbours[index][face];
      if (other == BlockDirectory::not_found)
        continue;
      now[face] = frame_.blocks[other].present;
      tracked[face] = tracked_[other].tracked;
    }
    const NeighbourCounts tracked_counts =
        countNeighbours(tracked_[index].tracked, tracked);
    std::uint64_t& present = frame_.blocks[index].present;
    std::uint64_t last = 0; // new voxel, a mask
    while (open != 0) {
      const std::uint64_t near = (last << 4) - (last << 1);
      const CellClasses classes =
          classify(countNeighbours(present, now), tracked_counts, open, near);
      Cells::Counts counts;
      for (std::size_t i = 0; i < classes.size(); ++i)
        counts[i] = bitCount(classes[i]);
      counts[end_of_block] = last == 0 ? 0 : 1;
      Choice choice{end_of_block, 0};
      if (target != 0)
        choice = choiceOf(classes, target & (0 - target));
      choice = coding_.codeChoice(models_.cell, counts, choice);
      if (choice.alternative_class == end_of_block)
        return;
      last = cellAt(classes[choice.alternative_class], choice.index);
      present |= last;
      target &= ~last;
      open &= 0 - (last << 1);
      ++voxels_;
    }
  }

  /** \brief The open cells by class.
   * \param[in] now numbers of neighbours in this frame
   * \param[in] tracked numbers of neighbours that are tracked voxels
   * \param[in] near the next three cells after the last new voxel
   */
  static CellClasses
  classify(const NeighbourCounts& now,
           const NeighbourCounts& tracked,
           std::uint64_t open,
           std::uint64_t near)
  {
    const std::array<std::uint64_t, 4> by_now = {
        now.cellsWith(0),
        now.cellsWith(1),
        now.cellsWith(2),
        ~(now.cellsWith(0) | now.cellsWith(1) | now.cellsWith(2))};
    const std::uint64_t far = open & ~near;
    const std::array<std::uint64_t, 3> by_tracked = {
        far & tracked.cellsWith(0),
        far & tracked.cellsWith(1),
        far & ~(tracked.cellsWith(0) | tracked.cellsWith(1))};
    CellClasses classes;
    for (std::size_t i = 0; i < by_now.size(); ++i) {
      for (std::size_t j = 0; j < by_tracked.size(); ++j)
        classes[by_tracked.size() * i + j] = by_now[i] & by_tracked[j];
      classes[NewVoxelModels::near_classes + i] = by_now[i] & open & near;
    }
    return classes;
  }

  /** \brief The choice of a cell, given as a mask. */
  static Choice
  choiceOf(const CellClasses& classes, std::uint64_t cell)
  {
    std::size_t i = 0;
    while ((classes[i] & cell) == 0)
      ++i;
    return {i, bitCount(classes[i] & (cell - 1))};
  }

  /** \brief The index-th cell of some, as a mask. */
  static std::uint64_t
  cellAt(std::uint64_t cells, std::uint32_t index)
  {
    for (; index > 0; --index)
      cells &= cells - 1;
    return cells & (0 - cells);
  }

  CodingT& coding_;
  NewVoxelModels& models_;
  FrameBlocks& frame_;
  const std::vector<HistoryBlock>& tracked_;
  std::uint64_t grid_cells_;
  std::size_t max_voxels_;
  std::size_t voxels_ = 0;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
