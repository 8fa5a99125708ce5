#pragma once

#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Looks up the numbers of the face neighbours of a voxel that are coded before it:
 * the lower one on each axis. */
class IntensityNeighbours {
public:
  /** \brief Classes are below this. */
  static constexpr std::uint32_t class_count = 12;

  /** \param[in] frame blocks of the frame
   * \param[in] levels octree levels above the blocks
   * \param[in,out] directory scratch memory
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
    block_ = block;
    for (std::size_t face = 0; face < lower_faces; ++face) {
      std::uint64_t key = 0;
      around_[face] = neighbourBlock(frame_.keys[block], face, levels_, key)
                          ? directory_.find(key)
                          : BlockDirectory::not_found;
    }
  }

  /** \brief Class of the average number of a cell's lower neighbours; 0 if it has none.
   * \param[in] cell of the block
   * \param[in] numbers of the frame's voxels, of which those before this one are coded
   */
  std::uint32_t
  classOf(unsigned int cell, const std::vector<std::uint16_t>& numbers) const
  {
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
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
      if ((mask & bit) == 0)
        continue;
      sum += numbers[frame_.first_voxels[block] + bitCount(mask & (bit - 1))];
      ++count;
    }
    if (count == 0)
      return 0;
    constexpr std::array<std::uint16_t, class_count - 2> ends = {
        16, 24, 32, 40, 48, 64, 80, 112, 160, 256};
    const std::uint32_t average = 16 * sum / count;
    return static_cast<std::uint32_t>(
        1 + (std::lower_bound(ends.begin(), ends.end(), average) - ends.begin()));
  }

private:
  static constexpr std::size_t lower_faces = 3;

  const BlockList& frame_;
  unsigned int levels_;
  BlockDirectory& directory_;
  std::size_t block_ = 0;
  std::array<std::uint32_t, lower_faces> around_{};
};

} // namespace context
} // namespace io
} // namespace pcl_ext
