#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace io {

namespace {

bool
isGrid(const VoxelGrid& grid)
{
  return grid.resolution >= smallest_resolution &&
         grid.resolution <= largest_resolution && grid.depth >= 1 &&
         grid.depth <= max_grid_depth &&
         std::all_of(grid.anchor.begin(), grid.anchor.end(), [](double coordinate) {
           return std::isfinite(coordinate);
         });
}

bool
isScale(const IntensityScale& scale)
{
  return std::isfinite(scale.offset) && std::isfinite(scale.step) &&
         scale.step > 0.0f && scale.bits >= 1 && scale.bits <= 16 &&
         (scale.companded_range == 0 || (scale.companded_range > scale.maxSymbol() &&
                                         scale.companded_range <= 65535));
}

} // namespace

bool
isConsistent(const VoxelFrame& frame)
{
  if (!isGrid(frame.grid) || !isScale(frame.intensity_scale) ||
      (frame.depth_model && !isConsistent(*frame.depth_model)) ||
      frame.keys.size() != frame.intensities.size())
    return false;
  if (frame.keys.empty())
    return true;
  const std::uint64_t key_end = std::uint64_t{1} << (3 * frame.grid.depth);
  const bool ascends =
      std::adjacent_find(frame.keys.begin(),
                         frame.keys.end(),
                         [](std::uint64_t first, std::uint64_t second) {
                           return first >= second;
                         }) == frame.keys.end();
  const std::uint32_t max_symbol = frame.intensity_scale.maxSymbol();
  return ascends && frame.keys.back() < key_end &&
         *std::max_element(frame.intensities.begin(), frame.intensities.end()) <=
             max_symbol;
}

} // namespace io
} // namespace pcl_ext
