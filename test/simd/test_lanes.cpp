// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simd/bit_operations.h"
#include "simd/lanes.h"
#include "simd/lanes_computation.h"
#include "simd/symbol_lanes.h"
#include "simd/vector_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace {

using namespace pcl_ext;
using pcl_ext::NativeLanes;
using pcl_ext::ScalarLanes;
using pcl_ext::test::computeWithLanes;
using pcl_ext::test::LanesInput;

LanesInput
anyInput(std::mt19937_64& random)
{
  const std::array<float, 8> special{0.0f,
                                     -0.0f,
                                     std::numeric_limits<float>::infinity(),
                                     -std::numeric_limits<float>::infinity(),
                                     std::numeric_limits<float>::quiet_NaN(),
                                     std::numeric_limits<float>::max(),
                                     std::numeric_limits<float>::denorm_min(),
                                     0.5f};
  LanesInput input;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    float& value = input.points[i];
    const auto bits = static_cast<std::uint32_t>(random());
    std::memcpy(&value, &bits, sizeof(value));
    if (random() % 3 == 0)
      value = special[random() % special.size()];
    else if (random() % 2 == 0)
      value = static_cast<float>(static_cast<std::int32_t>(bits)) * 0x1p-16f;
    input.small_points[i] = std::isnan(value) ? -1e6f : std::clamp(value, -1e6f, 1e6f);
  }
  return input;
}

TEST(Lanes, NativeLanesAgreeWithScalarLanesToTheLastBit)
{
  std::mt19937_64 random(1);
  for (int i = 0; i < 10000; ++i) {
    const LanesInput input = anyInput(random);
    ASSERT_TRUE(computeWithLanes<NativeLanes>(input) ==
                computeWithLanes<ScalarLanes>(input))
        << "of round " << i;
    std::array<std::uint8_t, 16> bytes;
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random() % 3 == 0 ? 1u << random() % 8 : 0);
    ASSERT_EQ(NativeLanes::nonZeroBytes(bytes.data()),
              ScalarLanes::nonZeroBytes(bytes.data()));
  }
}

#if PCL_EXT_HAS_AVX2
TEST(Lanes, Avx2LanesAgreeWithScalarLanesToTheLastBit)
{
  if (!pcl_ext::hasAvx2())
    GTEST_SKIP() << "this machine has no AVX2";
  std::mt19937_64 random(2);
  for (int i = 0; i < 10000; ++i) {
    const LanesInput input = anyInput(random);
    ASSERT_TRUE(pcl_ext::test::computeWithAvx2(input) ==
                computeWithLanes<ScalarLanes>(input))
        << "of round " << i;
  }
}
#endif

struct alignas(16) Sixteen {
  std::array<std::uint16_t, 16> ends{};
  std::array<std::uint8_t, 16> counts{};
};

/** \brief Ascending ends, some of them as close as a symbol's least width. */
Sixteen
randomEnds(std::mt19937& random)
{
  Sixteen sixteen;
  const unsigned int spread = 1 + random() % 2048;
  std::uint32_t end = 0;
  for (std::uint16_t& value : sixteen.ends)
    value = static_cast<std::uint16_t>(
        end += 8 + static_cast<std::uint32_t>(random() % spread % 2000));
  sixteen.ends[15] = 1u << 15;
  return sixteen;
}

TEST(SymbolLanes, TheFirstEndAboveIsFound)
{
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    const Sixteen sixteen = randomEnds(random);
    for (std::uint32_t number = 0; number < 1u << 15;
         number += 1 + static_cast<std::uint32_t>(random() % 40)) {
      const auto expected = static_cast<unsigned int>(
          std::upper_bound(sixteen.ends.begin(), sixteen.ends.end(), number) -
          sixteen.ends.begin());
      ASSERT_EQ((firstAbove<0, 0>(sixteen.ends.data(), number)), expected);
      ASSERT_EQ(portable::firstAbove(sixteen.ends.data(), number), expected);
      if (number % 8 == 7) {
        ASSERT_EQ((firstAbove<3, 7>(sixteen.ends.data(), number / 8)), expected);
      }
    }
    for (const std::uint16_t end : sixteen.ends)
      for (const std::uint32_t number : {end - 1u, std::min(end + 0u, 0x7fffu)})
        ASSERT_EQ((firstAbove<0, 0>(sixteen.ends.data(), number)),
                  portable::firstAbove(sixteen.ends.data(), number));
  }
}

TEST(SymbolLanes, EndsMoveTowardsWhatWasCounted)
{
  std::mt19937 random(2);
  for (const unsigned int period_log2 : {2u, 3u, 4u, 5u})
    for (int round = 0; round < 2000; ++round) {
      Sixteen native = randomEnds(random);
      for (int i = 0; i < 1 << period_log2; ++i)
        ++native.counts[round % 3 == 0 ? round % 16 : random() % 16];
      Sixteen plain = native;
      Sixteen expected = native;
      const std::int32_t unit = 32640 >> period_log2;
      const unsigned int shift = 1 + random() % 2;
      std::int32_t sum = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        sum += native.counts[i];
        const std::int32_t way =
            8 * static_cast<std::int32_t>(i + 1) + sum * unit - native.ends[i];
        expected.ends[i] = static_cast<std::uint16_t>(native.ends[i] + (way >> shift));
      }
      expected.counts.fill(0);
      moveEnds(
          native.ends.data(), native.counts.data(), 8, 32640 >> period_log2, shift);
      portable::moveEnds(
          plain.ends.data(), plain.counts.data(), 8, 32640 >> period_log2, shift);
      ASSERT_EQ(native.ends, expected.ends);
      ASSERT_EQ(native.counts, expected.counts);
      ASSERT_EQ(plain.ends, expected.ends);
      ASSERT_EQ(plain.counts, expected.counts);
      ASSERT_EQ(native.ends[15], 1u << 15);
    }
}

template <class Number>
void
expectSums(std::mt19937_64& random)
{
  std::array<std::uint8_t, 8> bytes;
  for (std::uint8_t& byte : bytes)
    byte = static_cast<std::uint8_t>(random());
  const auto number = static_cast<Number>(random());
  std::array<Number, 8> sums{};
  std::array<Number, 8> portable_sums{};
  addToBytes(bytes.data(), number, sums.data());
  portable::addToBytes(bytes.data(), number, portable_sums.data());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    ASSERT_EQ(sums[i], static_cast<Number>(number + bytes[i]));
    ASSERT_EQ(portable_sums[i], sums[i]);
  }
}

TEST(SymbolLanes, ANumberIsAddedToEachByte)
{
  std::mt19937_64 random(3);
  for (int round = 0; round < 1000; ++round) {
    expectSums<std::uint32_t>(random);
    expectSums<std::uint64_t>(random);
  }
}

TEST(BitOperations, BuiltinsAgreeWithPortableCode)
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

TEST(BitOperations, ReplacesBelowALimitOnly)
{
  const std::uint8_t bytes[2] = {};
  const auto expect_replaced_below = [&bytes](std::uint32_t limit,
                                              std::uint32_t number) {
    std::uint32_t native = number;
    std::uint32_t plain = number;
    const std::uint8_t* native_pointer = bytes;
    const std::uint8_t* plain_pointer = bytes;
    replaceIfBelow(limit, native, 7, native_pointer, bytes + 1);
    portable::replaceIfBelow(limit, plain, 7, plain_pointer, bytes + 1);
    EXPECT_EQ(native, number < limit ? 7 : number);
    EXPECT_EQ(native_pointer, number < limit ? bytes + 1 : bytes);
    EXPECT_EQ(plain, native);
    EXPECT_EQ(plain_pointer, native_pointer);
  };
  // Two lists, as a constant limit is another operand than a variable one.
  constexpr std::uint32_t constant = 1u << 15;
  for (const std::uint32_t number : {0u,
                                     1u,
                                     constant - 1,
                                     constant,
                                     constant + 1,
                                     0x7fffffffu,
                                     0x80000000u,
                                     0xffffffffu})
    expect_replaced_below(constant, number);
  for (const std::uint32_t limit : {8u, 4095u << 3, 0x80000000u, 0xffffffffu})
    for (const std::uint32_t number : {0u, limit - 1, limit, limit + 1, 0xffffffffu})
      expect_replaced_below(limit, number);
}

} // namespace
