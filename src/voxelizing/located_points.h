// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Position of a voxel in a grid: a block of 4 x 4 x 4 voxels and a voxel in
 * it. */
struct BlockVoxel {
  static constexpr unsigned int axis_bits = max_grid_depth - 2;

  std::uint64_t block; ///< x, y, z of the block, 19 bits each, x the highest
  std::uint32_t voxel; ///< x, y, z within the block, 2 bits each, x the highest
};

/** \brief The voxels of some points of a cloud, in the order of the points. */
struct LocatedPoints {
  static constexpr std::size_t capacity = 256;

  std::size_t count = 0;
  std::array<std::uint64_t, capacity> blocks; ///< as in BlockVoxel
  std::array<std::uint32_t, capacity> voxels; ///< as in BlockVoxel
  std::array<std::size_t, capacity> points;   ///< indices in the cloud

  // Only of clouds that have them.
  std::array<float, capacity> intensities;
  std::array<std::uint32_t, capacity> colours; ///< as of pcl::PointXYZRGB

  /** \brief Appends a point whose voxel was written at or past the end.
   * \param[in] index where it was written
   * \param[in] point its index in the cloud
   */
  void
  moveToEnd(std::size_t index, std::size_t point)
  {
    blocks[count] = blocks[index];
    voxels[count] = voxels[index];
    points[count] = point;
    ++count;
  }

  /** \brief Appends eight points whose voxels were written at or past the end.
   * \param[in] index where the first was written
   * \param[in] point index of the first in the cloud
   */
  void
  moveEightToEnd(std::size_t index, std::size_t point)
  {
    if (index != count) {
      // By way of other memory, as source and target may overlap.
      std::array<std::uint64_t, 8> eight_blocks;
      std::array<std::uint32_t, 8> eight_voxels;
      std::memcpy(eight_blocks.data(), &blocks[index], sizeof(eight_blocks));
      std::memcpy(eight_voxels.data(), &voxels[index], sizeof(eight_voxels));
      std::memcpy(&blocks[count], eight_blocks.data(), sizeof(eight_blocks));
      std::memcpy(&voxels[count], eight_voxels.data(), sizeof(eight_voxels));
    }
    for (std::size_t i = 0; i < 8; ++i)
      points[count + i] = point + i;
    count += 8;
  }
};

/** \brief Block and voxel of a position in the grid. */
inline BlockVoxel
blockVoxelOf(const VoxelPosition& position)
{
  return {std::uint64_t{position.x >> 2} << 2 * BlockVoxel::axis_bits |
              std::uint64_t{position.y >> 2} << BlockVoxel::axis_bits | position.z >> 2,
          (position.x & 3) << 4 | (position.y & 3) << 2 | (position.z & 3)};
}

/** \brief Morton key of a block: the key of its voxels without the lowest 6 bits. */
constexpr std::uint64_t
mortonKeyOfBlock(std::uint64_t block)
{
  constexpr std::uint64_t mask = (std::uint64_t{1} << BlockVoxel::axis_bits) - 1;
  return mortonKey({static_cast<std::uint32_t>(block >> 2 * BlockVoxel::axis_bits),
                    static_cast<std::uint32_t>(block >> BlockVoxel::axis_bits & mask),
                    static_cast<std::uint32_t>(block & mask)});
}

/** \brief Lowest 6 bits of the Morton key of each voxel of a block. */
inline constexpr std::array<std::uint8_t, 64> morton_order = [] {
  std::array<std::uint8_t, 64> order{};
  for (std::uint32_t voxel = 0; voxel < 64; ++voxel)
    order[voxel] =
        static_cast<std::uint8_t>(mortonKey({voxel >> 4, voxel >> 2 & 3, voxel & 3}));
  return order;
}();

/** \brief Morton key of a voxel. */
constexpr std::uint64_t
mortonKey(const BlockVoxel& voxel)
{
  return mortonKeyOfBlock(voxel.block) << 6 | morton_order[voxel.voxel];
}

} // namespace pcl_ext::PCL_EXT_ABI::io
