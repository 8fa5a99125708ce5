#include "codec/supplement/cells.h"

#include "simd/bit_operations.h"

#include <cstddef>

namespace pcl_ext {
namespace io {
namespace supplement {

namespace {

std::size_t
countCells(const std::vector<std::uint64_t>& keys, unsigned int levels)
{
  const unsigned int shift = 3 * levels;
  std::size_t count = keys.empty() ? 0 : 1;
  for (std::size_t i = 1; i < keys.size(); ++i)
    count += isNotZero((keys[i] ^ keys[i - 1]) >> shift);
  return count;
}

} // namespace

unsigned int
chooseRefinement(const VoxelFrame& frame)
{
  constexpr double largest_edge = 0.005;
  constexpr std::size_t least_voxels = 1024;
  const std::size_t count = frame.size();
  // On a surface that is sampled densely enough a branch has three or four voxels.
  if (frame.grid.resolution > largest_edge || count < least_voxels ||
      5 * countCells(frame.keys, 1) < 4 * count)
    return 0;
  // Smaller cells take fewer bytes, and more time where many levels are above them.
  constexpr double smallest_edge_of_few_levels = 0.001;
  const std::size_t halves_of_voxels_in_a_cell =
      frame.grid.resolution < smallest_edge_of_few_levels ? 8 : 3;
  unsigned int levels = 2;
  while (levels + 1 < frame.grid.depth &&
         halves_of_voxels_in_a_cell * countCells(frame.keys, levels) > 2 * count)
    ++levels;
  return levels < frame.grid.depth ? levels : 0;
}

void
cellsOf(const std::vector<std::uint64_t>& keys,
        unsigned int levels,
        std::vector<std::uint64_t>& cells)
{
  const unsigned int shift = 3 * levels;
  cells.resize(keys.size());
  if (keys.empty())
    return;
  std::uint64_t last = keys.front() >> shift;
  cells[0] = last;
  std::size_t count = 1;
  for (const std::uint64_t key : keys) {
    // Written in any case, and again if it is the same one, without a branch.
    const std::uint64_t cell = key >> shift;
    count += cell != last ? 1 : 0;
    cells[count - 1] = cell;
    last = cell;
  }
  cells.resize(count);
}

} // namespace supplement
} // namespace io
} // namespace pcl_ext
