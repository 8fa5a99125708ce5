// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/version.h>

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief CRC-32 (ISO-HDLC). */
inline std::uint32_t
bitwiseCrc(const std::vector<std::uint8_t>& bytes)
{
  std::uint32_t remainder = 0xffffffff;
  for (const std::uint8_t byte : bytes) {
    remainder ^= byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = remainder >> 1 ^ ((remainder & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~remainder;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
