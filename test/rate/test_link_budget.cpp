// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/link_budget.h"
#include "support/checked_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

namespace {

namespace link_budget {

using namespace std::chrono_literals;
using pcl_ext::io::LinkBudget;
using pcl_ext::io::test::CheckedLink;

TEST(LinkBudget, RoomIsThatOfTheSecondAndOfTheBuffer)
{
  LinkBudget budget(0.25);
  budget.setRate(80000.0); // 10 bytes a millisecond
  EXPECT_TRUE(budget.isEmpty());
  EXPECT_EQ(budget.room(), 2500u);
  budget.add(2500);
  EXPECT_EQ(budget.room(), 0u);
  EXPECT_EQ(budget.load(), 0.25);
  budget.advance(100ms);
  EXPECT_EQ(budget.room(), 1000u);
  budget.add(999);
  EXPECT_EQ(budget.room(), 1u);
  budget.advance(250ms);
  EXPECT_EQ(budget.room(), 2500u);
  EXPECT_FALSE(budget.isEmpty());
  budget.advance(649ms);
  EXPECT_NEAR(budget.load(), 0.3499, 1e-12);
  budget.advance(1ms); // the first frame is a second old
  EXPECT_NEAR(budget.load(), 0.0999, 1e-12);
  budget.advance(100ms);
  EXPECT_TRUE(budget.isEmpty());
}

TEST(LinkBudget, ALargeBufferTakesASecondAtOnceAndThenNothingForASecond)
{
  LinkBudget budget(1.0);
  budget.setRate(80000.0);
  budget.add(10000);
  budget.advance(999999999ns);
  EXPECT_EQ(budget.room(), 0u);
  budget.advance(1ns);
  EXPECT_EQ(budget.room(), 10000u);
}

TEST(LinkBudget, WhatWaitsIsSentAtAChangedRate)
{
  LinkBudget budget(0.25);
  budget.setRate(80000.0);
  budget.add(2500);
  budget.setRate(40000.0);
  budget.advance(250ms);
  EXPECT_EQ(budget.room(), 0u); // 1250 bytes wait
  budget.advance(125ms);
  EXPECT_EQ(budget.room(), 625u);
  budget.setRate(160000.0);
  EXPECT_EQ(budget.room(), 4375u);
}

TEST(LinkBudget, NoSecondTakesMoreThanItsBitsAndTheBufferNeverOverflows)
{
  std::size_t frames = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const auto rate = [&] {
      return std::round(std::pow(10.0, 3.0 + 9.0 * share(random)));
    };
    const double buffer =
        seed % 3 == 0 ? 1.0
                      : 0.001 * std::round(std::pow(10.0, 1.0 + 2.0 * share(random)));
    const bool does_rate_change = seed % 2 == 0;
    const double first_rate = rate();
    LinkBudget budget(buffer);
    budget.setRate(first_rate);
    CheckedLink link(first_rate, buffer);
    std::exponential_distribution<double> interval(1.0 / 0.05);
    for (int i = 0; i < 400 && !::testing::Test::HasFailure(); ++i) {
      const std::chrono::nanoseconds elapsed(
          i % 5 == 0 ? 0 : static_cast<std::int64_t>(1e9 * interval(random)));
      budget.advance(elapsed);
      link.advance(elapsed);
      if (does_rate_change && i % 20 == 0) {
        const double changed = rate();
        budget.setRate(changed);
        link.setRate(changed);
      }
      const std::size_t room = budget.room();
      const auto bytes =
          i % 3 == 0
              ? room
              : static_cast<std::size_t>(share(random) * static_cast<double>(room));
      budget.add(bytes);
      link.add(bytes);
    }
    frames += link.frames();
    ASSERT_FALSE(::testing::Test::HasFailure()) << seed;
  }
  EXPECT_GT(frames, 10000u);
}

} // namespace link_budget

} // namespace
