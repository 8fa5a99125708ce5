// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Ends of the numbers that mixing has, which streams hardly reach.
 */
#include "codec/context/bit_mixer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>

namespace {

using namespace pcl_ext::io::context;

TEST(BitMixer, WeightsStayWithinEight)
{
  constexpr std::int32_t heaviest = 8 << 16;
  const std::array<std::int32_t, 2> stretched{2047, -2047};
  std::array<std::int32_t, 2> weights{};
  for (int i = 0; i < 1000; ++i)
    adaptWeights(weights.data(), stretched, 65000);
  EXPECT_EQ(weights[0], heaviest);
  EXPECT_EQ(weights[1], -heaviest);
  for (int i = 0; i < 1000; ++i)
    adaptWeights(weights.data(), stretched, -65000);
  EXPECT_EQ(weights[0], -heaviest);
  EXPECT_EQ(weights[1], heaviest);
  EXPECT_EQ(mix(weights.data(), stretched), -2 * 8 * 2047);
}

TEST(BitMixer, MixedNumbersAreHeldWithinTheTable)
{
  const LogisticTables& tables = logisticTables();
  EXPECT_EQ(tables.squash(2048), tables.squash(2047));
  EXPECT_EQ(tables.squash(-16 * 2047), tables.squash(-2047));
  EXPECT_EQ(tables.squash(2047) + tables.squash(-2047), 1 << 16);
  EXPECT_GT(tables.squash(-2047), 0);
}

} // namespace
