// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simd/symbol_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>

namespace {

using namespace pcl_ext;

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

} // namespace
