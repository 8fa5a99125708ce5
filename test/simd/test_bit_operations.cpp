// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simd/bit_operations.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace {

using namespace pcl_ext;

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
