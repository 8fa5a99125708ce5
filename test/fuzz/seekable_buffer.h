/** \file
 * \brief Bytes in memory as a stream that can seek; std::stringbuf would copy them.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <streambuf>

namespace pcl_ext {
namespace fuzz {

class SeekableBuffer : public std::streambuf {
public:
  SeekableBuffer(const std::uint8_t* bytes, std::size_t size)
  {
    // streambuf wants char*, and never writes to a get area that nobody puts back into.
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes));
    setg(begin, begin, begin + size);
  }

  /** \brief Bytes that were read so far. */
  std::size_t
  position() const
  {
    return static_cast<std::size_t>(gptr() - eback());
  }

protected:
  pos_type
  seekoff(off_type offset,
          std::ios_base::seekdir direction,
          std::ios_base::openmode /*mode*/) override
  {
    const off_type base = direction == std::ios_base::beg   ? 0
                          : direction == std::ios_base::cur ? gptr() - eback()
                                                            : egptr() - eback();
    if (base + offset < 0 || base + offset > egptr() - eback())
      return pos_type(off_type(-1));
    setg(eback(), eback() + base + offset, egptr());
    return pos_type(base + offset);
  }

  pos_type
  seekpos(pos_type position, std::ios_base::openmode mode) override
  {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

} // namespace fuzz
} // namespace pcl_ext
