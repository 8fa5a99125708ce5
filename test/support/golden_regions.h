/** \file
 * \brief The golden stream of regions.
 */
#pragma once

#include "support/golden_stream.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"
#include "voxels/region_cells.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>

namespace pcl_ext {
namespace io {
namespace test {

/** \brief Replaces the voxels of a frame by the coarse ones of regions, with the symbol
 * of one of their voxels each. */
inline void
setRegions(const VoxelRegions& regions, VoxelFrame& frame)
{
  frame.regions = regions;
  RegionCells cells(frame.grid, regions);
  std::map<std::uint64_t, std::uint16_t> voxels;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (const int levels = cells.levelsOf(frame.keys[i]); levels != left_out)
      voxels[keyOfCoarseVoxel(frame.keys[i], static_cast<unsigned int>(levels))] =
          frame.intensities[i];
  frame.keys.clear();
  frame.intensities.clear();
  for (const auto& [key, symbol] : voxels) {
    frame.keys.push_back(key);
    frame.intensities.push_back(symbol);
  }
}

/** \brief A room with boxes in both frames, edges by the distance from a sensor that
 * moves and turns, and without what is outside of boxes. */
inline GoldenStream
goldenRegions(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 30, {}};
  std::mt19937_64 random(71);
  VoxelRegions of_boxes;
  of_boxes.boxes = {{{-64, -60, -57}, {-43, -31, -20}, 0, false},
                    {{-60, -64, -64}, {-31, -37, 63}, 1, false},
                    {{-64, -64, -64}, {-40, 64, 64}, 2, false}};
  VoxelRegions left_out_outside = of_boxes;
  left_out_outside.leaves_out_outside = true;
  of_boxes.levels_outside = 5;
  VoxelRegions by_distance;
  by_distance.coarser_beyond = 11;
  by_distance.levels_outside = 3;
  VoxelRegions of_sensor = by_distance;
  of_sensor.boxes = {{{-9, -25, -10}, {31, 15, 40}, 0, true},
                     {{-64, -64, -64}, {-57, 64, 64}, 1, false}};
  const auto turned = [](std::int32_t cosine, std::int32_t sine, std::int32_t x) {
    return RegionPose{
        {x, -52, -45},
        {{{cosine, -sine, 0}, {sine, cosine, 0}, {0, 0, whole_rotation}}}};
  };
  RoomStream room(roomSettings(7, 36, false));
  for (int i = 0; i < 24; ++i) {
    VoxelFrame frame = room.next();
    if (i == 4) // nothing is seen
      clearVoxels(frame);
    VoxelRegions regions = i < 8 ? of_boxes : i < 11 ? left_out_outside : by_distance;
    if (i >= 11)
      regions.pose.position = {i < 14 ? -60 : -102 + 3 * i, -52, -45};
    if (i >= 17) {
      regions = of_sensor;
      regions.pose =
          i < 20 ? turned(whole_rotation, 0, -52) : turned(13000, -9972 + i, -32 - i);
    }
    setRegions(regions, frame);
    if (i >= 20)
      addColours(random, 5, frame);
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

} // namespace test
} // namespace io
} // namespace pcl_ext
