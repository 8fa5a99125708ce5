#include <pcl_ext/compression/voxel_centres.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace pcl_ext {
namespace io {

namespace {

// The loops below are over as many voxels as there is room for, whatever the frame has
// left, so that the compiler makes vector instructions of them.
constexpr std::size_t most = VoxelCentres::most;

/** \brief Deepest grid whose keys fit 32 bits. */
constexpr unsigned int deepest_narrow_grid = 10;

/** \brief Every third bit of a key of up to ten levels, side by side. */
std::uint32_t
gatherBits(std::uint32_t bits)
{
  bits &= 0x09249249;
  bits = (bits | bits >> 2) & 0x030c30c3;
  bits = (bits | bits >> 4) & 0x0300f00f;
  bits = (bits | bits >> 8) & 0x030000ff;
  return (bits | bits >> 16) & 0x3ff;
}

/** \brief Every third bit of a key of up to 21 levels, side by side. */
std::uint32_t
gatherBits(std::uint64_t bits)
{
  bits &= 0x1249249249249249;
  bits = (bits | bits >> 2) & 0x10c30c30c30c30c3;
  bits = (bits | bits >> 4) & 0x100f00f00f00f00f;
  bits = (bits | bits >> 8) & 0x001f0000ff0000ff;
  bits = (bits | bits >> 16) & 0x001f00000000ffff;
  return static_cast<std::uint32_t>((bits | bits >> 32) & 0x1fffff);
}

template <typename KeyT>
void
computeAxis(const VoxelGrid& grid,
            std::size_t axis,
            const std::array<KeyT, most>& keys,
            std::array<float, most>& coordinates)
{
  const std::size_t lowest_bit = 2 - axis;
  const std::int32_t first_index = grid.first_index[axis];
  const double resolution = grid.resolution;
  const double anchor = grid.anchor[axis];
  std::array<std::int32_t, most> index;
  for (std::size_t i = 0; i < most; ++i)
    // Within the lattice, and so within 32 bits.
    index[i] =
        first_index + static_cast<std::int32_t>(gatherBits(keys[i] >> lowest_bit));
  for (std::size_t i = 0; i < most; ++i)
    coordinates[i] =
        static_cast<float>((static_cast<double>(index[i]) + 0.5) * resolution + anchor);
}

template <typename KeyT>
void
computeCentres(const VoxelGrid& grid,
               const std::uint64_t* frame_keys,
               std::size_t count,
               VoxelCentres& centres)
{
  std::array<KeyT, most> keys{};
  for (std::size_t i = 0; i < count; ++i)
    keys[i] = static_cast<KeyT>(frame_keys[i]);
  computeAxis(grid, 0, keys, centres.x);
  computeAxis(grid, 1, keys, centres.y);
  computeAxis(grid, 2, keys, centres.z);
}

void
lookUpIntensities(const float* values,
                  const std::uint16_t* frame_intensities,
                  std::size_t count,
                  std::array<float, most>& intensities)
{
  for (std::size_t i = 0; i < count; ++i)
    intensities[i] = values[frame_intensities[i]];
}

void
computeIntensities(const IntensityScale& scale,
                   const std::uint16_t* frame_intensities,
                   std::size_t count,
                   std::array<float, most>& intensities)
{
  std::array<std::int32_t, most> symbols{};
  std::copy_n(frame_intensities, count, symbols.begin());
  // IntensityScale::value, but without a branch.
  constexpr double largest = std::numeric_limits<float>::max();
  const auto offset = static_cast<double>(scale.offset);
  const auto step = static_cast<double>(scale.step);
  for (std::size_t i = 0; i < most; ++i) {
    double intensity = offset + static_cast<double>(symbols[i]) * step;
    intensity = intensity < -largest ? -largest : intensity;
    intensity = intensity > largest ? largest : intensity;
    intensities[i] = static_cast<float>(intensity);
  }
}

} // namespace

std::size_t
voxelCentres(const VoxelFrame& frame,
             SymbolIntensities& symbol_intensities,
             std::size_t begin,
             VoxelCentres& centres)
{
  const std::size_t count = std::min(most, frame.size() - begin);
  const std::uint64_t* const keys = frame.keys.data() + begin;
  if (frame.grid.depth <= deepest_narrow_grid)
    computeCentres<std::uint32_t>(frame.grid, keys, count, centres);
  else
    computeCentres<std::uint64_t>(frame.grid, keys, count, centres);
  const std::uint16_t* const symbols = frame.intensities.data() + begin;
  if (const float* const values =
          symbol_intensities.compandedValues(frame.intensity_scale))
    lookUpIntensities(values, symbols, count, centres.intensity);
  else
    computeIntensities(frame.intensity_scale, symbols, count, centres.intensity);
  return count;
}

} // namespace io
} // namespace pcl_ext
