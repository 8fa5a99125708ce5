#include "voxelizing/sorted_voxels.h"

#include "bytes/reserve_ahead.h"
#include "voxelizing/radix_sort.h"

#include <type_traits>

namespace pcl_ext {
namespace io {

void
SortedVoxels::clear(std::size_t expected, bool keeps_handles, bool keeps_colours)
{
  keeps_handles_ = keeps_handles;
  keeps_points_ = keeps_handles || keeps_colours;
  points_.clear();
  point_keys_.clear();
  if (keeps_points_)
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
  // Written by index, as push_back takes longer than the rest.
  const std::size_t first = keeps_points_ ? points_.size() : point_keys_.size();
  if (!keeps_points_) {
    point_keys_.resize(first + placed.count);
    std::uint64_t* const keys = point_keys_.data() + first;
    for (std::size_t i = 0; i < placed.count; ++i)
      keys[i] = key_of(i);
    return;
  }
  points_.resize(first + placed.count);
  Point* const points = points_.data() + first;
  for (std::size_t i = 0; i < placed.count; ++i) {
    added[i] = first + i;
    points[i] = {key_of(i), static_cast<std::uint32_t>(first + i), 0};
  }
}

void
SortedVoxels::addColours(const std::uint32_t* colours,
                         const std::size_t* added,
                         std::size_t count)
{
  for (std::size_t i = 0; i < count; ++i)
    points_[added[i]].colour = colours[i];
}

void
SortedVoxels::writeVoxels(std::vector<std::uint64_t>& keys,
                          std::vector<std::uint32_t>& counts)
{
  if (keeps_points_) {
    radixSort(points_, spare_points_, usedBits(points_));
    if (keeps_handles_)
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
  reserveAhead(keys, voxels);
  reserveAhead(counts, voxels);
  keys.resize(voxels);
  counts.resize(voxels);
  occupied_blocks_ = 0;
  std::size_t begun = 0; // voxels
  std::size_t first = 0; // point of the last one
  std::uint64_t last = sorted.empty() ? 0 : ~keyOf(sorted.front());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    // Without a branch, which would be mispredicted: written again at each point.
    const std::uint64_t key = keyOf(sorted[i]);
    const std::uint64_t difference = key ^ last;
    last = key;
    begun += difference != 0 ? 1 : 0;
    first = difference != 0 ? i : first;
    occupied_blocks_ += difference >> 6 != 0 ? 1 : 0;
    keys[begun - 1] = key;
    counts[begun - 1] = static_cast<std::uint32_t>(i + 1 - first);
    if constexpr (std::is_same_v<EntryT, Point>)
      if (keeps_handles_)
        voxel_of_[sorted[i].added] = static_cast<std::uint32_t>(begun - 1);
  }
}

} // namespace io
} // namespace pcl_ext
