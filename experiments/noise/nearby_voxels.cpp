#include "nearby_voxels.h"

namespace pcl_ext {
namespace noise {

NearbyVoxels::Block&
NearbyVoxels::block(std::uint64_t number)
{
  std::unique_ptr<Block>& found = blocks_[number];
  if (!found) {
    found = std::make_unique<Block>();
    found->fill(never);
  }
  return *found;
}

void
NearbyVoxels::mark(const io::VoxelGrid& grid,
                   const std::vector<std::uint64_t>& keys,
                   std::int64_t time)
{
  // Neighbours are mostly in the block of the one before.
  std::uint64_t number = 0;
  Block* last = nullptr;
  for (const std::uint64_t key : keys)
    forEachNearby(grid, key, [&](std::uint64_t near) {
      if (last == nullptr || near >> block_bits != number) {
        number = near >> block_bits;
        last = &block(number);
      }
      (*last)[near & (last->size() - 1)] = time;
    });
}

std::int64_t
NearbyVoxels::lastTime(std::uint64_t key) const
{
  const auto found = blocks_.find(key >> block_bits);
  return found == blocks_.end() ? never
                                : (*found->second)[key & (found->second->size() - 1)];
}

} // namespace noise
} // namespace pcl_ext
