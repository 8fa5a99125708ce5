#include "recording/recording_limits.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace pcl_ext {
namespace recording {

io::DecoderLimits
decoderLimitsOf(std::uint64_t bytes)
{
  constexpr std::uint64_t voxels_of_byte = 8;
  constexpr std::size_t most_voxels = std::size_t{1} << 22;
  constexpr std::size_t points_of_voxel = 16;
  constexpr std::size_t values_of_point = 4;
  io::DecoderLimits limits;
  limits.max_frame_bytes = max_recorded_frame_bytes;
  limits.max_voxels = bytes > most_voxels / voxels_of_byte
                          ? most_voxels
                          : std::max(limits.max_voxels,
                                     static_cast<std::size_t>(voxels_of_byte * bytes));
  limits.max_points = points_of_voxel * limits.max_voxels;
  limits.max_field_values = values_of_point * limits.max_points;
  return limits;
}

io::DecoderLimits
limitsOfReading()
{
  io::DecoderLimits limits;
  limits.max_frame_bytes = max_recorded_frame_bytes;
  limits.max_voxels = std::numeric_limits<std::uint32_t>::max();
  limits.max_points = std::numeric_limits<std::uint32_t>::max();
  return limits;
}

} // namespace recording
} // namespace pcl_ext
