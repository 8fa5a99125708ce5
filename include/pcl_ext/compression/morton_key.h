#pragma once

#include <array>
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

/** \brief Morton key of a position: three bits a level, x the highest of each three, so
 * that three bits are PCL's child index and key order is PCL's order of serialization.
 */
constexpr std::uint64_t
mortonKey(const VoxelPosition& position)
{
  return spreadBits(position.x) << 2 | spreadBits(position.y) << 1 |
         spreadBits(position.z);
}

namespace detail {

/** \brief For the nine bits of three levels of a Morton key three bits of x, then of y,
 * then of z, x the lowest. */
constexpr std::array<std::uint16_t, 512>
makeAxisBits()
{
  std::array<std::uint16_t, 512> axis_bits{};
  for (unsigned int key_bits = 0; key_bits < 512; ++key_bits) {
    unsigned int sorted = 0;
    for (unsigned int level = 0; level < 3; ++level)
      for (unsigned int axis = 0; axis < 3; ++axis)
        sorted |= (key_bits >> (3 * level + 2 - axis) & 1u) << (3 * axis + level);
    axis_bits[key_bits] = static_cast<std::uint16_t>(sorted);
  }
  return axis_bits;
}

inline constexpr std::array<std::uint16_t, 512> axis_bits = makeAxisBits();

} // namespace detail

/** \brief Inverse of mortonKey; three levels at a time. */
constexpr VoxelPosition
voxelPosition(std::uint64_t morton_key)
{
  VoxelPosition position{0, 0, 0};
  for (unsigned int level = 0; morton_key != 0; morton_key >>= 9, level += 3) {
    const std::uint32_t bits = detail::axis_bits[morton_key & 511];
    position.x |= (bits & 7) << level;
    position.y |= (bits >> 3 & 7) << level;
    position.z |= (bits >> 6) << level;
  }
  return position;
}

} // namespace io
} // namespace pcl_ext
