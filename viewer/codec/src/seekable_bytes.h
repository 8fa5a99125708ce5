// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <streambuf>

namespace pcl_ext {
namespace viewer {

/** \brief Bytes to decode, in which the decoder goes back after a failure to where the
 * next frame may begin. */
class SeekableBytes : public std::streambuf {
public:
  SeekableBytes(const std::uint8_t* bytes, std::size_t size)
  {
    // streambuf takes char*, but does not write to a get area without a putback.
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes));
    setg(begin, begin, begin + size);
  }

  std::size_t
  position() const
  {
    return static_cast<std::size_t>(gptr() - eback());
  }

protected:
  pos_type
  seekoff(off_type offset,
          std::ios_base::seekdir from,
          std::ios_base::openmode) override
  {
    const off_type origin = from == std::ios_base::beg   ? 0
                            : from == std::ios_base::cur ? gptr() - eback()
                                                         : egptr() - eback();
    const off_type position = origin + offset;
    if (position < 0 || position > egptr() - eback())
      return pos_type(off_type(-1));
    setg(eback(), eback() + position, egptr());
    return pos_type(position);
  }

  pos_type
  seekpos(pos_type position, std::ios_base::openmode mode) override
  {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

} // namespace viewer
} // namespace pcl_ext
