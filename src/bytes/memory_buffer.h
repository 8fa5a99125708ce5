#pragma once

#include <cstddef>
#include <cstdint>
#include <streambuf>

namespace pcl_ext {
namespace io {

/** \brief A stream buffer that reads bytes in somebody else's memory. */
class MemoryBuffer : public std::streambuf {
public:
  MemoryBuffer(const std::uint8_t* bytes, std::size_t size)
  {
    // streambuf wants char*, and never writes to a get area that nobody puts back into.
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes));
    setg(begin, begin, begin + size);
  }
};

} // namespace io
} // namespace pcl_ext
