/** \file
 * \brief Of zlib what the codec uses, for platforms that Debian has no zlib for. The
 * checksums of the golden streams are real zlib's.
 */
#pragma once

#include <cstddef>
#include <cstdint>

inline std::uint32_t
crc32_z(std::uint32_t checksum, const std::uint8_t* bytes, std::size_t size)
{
  checksum = ~checksum;
  for (std::size_t i = 0; i < size; ++i) {
    checksum ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit)
      checksum = checksum >> 1 ^ ((checksum & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~checksum;
}
