#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief The most voxels that a frame may have, also with higher limits, as indices of
 * cells in the history have 32 bits. */
constexpr std::size_t largest_frame = std::size_t{1} << 26;

/** \brief The most bytes of memory that a frame takes for each of its voxels, and for each
 * of its blocks besides, while it is decoded and after. */
constexpr std::size_t bytes_of_voxel = 120;
constexpr std::size_t bytes_of_block = 480;

/** \brief Limits of one frame. */
struct FrameLimits {
  std::size_t max_voxels;
  std::size_t max_blocks; ///< those that are not tracked
  std::size_t max_points;
  std::size_t max_field_values;
};

/** \brief The limits of a frame by its bytes, see DecoderLimits::free_voxels.
 * \param[in] bytes of its payload and of those before it, back to the last I-frame; 0 for
 * the published layout, which does not tell the size of a frame
 */
FrameLimits
frameLimits(const DecoderLimits& limits, std::uint64_t bytes);

} // namespace io
} // namespace pcl_ext
