// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Of zlib what the codec uses, for platforms that Debian has no zlib for:
 * WebAssembly in the viewer, and processors that tools/check_determinism.sh tries. In a
 * folder of its own, which is on the path of headers there only. The checksums of the
 * golden streams are real zlib's.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace platforms {

/** \brief What a byte of a CRC-32 becomes, with 0 to 3 zero bytes after it. */
using CrcTables = std::array<std::array<std::uint32_t, 256>, 4>;

constexpr CrcTables
makeCrcTables()
{
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t checksum = byte;
    for (int bit = 0; bit < 8; ++bit)
      checksum = checksum >> 1 ^ ((checksum & 1) != 0 ? 0xedb88320u : 0u);
    tables[0][byte] = checksum;
  }
  for (std::size_t i = 1; i < tables.size(); ++i)
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[i - 1][byte];
      tables[i][byte] = before >> 8 ^ tables[0][before & 0xff];
    }
  return tables;
}

inline constexpr CrcTables crc_tables = makeCrcTables();

} // namespace platforms
} // namespace pcl_ext

inline std::uint32_t
crc32_z(std::uint32_t checksum, const std::uint8_t* bytes, std::size_t size)
{
  const auto& tables = pcl_ext::platforms::crc_tables;
  checksum = ~checksum;
  for (; size >= 4; size -= 4, bytes += 4)
    checksum = tables[3][(checksum ^ bytes[0]) & 0xff] ^
               tables[2][(checksum >> 8 ^ bytes[1]) & 0xff] ^
               tables[1][(checksum >> 16 ^ bytes[2]) & 0xff] ^
               tables[0][checksum >> 24 ^ bytes[3]];
  for (; size > 0; --size, ++bytes)
    checksum = checksum >> 8 ^ tables[0][(checksum ^ *bytes) & 0xff];
  return ~checksum;
}
