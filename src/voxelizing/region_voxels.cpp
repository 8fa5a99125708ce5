#include "voxelizing/region_voxels.h"

#include "voxels/region_cells.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace io {

namespace {

/** \brief A whole number within those of regions; 0 for what is none. */
std::int32_t
limited(double number)
{
  constexpr double farthest = farthest_region;
  return std::isnan(number)
             ? 0
             : static_cast<std::int32_t>(std::clamp(number, -farthest, farthest));
}

RegionBox
boxOn(const VoxelGrid& grid, const Region& region)
{
  RegionBox box;
  box.levels = region.doublings;
  box.is_in_sensor_frame = region.frame == RegionFrame::Sensor;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto face = [&](double coordinate) {
      const double origin = box.is_in_sensor_frame ? 0.0 : grid.origin[axis];
      return limited(std::round((coordinate - origin) / grid.resolution));
    };
    // What is far outside the lattice, or narrower than an edge that was doubled, is the
    // nearest box that there is.
    box.min[axis] = std::min(face(region.box.min[axis]), farthest_region - 1);
    box.max[axis] = std::max(face(region.box.max[axis]), box.min[axis] + 1);
  }
  return box;
}

} // namespace

unsigned int
mostDoublings(const RegionSettings& settings)
{
  unsigned int doublings = settings.coarser_beyond > 0.0 ? settings.most_doublings : 0;
  for (const Region& region : settings.boxes)
    doublings = std::max(doublings, region.doublings);
  return doublings;
}

VoxelRegions
regionsOn(const VoxelGrid& grid,
          const RegionSettings& settings,
          const WorldPose& sensor_pose)
{
  VoxelRegions regions;
  for (const Region& region : settings.boxes)
    regions.boxes.push_back(boxOn(grid, region));
  regions.leaves_out_outside = settings.outside == OutsideRegions::LeftOut;
  if (settings.coarser_beyond > 0.0)
    regions.coarser_beyond = static_cast<std::uint32_t>(
        std::max(1, limited(std::round(settings.coarser_beyond / grid.resolution))));
  if (settings.coarser_beyond > 0.0)
    regions.levels_outside = settings.most_doublings;
  else if (!regions.leaves_out_outside)
    regions.levels_outside = mostDoublings(settings);
  for (std::size_t axis = 0; axis < 3 && regions.dependsOnPose(); ++axis)
    regions.pose.position[axis] = limited(std::floor(
        (sensor_pose.translation()[static_cast<int>(axis)] - grid.origin[axis]) /
        grid.resolution));
  for (std::size_t row = 0; row < 3 && regions.hasSensorBoxes(); ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      const double element =
          sensor_pose.linear()(static_cast<int>(row), static_cast<int>(column));
      regions.pose.rotation[row][column] =
          limited(std::round(std::clamp(element, -1.0, 1.0) * double{whole_rotation}));
    }
  return regions;
}

std::size_t
mergeVoxels(const VoxelGrid& grid,
            const VoxelRegions& regions,
            unsigned int share_exponent,
            std::vector<std::uint64_t>& keys,
            VoxelSums& sums)
{
  RegionCells cells(grid, regions);
  std::size_t left_out_points = 0;
  std::size_t merged = 0; // voxels so far, in place
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const int levels = cells.levelsOf(keys[i]);
    if (levels == left_out) {
      left_out_points += sums.counts[i];
      continue;
    }
    if (levels > 0 && share_exponent > 0 && !sums.intensities.empty())
      sums.intensities[i] =
          std::ldexp(sums.intensities[i], -static_cast<int>(share_exponent) * levels);
    const std::uint64_t key =
        keyOfCoarseVoxel(keys[i], static_cast<unsigned int>(levels));
    if (merged > 0 && keys[merged - 1] == key) {
      sums.add(i, merged - 1);
      continue;
    }
    keys[merged] = key;
    sums.copy(i, merged);
    ++merged;
  }
  keys.resize(merged);
  sums.resize(merged, {!sums.intensities.empty(), !sums.colours.empty()});
  return left_out_points;
}

} // namespace io
} // namespace pcl_ext
