// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simd/lanes.h"
#include "simd/lanes_computation.h"
#include "simd/vector_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace {

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

} // namespace
