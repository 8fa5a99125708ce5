#include "codec/frame_limits.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

namespace {

/** \brief The lesser of a limit and what a frame may have by its bytes.
 * \param[in] of_few_bytes however few they are
 * \param[in] of_byte for each byte
 */
std::size_t
limitByBytes(std::uint64_t limit,
             std::uint64_t of_few_bytes,
             std::uint64_t bytes,
             std::uint64_t of_byte)
{
  // A division, as the product might overflow.
  if (bytes >= limit / of_byte + 1)
    return static_cast<std::size_t>(limit);
  return static_cast<std::size_t>(
      std::min(limit, std::max(of_few_bytes, bytes * of_byte)));
}

} // namespace

FrameLimits
frameLimits(const DecoderLimits& limits, std::uint64_t bytes)
{
  constexpr std::size_t free_blocks = std::size_t{1} << 20;
  constexpr std::size_t free_points = std::size_t{1} << 24;
  constexpr std::size_t free_values = std::size_t{1} << 26;
  const std::size_t max_voxels = std::min(limits.max_voxels, largest_frame);
  const std::uint64_t max_points =
      std::min<std::uint64_t>(limits.max_points, std::uint64_t{16} * max_voxels);
  if (limits.free_voxels >= largest_frame)
    return {max_voxels,
            max_voxels,
            static_cast<std::size_t>(max_points),
            limits.max_field_values};
  return {limitByBytes(max_voxels, limits.free_voxels, bytes, 64),
          limitByBytes(max_voxels, std::min(limits.free_voxels, free_blocks), bytes, 8),
          limitByBytes(max_points, free_points, bytes, 256),
          limitByBytes(limits.max_field_values, free_values, bytes, 512)};
}

} // namespace io
} // namespace pcl_ext
