// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What all fuzz targets share: how they read their input and how they fail.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace pcl_ext::fuzz {

/** \brief Stops the program, which is how a fuzzer learns of a broken promise.
 * \param[in] line where the promise is, for the message
 */
inline void
require(bool condition,
        int line = __builtin_LINE(),
        const char* file = __builtin_FILE())
{
  if (condition)
    return;
  std::fprintf(stderr, "%s:%d: a promise is broken\n", file, line);
  std::abort();
}

/** \brief Takes numbers off the front of an input; gives zeros past its end. */
class FuzzInput {
public:
  FuzzInput(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  bool
  isAtEnd() const
  {
    return size_ == 0;
  }

  std::uint8_t
  byte()
  {
    if (size_ == 0)
      return 0;
    --size_;
    return *bytes_++;
  }

  /** \brief A number of some bytes, the lowest first. */
  template <typename NumberT>
  NumberT
  number()
  {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(NumberT); ++i)
      value |= static_cast<std::uint64_t>(byte()) << 8 * i;
    return static_cast<NumberT>(value);
  }

  std::vector<std::uint8_t>
  rest()
  {
    std::vector<std::uint8_t> bytes(bytes_, bytes_ + size_);
    size_ = 0;
    return bytes;
  }

private:
  const std::uint8_t* bytes_;
  std::size_t size_;
};

} // namespace pcl_ext::fuzz
