#include "codec/supplement/cells.h"

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
    count += (keys[i] ^ keys[i - 1]) >> shift != 0 ? 1 : 0;
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
  constexpr std::size_t voxels_in_a_cell = 4;
  unsigned int levels = 2;
  while (levels + 1 < frame.grid.depth &&
         voxels_in_a_cell * countCells(frame.keys, levels) > count)
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
  std::size_t count = 0;
  for (const std::uint64_t key : keys) {
    // Written in any case and counted if it is another one, without a branch.
    cells[count] = key >> shift;
    count += count == 0 || cells[count] != cells[count - 1] ? 1 : 0;
  }
  cells.resize(count);
}

} // namespace supplement
} // namespace io
} // namespace pcl_ext
