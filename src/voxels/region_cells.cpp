#include "voxels/region_cells.h"

#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cstdlib>

namespace pcl_ext {
namespace io {

namespace {

bool
isNear(std::int32_t number, std::int32_t farthest)
{
  return number >= -farthest && number <= farthest;
}

bool
isBox(const RegionBox& box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!isNear(box.min[axis], farthest_region) ||
        !isNear(box.max[axis], farthest_region) || box.min[axis] >= box.max[axis])
      return false;
  return box.levels <= most_region_levels;
}

bool
isPose(const VoxelRegions& regions)
{
  const RegionPose& pose = regions.pose;
  for (const std::int32_t position : pose.position)
    if (!isNear(position, regions.dependsOnPose() ? farthest_region : 0))
      return false;
  for (const auto& row : pose.rotation)
    for (const std::int32_t element : row)
      if (!isNear(element, regions.hasSensorBoxes() ? whole_rotation : 0))
        return false;
  return true;
}

} // namespace

unsigned int
VoxelRegions::mostLevels() const
{
  unsigned int levels = levels_outside;
  for (const RegionBox& box : boxes)
    levels = std::max(levels, box.levels);
  return levels;
}

bool
VoxelRegions::hasSensorBoxes() const
{
  return std::any_of(boxes.begin(), boxes.end(), [](const RegionBox& box) {
    return box.is_in_sensor_frame;
  });
}

bool
isConsistent(const VoxelRegions& regions)
{
  const bool is_by_distance = regions.coarser_beyond > 0;
  if (regions.boxes.size() > most_regions ||
      regions.levels_outside > most_region_levels ||
      regions.coarser_beyond > std::uint32_t{farthest_region})
    return false;
  if (regions.boxes.empty() && !is_by_distance)
    return false;
  if (is_by_distance && (regions.levels_outside == 0 || regions.leaves_out_outside))
    return false;
  if (regions.leaves_out_outside && regions.levels_outside > 0)
    return false;
  return std::all_of(regions.boxes.begin(), regions.boxes.end(), isBox) &&
         isPose(regions);
}

bool
isAligned(const VoxelGrid& grid, unsigned int levels)
{
  const std::int32_t within = (1 << levels) - 1;
  return grid.depth >= levels &&
         ((grid.first_index[0] | grid.first_index[1] | grid.first_index[2]) & within) ==
             0;
}

RegionCells::RegionCells(const VoxelGrid& grid, const VoxelRegions& regions)
: regions_(regions), most_levels_(regions.mostLevels())
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first_[axis] = 2 * std::int64_t{grid.first_index[axis]};
    sensor_[axis] = 2 * std::int64_t{regions.pose.position[axis]} + 1;
  }
}

int
RegionCells::levelsOf(std::uint64_t key)
{
  for (unsigned int levels = most_levels_; levels > 0; --levels) {
    Judged& judged = judged_[levels];
    if (const std::uint64_t cell = key >> 3 * levels; judged.key != cell)
      judged = {cell, isTaken(key, levels)};
    if (judged.is_taken)
      return static_cast<int>(levels);
  }
  return !regions_.leaves_out_outside || isTaken(key, 0) ? 0 : left_out;
}

/** \brief Whether the centre of a coarse voxel is in a region of at least its levels. */
bool
RegionCells::isTaken(std::uint64_t key, unsigned int levels) const
{
  const VoxelPosition lowest = voxelPosition(keyOfCoarseVoxel(key, levels));
  const std::int64_t to_centre = std::int64_t{1} << levels;
  return levelsAt({first_[0] + 2 * std::int64_t{lowest.x} + to_centre,
                   first_[1] + 2 * std::int64_t{lowest.y} + to_centre,
                   first_[2] + 2 * std::int64_t{lowest.z} + to_centre}) >=
         static_cast<int>(levels);
}

/** \brief Levels of the region that a point is in, or `left_out`. */
int
RegionCells::levelsAt(const Point& point) const
{
  const Point from_sensor = {
      point[0] - sensor_[0], point[1] - sensor_[1], point[2] - sensor_[2]};
  for (const RegionBox& box : regions_.boxes)
    if (isIn(box.is_in_sensor_frame ? from_sensor : point, box))
      return static_cast<int>(box.levels);
  if (regions_.leaves_out_outside)
    return left_out;
  if (regions_.coarser_beyond == 0)
    return static_cast<int>(regions_.levels_outside);
  std::int64_t squared_distance = 0;
  for (const std::int64_t distance : from_sensor)
    squared_distance += distance * distance;
  int levels = 0;
  // Below 2^54 half voxels, squared.
  for (std::int64_t beyond = 2 * std::int64_t{regions_.coarser_beyond};
       levels < static_cast<int>(regions_.levels_outside) &&
       squared_distance >= beyond * beyond;
       beyond *= 2)
    ++levels;
  return levels;
}

bool
RegionCells::isIn(const Point& point, const RegionBox& box) const
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::int64_t coordinate = point[axis];
    std::int64_t unit = 2; // half voxels
    if (box.is_in_sensor_frame) {
      const auto& rotation = regions_.pose.rotation;
      coordinate = 0;
      for (std::size_t row = 0; row < 3; ++row)
        coordinate += rotation[row][axis] * point[row];
      unit *= whole_rotation;
    }
    if (coordinate < unit * box.min[axis] || coordinate >= unit * box.max[axis])
      return false;
  }
  return true;
}

std::vector<std::uint8_t>
voxelLevels(const VoxelFrame& frame)
{
  std::vector<std::uint8_t> levels(frame.size());
  if (!frame.regions)
    return levels;
  RegionCells cells(frame.grid, *frame.regions);
  for (std::size_t i = 0; i < frame.size(); ++i)
    levels[i] = static_cast<std::uint8_t>(std::max(0, cells.levelsOf(frame.keys[i])));
  return levels;
}

} // namespace io
} // namespace pcl_ext
