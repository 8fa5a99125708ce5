#include "simd/bit_operations.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace {

using namespace pcl_ext;

TEST(BitOperations, EverySingleBitIsFound)
{
  for (unsigned int bit = 0; bit < 64; ++bit) {
    const std::uint64_t single = std::uint64_t{1} << bit;
    EXPECT_EQ(lowestBit(single), bit);
    EXPECT_EQ(lowestBit(~std::uint64_t{0} << bit), bit);
    EXPECT_EQ(portable::lowestBit(single), bit);
    EXPECT_EQ(portable::lowestBit(~std::uint64_t{0} << bit), bit);
    EXPECT_EQ(bitCount(single), 1u);
    EXPECT_EQ(bitCount(single - 1), bit);
    EXPECT_EQ(bitCount(~std::uint64_t{0} << bit), 64 - bit);
  }
  EXPECT_EQ(bitCount(0), 0u);
  for (unsigned int bit = 0; bit < 32; ++bit) {
    const std::uint32_t single = std::uint32_t{1} << bit;
    EXPECT_EQ(lowestBit(single), bit);
    EXPECT_EQ(lowestBit(~std::uint32_t{0} << bit), bit);
    EXPECT_EQ(highestBit(single), bit);
    EXPECT_EQ(highestBit(single | (single - 1)), bit);
    EXPECT_EQ(portable::lowestBit(single), bit);
    EXPECT_EQ(portable::lowestBit(~std::uint32_t{0} << bit), bit);
    EXPECT_EQ(portable::highestBit(single), bit);
    EXPECT_EQ(portable::highestBit(single | (single - 1)), bit);
  }
}

TEST(BitOperations, CompilersOwnAgreeWithPortableOnes)
{
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits =
        (random() >> random() % 64 | 1) << random() % 64 | std::uint64_t{1} << 63;
    ASSERT_EQ(lowestBit(bits), portable::lowestBit(bits)) << bits;
    const auto narrow = static_cast<std::uint32_t>(
        (random() & 0xffffffff) >> random() % 32 | std::uint64_t{1} << random() % 32);
    ASSERT_EQ(lowestBit(narrow), portable::lowestBit(narrow)) << narrow;
    ASSERT_EQ(highestBit(narrow), portable::highestBit(narrow)) << narrow;
    unsigned int count = 0;
    for (std::uint64_t rest = bits; rest != 0; rest >>= 1)
      count += rest & 1;
    ASSERT_EQ(bitCount(bits), count) << bits;
  }
}

TEST(BitOperations, AnyAddressCanBePrefetched)
{
  const int here = 1;
  prefetch(&here);
  prefetch(&here + 1);
  prefetch(nullptr);
  EXPECT_EQ(here, 1);
}

} // namespace
