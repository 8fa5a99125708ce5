#include "voxelizing/sorted_voxels.h"

#include "bytes/reserve_ahead.h"
#include "voxelizing/radix_sort.h"

#include <type_traits>

namespace pcl_ext {
namespace io {

void
SortedVoxels::clear(std::size_t expected, bool keeps_handles)
{
  keeps_handles_ = keeps_handles;
  points_.clear();
  point_keys_.clear();
  if (keeps_handles)
    reserveAhead(points_, expected);
  else
    reserveAhead(point_keys_, expected);
}

void
SortedVoxels::add(const PlacedPoints& placed, std::size_t* added)
{
  const auto key_of = [&](std::size_t i) {
    return mortonKey(BlockPlace{placed.blocks[i], placed.voxels[i]});
  };
  if (!keeps_handles_) {
    for (std::size_t i = 0; i < placed.count; ++i)
      point_keys_.push_back(key_of(i));
    return;
  }
  for (std::size_t i = 0; i < placed.count; ++i) {
    added[i] = points_.size();
    points_.push_back({key_of(i), static_cast<std::uint32_t>(points_.size())});
  }
}

void
SortedVoxels::writeVoxels(std::vector<std::uint64_t>& keys,
                          std::vector<std::uint32_t>& counts)
{
  if (keeps_handles_) {
    radixSort(points_, spare_points_, usedBits(points_));
    voxel_of_.resize(points_.size());
    writeSorted(points_, keys, counts);
  }
  else {
    radixSort(point_keys_, spare_keys_, usedBits(point_keys_));
    writeSorted(point_keys_, keys, counts);
  }
}

template <typename EntryT>
void
SortedVoxels::writeSorted(const std::vector<EntryT>& sorted,
                          std::vector<std::uint64_t>& keys,
                          std::vector<std::uint32_t>& counts)
{
  std::size_t voxels = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    voxels += i == 0 || keyOf(sorted[i]) != keyOf(sorted[i - 1]) ? 1 : 0;
  keys.clear();
  counts.clear();
  reserveAhead(keys, voxels);
  reserveAhead(counts, voxels);
  occupied_blocks_ = 0;
  for (std::size_t i = 0; i < sorted.size();) {
    const std::uint64_t key = keyOf(sorted[i]);
    const std::size_t first = i;
    for (; i < sorted.size() && keyOf(sorted[i]) == key; ++i)
      if constexpr (std::is_same_v<EntryT, Point>)
        voxel_of_[sorted[i].added] = static_cast<std::uint32_t>(keys.size());
    occupied_blocks_ += keys.empty() || keys.back() >> 6 != key >> 6 ? 1 : 0;
    keys.push_back(key);
    counts.push_back(static_cast<std::uint32_t>(i - first));
  }
}

} // namespace io
} // namespace pcl_ext
