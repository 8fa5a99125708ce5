// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The most blocks that a frame may have, as indices of cells in the history have
 * 32 bits. */
constexpr std::size_t most_blocks = std::size_t{1} << 26;

/** \brief The most bytes of memory that a frame takes for each of its voxels, and for
 * each of its blocks besides, while it is decoded and after. */
constexpr std::size_t bytes_of_voxel = 120;
constexpr std::size_t bytes_of_block = 480;

/** \brief Of these what stays for the next frame: for each voxel of the frame, for each
 * tracked one, and for each block of these. */
constexpr std::size_t kept_bytes_of_voxel = 24;
constexpr std::size_t kept_bytes_of_block = 360;
/** \brief With the memory for a frame, where that is not shared with other decoders. */
constexpr std::size_t kept_bytes_with_workspace = 48;

/** \brief What a frame may have however few bytes it has, besides
 * DecoderLimits::free_voxels, and for each byte beyond that. */
constexpr std::size_t free_blocks = std::size_t{1} << 20;
constexpr std::size_t free_points = std::size_t{1} << 24;
constexpr std::size_t free_values = std::size_t{1} << 26;
constexpr std::uint64_t voxels_of_byte = 64;
constexpr std::uint64_t blocks_of_byte = 8;
constexpr std::uint64_t points_of_byte = 256;
constexpr std::uint64_t values_of_byte = 512;

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

/** \brief What a frame has that decoders limit by its bytes. */
struct FrameCounts {
  std::uint64_t voxels = 0;
  std::uint64_t blocks = 0;
  std::uint64_t points = 0;
  std::uint64_t field_values = 0;
};

/** \brief Inverse of frameLimits(): the fewest bytes with which a frame is within the
 * default limits. 0 for frames that may have any number. */
std::uint64_t
fewestBytes(const FrameCounts& counts);

} // namespace pcl_ext::PCL_EXT_ABI::io
