// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace detail {

namespace {

// The loops below have a constant number of iterations, also if fewer voxels are left,
// so that the compiler vectorises them.
constexpr std::size_t capacity = VoxelCentres::capacity;

/** \brief Deepest grid whose keys fit 32 bits. */
constexpr unsigned int deepest_narrow_grid = 10;

/** \brief Gathers every third bit of a key of up to ten levels. */
std::uint32_t
gatherBits(std::uint32_t bits)
{
  bits &= 0x09249249;
  bits = (bits | bits >> 2) & 0x030c30c3;
  bits = (bits | bits >> 4) & 0x0300f00f;
  bits = (bits | bits >> 8) & 0x030000ff;
  return (bits | bits >> 16) & 0x3ff;
}

/** \brief Gathers every third bit of a key of up to 21 levels. */
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

/** \brief Coordinate of a voxel's centre. */
float
centreOf(const VoxelGrid& grid, std::size_t axis, std::int32_t index)
{
  return static_cast<float>((static_cast<double>(index) + 0.5) * grid.resolution +
                            grid.origin[axis]);
}

template <typename KeyT>
void
computeAxis(const VoxelGrid& grid,
            std::size_t axis,
            const std::array<KeyT, capacity>& keys,
            std::array<float, capacity>& coordinates)
{
  const std::size_t lowest_bit = 2 - axis;
  const std::int32_t first_index = grid.first_index[axis];
  std::array<std::int32_t, capacity> index;
  for (std::size_t i = 0; i < capacity; ++i)
    // Within the lattice, and so within 32 bits.
    index[i] =
        first_index + static_cast<std::int32_t>(gatherBits(keys[i] >> lowest_bit));
  for (std::size_t i = 0; i < capacity; ++i)
    coordinates[i] = centreOf(grid, axis, index[i]);
}

template <typename KeyT>
void
computeCentres(const VoxelGrid& grid,
               const std::uint64_t* frame_keys,
               std::size_t count,
               VoxelCentres& centres)
{
  std::array<KeyT, capacity> keys{};
  for (std::size_t i = 0; i < count; ++i)
    keys[i] = static_cast<KeyT>(frame_keys[i]);
  computeAxis(grid, 0, keys, centres.x);
  computeAxis(grid, 1, keys, centres.y);
  computeAxis(grid, 2, keys, centres.z);
}

void
computeIntensities(const IntensityScale& scale,
                   const std::uint16_t* frame_intensities,
                   std::size_t count,
                   std::array<float, capacity>& intensities)
{
  std::array<std::int32_t, capacity> symbols{};
  std::copy_n(frame_intensities, count, symbols.begin());
  // IntensityScale::value without branches.
  constexpr double largest = std::numeric_limits<float>::max();
  const auto offset = static_cast<double>(scale.offset);
  const auto step = static_cast<double>(scale.step);
  for (std::size_t i = 0; i < capacity; ++i) {
    double intensity = offset + static_cast<double>(symbols[i]) * step;
    intensity = intensity < -largest ? -largest : intensity;
    intensity = intensity > largest ? largest : intensity;
    intensities[i] = static_cast<float>(intensity);
  }
}

/** \brief Sets a table to the intensities of the lowest symbols of a linear scale. */
void
fillTable(const IntensityScale& scale, std::size_t symbols, float* table)
{
  std::array<std::uint16_t, capacity> some{};
  std::array<float, capacity> intensities;
  for (std::size_t begin = 0; begin < symbols; begin += capacity) {
    const std::size_t count = std::min(capacity, symbols - begin);
    std::iota(some.begin(), some.end(), static_cast<std::uint16_t>(begin));
    computeIntensities(scale, some.data(), count, intensities);
    std::copy_n(intensities.begin(), count, table + begin);
  }
}

/** \brief Sets a table to the centres of the lowest positions along an axis. */
void
fillTable(const VoxelGrid& grid,
          std::size_t axis,
          std::size_t positions,
          std::array<float, VoxelCentreTables::size>& table)
{
  for (std::size_t i = 0; i < positions; ++i)
    table[i] =
        centreOf(grid, axis, grid.first_index[axis] + static_cast<std::int32_t>(i));
}

} // namespace

VoxelCentreReader::VoxelCentreReader(const VoxelFrame& frame) : frame_(frame)
{
  if (!frame.hasIntensities())
    return;
  setIntensityTable();
  if (table_ != nullptr)
    setCentreTables();
}

/** \brief Sets the table of intensities, unless the frame is small, so that it costs
 * more than it saves. */
void
VoxelCentreReader::setIntensityTable()
{
  const IntensityScale& scale = frame_.intensity_scale;
  const std::size_t symbols = std::size_t{scale.maxSymbol()} + 1;
  const bool is_small = symbols <= small_table_.size();
  if (scale.companded_range == 0) {
    if (!is_small || frame_.size() < 2 * symbols)
      return;
    fillTable(scale, symbols, small_table_.data());
    table_ = small_table_.data();
    return;
  }
  if (!is_small && symbols > frame_.size())
    return;
  float* table = small_table_.data();
  if (!is_small) {
    large_table_.resize(symbols);
    table = large_table_.data();
  }
  for (std::size_t symbol = 0; symbol < symbols; ++symbol)
    table[symbol] = scale.value(static_cast<std::uint16_t>(symbol));
  table_ = table;
}

/** \brief Sets the tables of centres, if the grid is small and the frame is not. */
void
VoxelCentreReader::setCentreTables()
{
  const VoxelGrid& grid = frame_.grid;
  const std::size_t positions = std::size_t{1} << grid.depth;
  if (positions > VoxelCentreTables::size || frame_.size() < 3 * positions)
    return;
  fillTable(grid, 0, positions, tables_.x);
  fillTable(grid, 1, positions, tables_.y);
  fillTable(grid, 2, positions, tables_.z);
  has_tables_ = true;
}

std::size_t
VoxelCentreReader::read(std::size_t begin, VoxelCentres& centres) const
{
  const std::size_t count = std::min(capacity, frame_.size() - begin);
  const std::uint64_t* const keys = frame_.keys.data() + begin;
  if (frame_.grid.depth <= deepest_narrow_grid)
    computeCentres<std::uint32_t>(frame_.grid, keys, count, centres);
  else
    computeCentres<std::uint64_t>(frame_.grid, keys, count, centres);
  const IntensityScale& scale = frame_.intensity_scale;
  if (!frame_.hasIntensities()) {
    centres.intensity.fill(0.0f);
    return count;
  }
  const std::uint16_t* const symbols = frame_.intensities.data() + begin;
  if (table_ != nullptr)
    for (std::size_t i = 0; i < count; ++i)
      centres.intensity[i] = table_[symbols[i]];
  else if (scale.companded_range == 0)
    computeIntensities(scale, symbols, count, centres.intensity);
  else
    for (std::size_t i = 0; i < count; ++i)
      centres.intensity[i] = scale.value(symbols[i]);
  return count;
}

} // namespace detail
} // namespace pcl_ext::PCL_EXT_ABI::io
