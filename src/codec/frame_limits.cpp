// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/frame_limits.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {

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
  const std::size_t max_voxels =
      std::min(limits.max_voxels, DecoderLimits::most_voxels);
  const std::uint64_t max_points =
      std::min<std::uint64_t>(limits.max_points, std::uint64_t{16} * max_voxels);
  const std::size_t max_blocks = std::min(max_voxels, most_blocks);
  if (limits.free_voxels >= most_blocks)
    return {max_voxels,
            max_blocks,
            static_cast<std::size_t>(max_points),
            limits.max_field_values};
  return {
      limitByBytes(max_voxels, limits.free_voxels, bytes, voxels_of_byte),
      limitByBytes(
          max_blocks, std::min(limits.free_voxels, free_blocks), bytes, blocks_of_byte),
      limitByBytes(max_points, free_points, bytes, points_of_byte),
      limitByBytes(limits.max_field_values, free_values, bytes, values_of_byte)};
}

std::uint64_t
fewestBytes(const FrameCounts& counts)
{
  const auto bytes_for =
      [](std::uint64_t count, std::uint64_t of_few_bytes, std::uint64_t of_byte) {
        return count > of_few_bytes ? (count + of_byte - 1) / of_byte : 0;
      };
  return std::max(
      {bytes_for(counts.voxels, DecoderLimits().free_voxels, voxels_of_byte),
       bytes_for(counts.blocks, free_blocks, blocks_of_byte),
       bytes_for(counts.points, free_points, points_of_byte),
       bytes_for(counts.field_values, free_values, values_of_byte)});
}

} // namespace pcl_ext::PCL_EXT_ABI::io
