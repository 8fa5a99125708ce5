#include "codec/fast/symbol_statistics.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace {

namespace statistics = pcl_ext::io::fast::symbol_statistics;

TEST(SymbolStatistics, RunningOnesAreThoseOfAVoxelWithTheSameBins)
{
  std::mt19937 random(4);
  std::uniform_int_distribution<unsigned int> any_bin(
      0, pcl_ext::io::fast::intensity_bins::highest);
  for (unsigned int first = 0; first <= pcl_ext::io::fast::intensity_bins::highest;
       ++first) {
    statistics::Running running(first);
    std::uint16_t packed = statistics::first(first);
    for (int i = 0; i < 5000; ++i) {
      ASSERT_EQ(running.contextOf(), statistics::contextOf(packed));
      ASSERT_EQ(running.lowestBin(), statistics::lowestBin(packed));
      // Runs of one bin as well as jumps between the ends.
      const unsigned int bin = i / 50 % 2 == 0 ? any_bin(random) : first;
      running.add(bin);
      packed = statistics::next(packed, bin);
    }
  }
}

} // namespace
