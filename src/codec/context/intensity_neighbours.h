#pragma once

#include "simd/bit_operations.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief The face neighbours of a voxel whose number is coded: all voxels of the frame are
 * known, and the numbers of those before it, which are the lower ones on each axis. */
class IntensityNeighbours {
public:
  /** \brief Shapes are below this. */
  static constexpr std::uint32_t shape_count = 27;

  /** \brief Looks in a frame.
   * \param[in] frame its blocks
   * \param[in] levels octree levels above the blocks
   * \param[in] directory memory for one of the blocks
   */
  IntensityNeighbours(const BlockList& frame,
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
    const std::uint64_t mask = frame_.masks[block];
    here_ = {mask, frame_.first_voxels[block]};
    for (std::size_t face = 0; face < face_count; ++face) {
      const std::size_t other = neighbourOf(block, face);
      const Block neighbour =
          other == not_found ? Block{0, 0}
                             : Block{frame_.masks[other], frame_.first_voxels[other]};
      if (face < lower_faces)
        lower_[face] = neighbour;
      across_[face] = occupiedAcross(mask, neighbour.mask, face);
    }
  }

  /** \brief On which axes a cell has neighbours: 9 times their number, 0..2, on x, 3 times
   * that on y, and that on z. */
  std::uint32_t
  shapeOf(unsigned int cell) const
  {
    const auto onAxis = [&](std::size_t axis) {
      return static_cast<std::uint32_t>((across_[axis] >> cell & 1) +
                                        (across_[axis + 3] >> cell & 1));
    };
    return (onAxis(0) * 3 + onAxis(1)) * 3 + onAxis(2);
  }

  /** \brief Average number of a cell's lower neighbours, in sixteenths.
   * \param[in] cell of the block
   * \param[in] numbers of the frame's voxels, of which those before this one are coded
   * \param[in] otherwise returned if it has none
   */
  std::uint32_t
  averageOf(unsigned int cell,
            const std::vector<std::uint16_t>& numbers,
            std::uint32_t otherwise) const
  {
    // Without branches on what is occupied, which would be mispredicted.
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
    for (std::size_t face = 0; face < lower_faces; ++face) {
      const unsigned int low = 1u << (2 - face);
      const bool is_here = (cell & (low | low << 3)) != 0;
      const std::uint64_t mask = is_here ? here_.mask : lower_[face].mask;
      const std::size_t first = is_here ? here_.first_voxel : lower_[face].first_voxel;
      // One down on the axis: 3 -> 2, 2 -> 1, 1 -> 0, and 0 -> 3 of the next block.
      const unsigned int other = (cell & low) != 0 ? cell - low : cell ^ low ^ low << 3;
      const auto is_there = static_cast<std::uint32_t>(mask >> other & 1);
      const std::size_t voxel =
          first + bitCount(mask & ((std::uint64_t{1} << other) - 1));
      sum += numbers[voxel * is_there] * is_there;
      count += is_there;
    }
    return count == 0 ? otherwise : count == 3 ? 16 * sum / 3 : 16 * sum >> (count - 1);
  }

private:
  static constexpr std::size_t lower_faces = 3;
  static constexpr std::size_t not_found = static_cast<std::size_t>(-1);

  struct Block {
    std::uint64_t mask;
    std::size_t first_voxel;
  };

  /** \brief Index of the block across a face, or not_found. */
  std::size_t
  neighbourOf(std::size_t block, std::size_t face) const
  {
    std::uint64_t key = 0;
    if (!neighbourBlock(frame_.keys[block], face, levels_, key))
      return not_found;
    // Parts of the same branch are next to each other.
    if ((key ^ frame_.keys[block]) < 8) {
      std::size_t other = block;
      if (face < lower_faces)
        while (other > 0 && frame_.keys[other] > key)
          --other;
      else
        while (other + 1 < frame_.size() && frame_.keys[other] < key)
          ++other;
      return frame_.keys[other] == key ? other : not_found;
    }
    const std::uint32_t found = directory_.find(key);
    return found == BlockDirectory::not_found ? not_found : found;
  }

  const BlockList& frame_;
  unsigned int levels_;
  BlockDirectory& directory_;
  // Of the selected block.
  Block here_{0, 0};
  std::array<Block, lower_faces> lower_{};
  std::array<std::uint64_t, face_count> across_{}; ///< cells with a neighbour there
};

} // namespace context
} // namespace io
} // namespace pcl_ext
