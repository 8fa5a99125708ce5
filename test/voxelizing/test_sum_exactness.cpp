// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sum_exactness.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace {

using pcl_ext::io::SumExactness;

bool
areExact(const std::vector<float>& numbers, std::uint64_t summands, bool are_whole)
{
  SumExactness exactness;
  exactness.add(numbers.data(), numbers.size(), are_whole);
  return exactness.areExact(summands);
}

constexpr std::uint64_t most_points = 0xffffffff;

TEST(SumExactness, WholeNumbersAreExactUpTo2To53)
{
  EXPECT_TRUE(areExact({0.0f, 65535.0f, 1.0f}, most_points, true));
  // Below 2^23: 2^30 of them are below 2^53.
  EXPECT_TRUE(areExact({8388607.0f}, (1u << 30) - 1, true));
  EXPECT_FALSE(areExact({8388607.0f}, 1u << 30, true));
  EXPECT_TRUE(areExact({-3.0f, 0.0f}, most_points, true));
}

TEST(SumExactness, FractionsAreExactWhereTheirRangeLeavesBits)
{
  // Multiples of 2^-24 below 1, of which 2^53 steps are 2^29.
  EXPECT_TRUE(areExact({0.5f, 0.999f}, (1u << 29) - 1, false));
  EXPECT_FALSE(areExact({0.5f, 0.999f}, 1u << 29, false));
  // 2^10 more for the smallest.
  EXPECT_TRUE(areExact({-0x1p-11f, 0.999f, 0.0f}, (1u << 19) - 1, false));
  EXPECT_FALSE(areExact({-0x1p-11f, 0.999f, 0.0f}, 1u << 19, false));
  EXPECT_FALSE(areExact({0.999f, 1e-20f}, 2, false));
  EXPECT_FALSE(areExact({1e30f, 1e-30f}, 2, false));
  EXPECT_FALSE(areExact(
      {std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max()},
      2,
      false));
}

TEST(SumExactness, ZerosCountAsNothing)
{
  EXPECT_TRUE(areExact({}, most_points, true));
  EXPECT_TRUE(areExact({0.0f, -0.0f}, 1u << 28, false));
  EXPECT_TRUE(areExact({0.0f, 0.75f}, (1u << 29) - 1, false));
}

TEST(SumExactness, SeveralInstancesAreAsOne)
{
  const std::vector<float> fractions{0.001f};
  const std::vector<float> whole{4000000.0f};
  SumExactness sum;
  sum.add(fractions.data(), 1, false);
  SumExactness other;
  other.add(whole.data(), 1, true);
  EXPECT_TRUE(sum.areExact(1u << 20));
  EXPECT_TRUE(other.areExact(1u << 20));
  sum.add(other);
  EXPECT_FALSE(sum.areExact(1u << 20));
  SumExactness both;
  both.add(whole.data(), 1, true);
  both.add(fractions.data(), 1, false);
  EXPECT_FALSE(both.areExact(1u << 20));
  // Whole numbers of one part alone are whole for all of them.
  SumExactness whole_parts;
  whole_parts.add(other);
  EXPECT_TRUE(whole_parts.areExact(1u << 30));
}

} // namespace
