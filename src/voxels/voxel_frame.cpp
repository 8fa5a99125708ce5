// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

bool
isGrid(const VoxelGrid& grid)
{
  return grid.resolution >= smallest_resolution &&
         grid.resolution <= largest_resolution && grid.depth >= 1 &&
         grid.depth <= max_grid_depth &&
         std::all_of(grid.origin.begin(), grid.origin.end(), [](double coordinate) {
           return std::isfinite(coordinate);
         });
}

bool
isScale(const IntensityScale& scale)
{
  return std::isfinite(scale.offset) && std::isfinite(scale.step) &&
         scale.step > 0.0f && scale.bits <= 16 &&
         (scale.companded_range == 0 ||
          (scale.bits > 0 && scale.companded_range > scale.maxSymbol() &&
           scale.companded_range <= 65535));
}

/** \brief Most bits of a channel of a colour. */
constexpr unsigned int most_colour_bits = 8;

/** \brief True if keys are strictly ascending and below `end`, which is at most
 * 2^63. */
bool
areKeys(const std::vector<std::uint64_t>& keys, std::uint64_t end)
{
  // SSE2 has no comparison of 64 bits. For keys below 2^63 the highest bit of
  // (difference - 1) is set where a key is not above its predecessor.
  std::uint64_t differences = 0;
  std::uint64_t bits = keys[0];
  for (std::size_t i = 1; i < keys.size(); ++i) {
    differences |= keys[i] - keys[i - 1] - 1;
    bits |= keys[i];
  }
  return ((differences | bits) >> 63) == 0 && keys.back() < end;
}

/** \brief True if all symbols are below 2^bits. */
bool
areSymbols(const std::vector<std::uint16_t>& symbols, unsigned int bits)
{
  std::uint16_t all = 0;
  for (const std::uint16_t symbol : symbols)
    all = static_cast<std::uint16_t>(all | symbol);
  return all >> bits == 0;
}

bool
areColours(const std::vector<VoxelColour>& colours, unsigned int bits)
{
  unsigned int all = 0;
  for (const VoxelColour& colour : colours)
    all |= unsigned{colour.r} | colour.g | colour.b;
  return all >> bits == 0;
}

/** \brief True if there are as many values as voxels, or none if a frame has none. */
bool
isCount(std::size_t values, bool has_values, std::size_t voxels)
{
  return values == (has_values ? voxels : 0);
}

bool
areFields(const VoxelFrame& frame)
{
  std::size_t values = 0;
  for (const FrameField& field : frame.fields) {
    if (!isField(field) ||
        field.numbers.size() != frame.pointCount() * std::size_t{field.count})
      return false;
    values += field.count;
  }
  return frame.fields.size() <= most_fields && values <= most_field_values &&
         std::all_of(
             frame.viewpoint.begin(), frame.viewpoint.end(), [](std::int32_t x) {
               return x >= -farthest_viewpoint && x <= farthest_viewpoint;
             });
}

/** \brief True if a frame has no points of its own, or as many as its voxels have, each
 * with a place of its own in the cloud that ascends within a voxel. */
bool
arePoints(const VoxelFrame& frame)
{
  const FramePoints& points = frame.points;
  const std::size_t count = points.indices.size();
  if (!points.areThere())
    return count == 0 && points.positions.empty();
  if (!frame.has_point_counts || points.positions.size() != count ||
      !isCount(points.intensities.size(), frame.hasIntensities(), count) ||
      !isCount(points.colours.size(), frame.colour_bits > 0, count))
    return false;
  std::vector<bool> is_taken(points.cloudSize());
  std::size_t point = 0;
  for (const std::uint32_t of_voxel : frame.point_counts)
    for (std::uint32_t i = 0; i < of_voxel; ++i, ++point) {
      if (point >= count || points.indices[point] >= is_taken.size() ||
          is_taken[points.indices[point]] ||
          (i > 0 && points.indices[point] < points.indices[point - 1]))
        return false;
      is_taken[points.indices[point]] = true;
    }
  return point == count && areSymbols(points.intensities, frame.intensity_scale.bits) &&
         areColours(points.colours, frame.colour_bits);
}

} // namespace

std::uint32_t
compandedEdge(unsigned int bits, std::uint32_t range, std::uint32_t level)
{
  const std::uint32_t level_count = std::uint32_t{1} << bits;
  if (level >= level_count)
    return range + 1;
  if (level < 3)
    return level;
  if (level_count == 4)
    return 4;
  constexpr std::uint32_t exact = 4;
  if (level <= exact)
    return level;
  const std::uint64_t widening = level_count - exact;
  const std::uint64_t step = level - exact;
  const std::uint64_t excess = range + 1 - exact - widening;
  return exact + static_cast<std::uint32_t>(step + excess * step * step /
                                                       (widening * widening));
}

std::uint32_t
compandedMiddle(unsigned int bits, std::uint32_t range, std::uint32_t level)
{
  return (compandedEdge(bits, range, level) + compandedEdge(bits, range, level + 1) -
          1) /
         2;
}

void
VoxelFrame::clearVoxels()
{
  keys.clear();
  intensities.clear();
  colours.clear();
  point_counts.clear();
  for (FrameField& field : fields)
    field.numbers.clear();
  points = FramePoints();
}

bool
isConsistent(const VoxelFrame& frame)
{
  if (!isGrid(frame.grid) || !isScale(frame.intensity_scale) ||
      frame.colour_bits > most_colour_bits ||
      (frame.depth_model &&
       (!frame.hasIntensities() || !isConsistent(*frame.depth_model))) ||
      !isCount(frame.intensities.size(), frame.hasIntensities(), frame.size()) ||
      !isCount(frame.colours.size(), frame.colour_bits > 0, frame.size()) ||
      !isCount(frame.point_counts.size(), frame.has_point_counts, frame.size()) ||
      !areFields(frame) || !arePoints(frame))
    return false;
  return frame.keys.empty() ||
         (areKeys(frame.keys, std::uint64_t{1} << (3 * frame.grid.depth)) &&
          areSymbols(frame.intensities, frame.intensity_scale.bits) &&
          areColours(frame.colours, frame.colour_bits) &&
          std::find(frame.point_counts.begin(), frame.point_counts.end(), 0u) ==
              frame.point_counts.end());
}

} // namespace pcl_ext::PCL_EXT_ABI::io
