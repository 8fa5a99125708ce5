// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/checksum.h"

#include <zlib.h>

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {

std::uint32_t
chainedChecksum(std::uint32_t reference_checksum,
                const std::uint8_t* bytes,
                std::size_t size)
{
  const std::array<std::uint8_t, 4> prefix{
      static_cast<std::uint8_t>(reference_checksum),
      static_cast<std::uint8_t>(reference_checksum >> 8),
      static_cast<std::uint8_t>(reference_checksum >> 16),
      static_cast<std::uint8_t>(reference_checksum >> 24)};
  auto checksum = crc32_z(0, prefix.data(), prefix.size());
  // zlib returns the initial checksum for a null pointer, which no bytes may have.
  if (size != 0)
    checksum = crc32_z(checksum, bytes, size);
  return static_cast<std::uint32_t>(checksum);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
