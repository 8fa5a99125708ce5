#pragma once

#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Finds the face neighbours of voxels that come before them in Morton order: those
 * below them on each axis. */
class LowerNeighbours {
public:
  /** \brief Looks in a frame.
   * \param[in] frame its blocks
   * \param[in] levels octree levels above the blocks
   * \param[in] directory memory for one of the blocks
   */
  LowerNeighbours(const BlockList& frame,
                  unsigned int levels,
                  BlockDirectory& directory)
  : frame_(frame), levels_(levels), directory_(directory)
  {}

  void
  begin()
  {
    directory_.assign(frame_.keys);
  }

  /** \brief Selects a block of the frame. */
  void
  moveTo(std::size_t block)
  {
    block_ = block;
    for (std::size_t face = 0; face < lower_faces; ++face) {
      std::uint64_t key = 0;
      around_[face] = neighbourBlock(frame_.keys[block], face, levels_, key)
                          ? directory_.find(key)
                          : BlockDirectory::not_found;
    }
  }

  /** \brief Calls a function with the index of each lower neighbour of a cell's voxel.
   * \param[in] cell of the block
   */
  template <typename VisitT>
  void
  visit(unsigned int cell, VisitT&& visit_voxel) const
  {
    for (std::size_t face = 0; face < lower_faces; ++face) {
      const unsigned int low = 1u << (2 - face);
      const bool is_here = (cell & (low | low << 3)) != 0;
      const std::size_t block = is_here ? block_ : around_[face];
      if (block == BlockDirectory::not_found)
        continue;
      // One down on the axis: 3 -> 2, 2 -> 1, 1 -> 0, and 0 -> 3 of the next block.
      const unsigned int other = (cell & low) != 0 ? cell - low : cell ^ low ^ low << 3;
      const std::uint64_t bit = std::uint64_t{1} << other;
      const std::uint64_t mask = frame_.masks[block];
      if ((mask & bit) != 0)
        visit_voxel(std::size_t{frame_.first_voxels[block]} +
                    bitCount(mask & (bit - 1)));
    }
  }

private:
  static constexpr std::size_t lower_faces = 3;

  const BlockList& frame_;
  unsigned int levels_;
  BlockDirectory& directory_;
  std::size_t block_ = 0;
  std::array<std::uint32_t, lower_faces> around_{};
};

} // namespace io
} // namespace pcl_ext
