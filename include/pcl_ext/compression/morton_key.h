#pragma once

#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Bits a Morton key holds for each axis, and so the depth of the deepest grid.
 */
constexpr unsigned int max_grid_depth = 21;

/** \brief Position of a voxel within its grid: x, y, z count voxels from the grid's
 * lower corner, each below 2^depth of the grid. */
struct VoxelPosition {
  std::uint32_t x;
  std::uint32_t y;
  std::uint32_t z;
};

/** \brief Spreads the low 21 bits of a number so that two zero bits follow each. */
constexpr std::uint64_t
spreadBits(std::uint64_t bits)
{
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  bits = (bits | bits << 2) & 0x1249249249249249;
  return bits;
}

/** \brief Inverse of spreadBits; the other bits are ignored. */
constexpr std::uint32_t
gatherBits(std::uint64_t bits)
{
  bits &= 0x1249249249249249;
  bits = (bits | bits >> 2) & 0x10c30c30c30c30c3;
  bits = (bits | bits >> 4) & 0x100f00f00f00f00f;
  bits = (bits | bits >> 8) & 0x001f0000ff0000ff;
  bits = (bits | bits >> 16) & 0x001f00000000ffff;
  bits = (bits | bits >> 32) & 0x1fffff;
  return static_cast<std::uint32_t>(bits);
}

/** \brief Morton key of a position: three bits a level, x the highest of each three, so
 * that three bits are PCL's child index and key order is PCL's order of serialization.
 */
constexpr std::uint64_t
mortonKey(const VoxelPosition& position)
{
  return spreadBits(position.x) << 2 | spreadBits(position.y) << 1 |
         spreadBits(position.z);
}

/** \brief Inverse of mortonKey. */
constexpr VoxelPosition
voxelPosition(std::uint64_t morton_key)
{
  return {
      gatherBits(morton_key >> 2), gatherBits(morton_key >> 1), gatherBits(morton_key)};
}

} // namespace io
} // namespace pcl_ext
