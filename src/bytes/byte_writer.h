// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Appends little-endian numbers to a vector of bytes. */
class ByteWriter {
public:
  explicit ByteWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  void
  u8(std::uint8_t number)
  {
    bytes_.push_back(number);
  }

  void
  u16(std::uint16_t number)
  {
    littleEndian(number, 2);
  }

  void
  u32(std::uint32_t number)
  {
    littleEndian(number, 4);
  }

  void
  i32(std::int32_t number)
  {
    u32(static_cast<std::uint32_t>(number));
  }

  void
  u64(std::uint64_t number)
  {
    littleEndian(number, 8);
  }

  void
  f32(float number)
  {
    static_assert(sizeof(float) == 4, "streams have IEEE 754 single precision");
    std::uint32_t bits;
    std::memcpy(&bits, &number, sizeof(bits));
    u32(bits);
  }

  void
  f64(double number)
  {
    static_assert(sizeof(double) == 8, "streams have IEEE 754 double precision");
    std::uint64_t bits;
    std::memcpy(&bits, &number, sizeof(bits));
    u64(bits);
  }

  /** \brief Seven bits per byte, lowest first; the high bit is set on all bytes but the
   * last. */
  void
  varint(std::uint64_t number)
  {
    for (; number >= 0x80; number >>= 7)
      u8(static_cast<std::uint8_t>(number | 0x80));
    u8(static_cast<std::uint8_t>(number));
  }

  /** \brief 0, -1, 1, -2, 2, ... as the varints 0, 1, 2, 3, 4, ... */
  void
  signedVarint(std::int64_t number)
  {
    const auto bits = static_cast<std::uint64_t>(number);
    varint(number < 0 ? ~(bits << 1) : bits << 1);
  }

  void
  raw(const void* source, std::size_t size)
  {
    const auto* begin = static_cast<const std::uint8_t*>(source);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }

private:
  void
  littleEndian(std::uint64_t number, unsigned int size)
  {
    for (unsigned int i = 0; i < size; ++i, number >>= 8)
      u8(static_cast<std::uint8_t>(number));
  }

  std::vector<std::uint8_t>& bytes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
