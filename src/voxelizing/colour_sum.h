#pragma once

#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Sum of the colours of some points. */
struct ColourSum {
  std::uint64_t r = 0;
  std::uint64_t g = 0;
  std::uint64_t b = 0;

  /** \param[in] colour as of pcl::PointXYZRGB */
  void
  add(std::uint32_t colour)
  {
    r += colour >> 16 & 0xff;
    g += colour >> 8 & 0xff;
    b += colour & 0xff;
  }
};

} // namespace io
} // namespace pcl_ext
