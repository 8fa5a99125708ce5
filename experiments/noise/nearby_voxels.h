/** \file
 * \brief When a voxel was last within one voxel of some others.
 */
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Calls a function for a voxel and its 26 neighbours, as far as they are within
 * the grid.
 * \param[in] visit callable as visit(key)
 */
template <typename VisitT>
void
forEachNearby(const io::VoxelGrid& grid, std::uint64_t key, const VisitT& visit)
{
  const io::VoxelPosition centre = io::voxelPosition(key);
  const auto size = static_cast<std::uint32_t>(grid.size());
  const auto isInside = [size](std::uint32_t at, std::uint32_t step) {
    return at + step >= 1 && at + step <= size;
  };
  for (std::uint32_t z = 0; z < 3; ++z)
    for (std::uint32_t y = 0; y < 3; ++y)
      for (std::uint32_t x = 0; x < 3; ++x)
        if (isInside(centre.x, x) && isInside(centre.y, y) && isInside(centre.z, z))
          visit(io::mortonKey({centre.x + x - 1, centre.y + y - 1, centre.z + z - 1}));
}

/** \brief For each voxel of a grid the last time at which a marked one was within one
 * voxel of it: itself or one of its 26 neighbours. */
class NearbyVoxels {
public:
  static constexpr std::int64_t never = -1'000'000;

  /** \brief Marks voxels.
   * \param[in] keys of the grid
   * \param[in] time not before an earlier one
   */
  void
  mark(const io::VoxelGrid& grid,
       const std::vector<std::uint64_t>& keys,
       std::int64_t time);

  /** \brief The last time, or \ref never. */
  std::int64_t
  lastTime(std::uint64_t key) const;

private:
  static constexpr unsigned int block_bits = 9; ///< blocks of 8 x 8 x 8 voxels
  using Block = std::array<std::int64_t, std::size_t{1} << block_bits>;

  Block&
  block(std::uint64_t number);

  std::unordered_map<std::uint64_t, std::unique_ptr<Block>> blocks_;
};

} // namespace noise
} // namespace pcl_ext
