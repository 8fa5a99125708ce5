#include "voxelizing/sorted_voxels.h"

#include "voxelizing/radix_sort.h"

namespace pcl_ext {
namespace io {

void
SortedVoxels::add(const PlacedPoints& placed, std::size_t* added)
{
  const std::size_t before = points_.size();
  points_.resize(before + placed.count);
  for (std::size_t i = 0; i < placed.count; ++i) {
    added[i] = before + i;
    points_[before + i] = {mortonKey(BlockPlace{placed.blocks[i], placed.voxels[i]}),
                           static_cast<std::uint32_t>(before + i)};
  }
}

void
SortedVoxels::writeVoxels(std::vector<std::uint64_t>& keys,
                          std::vector<std::uint32_t>& counts)
{
  radixSort(points_, spare_points_, usedBits(points_));
  voxel_of_.resize(points_.size());
  keys.clear();
  counts.clear();
  occupied_blocks_ = 0;
  for (std::size_t i = 0; i < points_.size();) {
    const std::uint64_t key = points_[i].key;
    const std::size_t first = i;
    for (; i < points_.size() && points_[i].key == key; ++i)
      voxel_of_[points_[i].added] = static_cast<std::uint32_t>(keys.size());
    occupied_blocks_ += keys.empty() || keys.back() >> 6 != key >> 6 ? 1 : 0;
    keys.push_back(key);
    counts.push_back(static_cast<std::uint32_t>(i - first));
  }
}

} // namespace io
} // namespace pcl_ext
