#pragma once

namespace pcl_ext {
namespace measuring {

/** \brief Bytes a second between one thread and memory that is in no cache. */
struct MemoryBandwidth {
  double read = 0.0;
  double write = 0.0;
};

/** \brief Megabytes of the buffer that is read and written; larger than caches. */
constexpr unsigned int bandwidth_buffer_megabytes = 512;

/** \brief Reads and fills the buffer some times; the fastest time of each counts. */
MemoryBandwidth
measureMemoryBandwidth();

} // namespace measuring
} // namespace pcl_ext
