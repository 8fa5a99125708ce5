// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/point_voxels.h"

#include "bytes/exceptions.h"
#include "voxels/radix_sort.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief A point to be sorted into its voxel. */
struct Entry {
  std::uint64_t key;
  std::uint32_t point;
};

std::uint64_t
keyOf(const Entry& entry)
{
  return entry.key;
}

/** \brief The points that are in the grid, by their voxels. */
std::vector<Entry>
entriesOf(const VoxelFrame& frame)
{
  const VoxelGrid& grid = frame.grid;
  const auto size = static_cast<double>(grid.size());
  std::array<double, 3> corner;
  for (std::size_t axis = 0; axis < 3; ++axis)
    corner[axis] = grid.lowerCorner(axis);
  std::vector<Entry> entries;
  entries.reserve(frame.points.positions.size());
  for (std::uint32_t point = 0; point < frame.points.positions.size(); ++point) {
    std::array<std::uint32_t, 3> voxel;
    bool is_inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double place =
          (frame.points.positions[point][axis] - corner[axis]) / grid.resolution;
      is_inside = is_inside && place >= 0.0 && place < size;
      voxel[axis] = is_inside ? static_cast<std::uint32_t>(place) : 0;
    }
    if (is_inside)
      entries.push_back({mortonKey({voxel[0], voxel[1], voxel[2]}), point});
  }
  std::vector<Entry> spare;
  radixSort(entries, spare, 3 * grid.depth);
  return entries;
}

/** \brief Puts what points have in the order of the entries.
 * \param[in] count values of a point
 */
template <typename ValueT>
void
arrange(const std::vector<Entry>& entries,
        std::size_t count,
        std::vector<ValueT>& values)
{
  if (values.empty())
    return;
  std::vector<ValueT> arranged;
  arranged.reserve(entries.size() * count);
  for (const Entry& entry : entries)
    for (std::size_t i = 0; i < count; ++i)
      arranged.push_back(values[entry.point * count + i]);
  values.swap(arranged);
}

/** \brief Sums over the points of a voxel. */
struct PointSums {
  std::uint32_t count = 0;
  std::uint64_t intensity = 0;
  std::array<std::uint64_t, 3> colour{};

  void
  add(const FramePoints& points, std::size_t point)
  {
    ++count;
    if (!points.intensities.empty())
      intensity += points.intensities[point];
    if (points.colours.empty())
      return;
    colour[0] += points.colours[point].r;
    colour[1] += points.colours[point].g;
    colour[2] += points.colours[point].b;
  }

  std::uint64_t
  mean(std::uint64_t sum) const
  {
    return (sum + count / 2) / count;
  }

  void
  append(std::uint64_t key, VoxelFrame& frame) const
  {
    frame.keys.push_back(key);
    frame.point_counts.push_back(count);
    if (frame.hasIntensities())
      frame.intensities.push_back(static_cast<std::uint16_t>(mean(intensity)));
    if (frame.colour_bits > 0)
      frame.colours.push_back({static_cast<std::uint8_t>(mean(colour[0])),
                               static_cast<std::uint8_t>(mean(colour[1])),
                               static_cast<std::uint8_t>(mean(colour[2]))});
  }
};

} // namespace

void
setVoxels(VoxelFrame& frame)
{
  if (!frame.points.areThere() || !frame.keys.empty())
    return;
  const std::vector<Entry> entries = entriesOf(frame);
  frame.points.outside_grid += frame.points.indices.size() - entries.size();
  arrange(entries, 1, frame.points.indices);
  arrange(entries, 1, frame.points.positions);
  arrange(entries, 1, frame.points.intensities);
  arrange(entries, 1, frame.points.colours);
  for (FrameField& field : frame.fields)
    arrange(entries, field.count, field.numbers);
  if (frame.points.height == 1)
    closeGaps(frame.points);
  frame.has_point_counts = true;
  frame.intensities.clear();
  frame.colours.clear();
  frame.point_counts.clear();
  PointSums sums;
  for (std::size_t point = 0; point < entries.size(); ++point) {
    sums.add(frame.points, point);
    if (point + 1 < entries.size() && entries[point + 1].key == entries[point].key)
      continue;
    sums.append(entries[point].key, frame);
    sums = PointSums();
  }
}

CompressionStatus
statusOfVoxels(const VoxelFrame& frame)
{
  const std::size_t points = frame.points.outside_grid;
  if (points == 0)
    return {};
  return callOrElse(
      [points] {
        return CompressionStatus(
            CompressionCode::Ok,
            SettingText{std::to_string(points) +
                        " points of the scan are outside its grid of voxels and were "
                        "left out: encode with a larger {resolution}, or decode the "
                        "points without voxels, filters and thresholds"});
      },
      [] { return CompressionStatus(); });
}

void
closeGaps(FramePoints& points)
{
  if (points.indices.size() == points.width)
    return;
  std::vector<std::uint32_t> numbers(points.width);
  for (const std::uint32_t index : points.indices)
    numbers[index] = 1;
  std::uint32_t count = 0;
  for (std::uint32_t& number : numbers) {
    const std::uint32_t is_there = number;
    number = count;
    count += is_there;
  }
  for (std::uint32_t& index : points.indices)
    index = numbers[index];
  points.width = count;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
