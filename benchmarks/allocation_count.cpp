#include "allocation_count.h"

#include "measuring/counted_memory.h"

namespace pcl_ext {
namespace benchmarks {

namespace {

/** \brief Before anything is timed. */
[[maybe_unused]] const bool bytes_are_counted = io::test::memory_count.counts_bytes =
    false;

} // namespace

std::size_t
allocationCount()
{
  return io::test::memory_count.allocations;
}

} // namespace benchmarks
} // namespace pcl_ext
