#include "stream/region_table.h"

#include "codec/frame_failures.h"

#include <limits>

namespace pcl_ext {
namespace io {

namespace {

// Besides a number of levels.
constexpr unsigned int levels_mask = 7;
constexpr unsigned int sensor_frame_flag = 8; // of a box
constexpr unsigned int left_out_flag = 8;     // outside of all boxes
constexpr unsigned int by_distance_flag = 16; // likewise

std::int32_t
readNumber(ByteSource& source)
{
  using Limits = std::numeric_limits<std::int32_t>;
  const std::int64_t number = source.signedVarint();
  return number >= Limits::min() && number <= Limits::max()
             ? static_cast<std::int32_t>(number)
             : Limits::min();
}

bool
readBox(ByteSource& source, RegionBox& box)
{
  const unsigned int flags = source.u8();
  box.levels = flags & levels_mask;
  box.is_in_sensor_frame = (flags & sensor_frame_flag) != 0;
  for (auto* const corner : {&box.min, &box.max})
    for (std::int32_t& coordinate : *corner)
      coordinate = readNumber(source);
  return flags <= (levels_mask | sensor_frame_flag);
}

} // namespace

void
writeRegionTable(const VoxelRegions& regions, ByteWriter& writer)
{
  writer.varint(regions.boxes.size());
  for (const RegionBox& box : regions.boxes) {
    writer.u8(static_cast<std::uint8_t>(
        box.levels | (box.is_in_sensor_frame ? sensor_frame_flag : 0u)));
    for (const auto* const corner : {&box.min, &box.max})
      for (const std::int32_t coordinate : *corner)
        writer.signedVarint(coordinate);
  }
  writer.u8(static_cast<std::uint8_t>(
      regions.levels_outside | (regions.leaves_out_outside ? left_out_flag : 0u) |
      (regions.coarser_beyond > 0 ? by_distance_flag : 0u)));
  if (regions.coarser_beyond > 0)
    writer.varint(regions.coarser_beyond);
  if (regions.dependsOnPose())
    writeRegionPose(regions.pose, regions.hasSensorBoxes(), writer);
}

void
writeRegionPose(const RegionPose& pose, bool has_rotation, ByteWriter& writer)
{
  for (const std::int32_t position : pose.position)
    writer.signedVarint(position);
  writer.u8(has_rotation ? 1 : 0);
  if (has_rotation)
    for (const auto& row : pose.rotation)
      for (const std::int32_t element : row)
        writer.signedVarint(element);
}

void
readRegionPose(ByteSource& source, RegionPose& pose)
{
  for (std::int32_t& position : pose.position)
    position = readNumber(source);
  const std::uint8_t has_rotation = source.u8();
  if (has_rotation > 1)
    pose.position[0] = std::numeric_limits<std::int32_t>::min();
  for (std::size_t i = 0; has_rotation == 1 && i < 9; ++i)
    pose.rotation[i / 3][i % 3] = readNumber(source);
}

CompressionStatus
readRegionTable(ByteSource& source, VoxelRegions& regions)
{
  regions = VoxelRegions();
  const std::uint64_t count = source.varint();
  bool is_valid = count <= most_regions;
  for (std::uint64_t i = 0; is_valid && i < count; ++i)
    is_valid = readBox(source, regions.boxes.emplace_back());
  const unsigned int flags = is_valid ? source.u8() : 0;
  regions.levels_outside = flags & levels_mask;
  regions.leaves_out_outside = (flags & left_out_flag) != 0;
  if ((flags & by_distance_flag) != 0) {
    const std::uint64_t beyond = source.varint();
    is_valid = is_valid && beyond > 0 && beyond <= std::uint64_t{farthest_region};
    regions.coarser_beyond = is_valid ? static_cast<std::uint32_t>(beyond) : 0;
  }
  if (is_valid && regions.dependsOnPose())
    readRegionPose(source, regions.pose);
  if (source.failure() == ByteSource::Failure::None &&
      (!is_valid || flags > (levels_mask | left_out_flag | by_distance_flag) ||
       !isConsistent(regions)))
    return corruptFrame("invalid regions");
  return {};
}

} // namespace io
} // namespace pcl_ext
