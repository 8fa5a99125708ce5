#include "memory_bandwidth.h"

#include "measuring/samples.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

constexpr unsigned int repetitions = 5;

/** \brief Bytes a second, from the fastest of some calls. */
template <typename ActionT>
double
fastestRate(std::size_t bytes, ActionT&& action)
{
  double milliseconds = std::numeric_limits<double>::infinity();
  for (unsigned int i = 0; i < repetitions; ++i)
    milliseconds = std::min(milliseconds, timeOf([&] { action(i); }));
  return 1e3 * static_cast<double>(bytes) / milliseconds;
}

} // namespace

MemoryBandwidth
measureMemoryBandwidth()
{
  // Filled, so that the memory is there before it is read.
  std::vector<std::uint64_t> buffer(
      std::size_t{bandwidth_buffer_megabytes} * 1000000 / sizeof(std::uint64_t), 1);
  const std::size_t bytes = buffer.size() * sizeof(std::uint64_t);
  // Volatile, so that the compiler keeps what makes it.
  volatile std::uint64_t result = 0;
  MemoryBandwidth bandwidth;
  bandwidth.read = fastestRate(bytes, [&](unsigned int i) {
    result = std::accumulate(buffer.begin(), buffer.end(), std::uint64_t{i});
  });
  bandwidth.write = fastestRate(bytes, [&](unsigned int i) {
    std::memset(buffer.data(), static_cast<int>(i), bytes);
    result = buffer[i];
  });
  return bandwidth;
}

} // namespace measuring
} // namespace pcl_ext
