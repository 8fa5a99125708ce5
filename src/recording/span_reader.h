// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Reads little-endian numbers from bytes that it does not own.
 *
 * Errors are sticky: after a read beyond the end all reads return 0 or nothing, so that
 * a parser can check failed() once at the end.
 */
class SpanReader {
public:
  SpanReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size)
  {}

  std::uint8_t
  u8()
  {
    return static_cast<std::uint8_t>(number(1));
  }

  std::uint32_t
  u32()
  {
    return static_cast<std::uint32_t>(number(4));
  }

  std::uint64_t
  u64()
  {
    return number(8);
  }

  /** \brief A number of 1 to 8 bytes. */
  std::uint64_t
  number(unsigned int size)
  {
    const std::uint8_t* const begin = take(size);
    std::uint64_t value = 0;
    for (unsigned int i = 0; begin != nullptr && i < size; ++i)
      value |= std::uint64_t{begin[i]} << (8 * i);
    return value;
  }

  /** \brief Skips bytes and returns where they are; null if there are not as many. */
  const std::uint8_t*
  take(std::uint64_t count)
  {
    if (has_failed_ || count > size_ - position_) {
      has_failed_ = true;
      return nullptr;
    }
    const std::uint8_t* const begin = bytes_ + position_;
    position_ += static_cast<std::size_t>(count);
    return begin;
  }

  /** \brief A string of as many bytes as the u32 before it says. */
  std::string
  string()
  {
    const std::uint32_t size = u32();
    const std::uint8_t* const begin = take(size);
    return begin == nullptr ? std::string()
                            : std::string(reinterpret_cast<const char*>(begin), size);
  }

  std::size_t
  position() const
  {
    return position_;
  }

  std::size_t
  remaining() const
  {
    return has_failed_ ? 0 : size_ - position_;
  }

  bool
  failed() const
  {
    return has_failed_;
  }

protected:
  void
  fail()
  {
    has_failed_ = true;
  }

private:
  const std::uint8_t* bytes_;
  std::size_t size_;
  std::size_t position_ = 0;
  bool has_failed_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
