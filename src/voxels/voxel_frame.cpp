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

/** \brief True if keys are strictly ascending and below an end of 2^63 at most. */
bool
areKeys(const std::vector<std::uint64_t>& keys, std::uint64_t end)
{
  // By differences, as SSE2 cannot compare 64 bits: the highest bit is set where one is
  // not above 0, if none of the keys has it.
  std::uint64_t differences = 0;
  std::uint64_t bits = keys[0];
  for (std::size_t i = 1; i < keys.size(); ++i) {
    differences |= keys[i] - keys[i - 1] - 1;
    bits |= keys[i];
  }
  return ((differences | bits) >> 63) == 0 && keys.back() < end;
}

/** \brief True if all symbols have so many bits. */
bool
areSymbols(const std::vector<std::uint16_t>& symbols, unsigned int bits)
{
  std::uint16_t all = 0;
  for (const std::uint16_t symbol : symbols)
    all = static_cast<std::uint16_t>(all | symbol);
  return all >> bits == 0;
}

} // namespace

bool
isConsistent(const VoxelFrame& frame)
{
  if (!isGrid(frame.grid) || !isScale(frame.intensity_scale) ||
      (frame.depth_model && !isConsistent(*frame.depth_model)) ||
      frame.keys.size() != frame.intensities.size())
    return false;
  return frame.keys.empty() ||
         (areKeys(frame.keys, std::uint64_t{1} << (3 * frame.grid.depth)) &&
          areSymbols(frame.intensities, frame.intensity_scale.bits));
}

} // namespace io
} // namespace pcl_ext
