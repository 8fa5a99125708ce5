// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Decoding of changes as targets that read streams check it: added up they are
 * as many voxels as another decoder decodes from the same bytes. That they are the same
 * ones: test_voxel_changes.cpp.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_changes.h>

#include "checked_decoding.h"
#include "codec/published/frame.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::fuzz {

/** \brief Where the next frame may begin after a byte. */
inline std::size_t
nextMagic(const std::uint8_t* data, std::size_t size, std::size_t begin)
{
  const auto find = [&](const char* magic, std::size_t magic_size) {
    const auto* const found = std::search(
        data + begin, data + size, magic, magic + magic_size, [](auto byte, char c) {
          return byte == static_cast<std::uint8_t>(c);
        });
    return static_cast<std::size_t>(found - data);
  };
  return std::min(find(io::version1_magic, io::version1_magic_size),
                  find(io::published::magic, io::published::magic_size));
}

/** \brief Decodes a stream as whole frames and as changes, which have to agree. */
inline void
requireSameChanges(const std::uint8_t* data, std::size_t size)
{
  io::FrameDecoder whole(smallLimits());
  io::FrameDecoder changing(smallLimits());
  io::VoxelFrame frame;
  io::VoxelFrame latest;
  io::VoxelChanges changes;
  std::size_t voxels = 0;
  bool has_frame = false;
  for (std::size_t begin = 0; begin < size;) {
    const io::CompressionStatus status =
        whole.decode(data + begin, size - begin, frame);
    require(changing.decode(data + begin, size - begin, changes).code() ==
            status.code());
    if (status.ok()) {
      require(changes.is_from_nothing == !has_frame);
      has_frame = true;
      requireWhole(changes.gone);
      requireWhole(changes.came);
      require(changes.gone.size() <= (changes.is_from_nothing ? 0 : voxels));
      voxels = (changes.is_from_nothing ? 0 : voxels - changes.gone.size()) +
               changes.came.size();
      require(voxels == frame.size());
      require(changes.came.grid == frame.grid);
      begin += whole.statistics().skipped_bytes + whole.statistics().bytes;
    }
    else {
      require(changes.gone.keys.empty() && changes.came.keys.empty());
      const std::size_t failed = nextMagic(data, size, begin);
      begin = nextMagic(data, size, std::min(failed + 1, size));
    }
    require(changing.latestVoxels(latest) == has_frame);
    require(latest.size() == voxels);
  }
}

} // namespace pcl_ext::fuzz
