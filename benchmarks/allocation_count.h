#pragma once

#include <cstddef>

namespace pcl_ext {
namespace benchmarks {

/** \brief Calls of operator new since the program began. Memory that comes from malloc
 * itself is not counted: the points of PCL's clouds, and zstd's. */
std::size_t
allocationCount();

} // namespace benchmarks
} // namespace pcl_ext
