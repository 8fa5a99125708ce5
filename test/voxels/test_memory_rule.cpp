// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "voxels/memory_rule.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace {

using pcl_ext::io::MemoryRule;

constexpr std::size_t large = 1000000;

/** \brief One letter for each frame: 'r' release, '.' keep. */
std::string
answersOf(MemoryRule& rule, const std::vector<std::size_t>& frames)
{
  std::string answers;
  for (const std::size_t needed : frames)
    answers += rule.shouldRelease(needed) ? 'r' : '.';
  return answers;
}

std::string
kept(std::size_t frames)
{
  return std::string(frames, '.');
}

TEST(MemoryRule, ReleasesWhenEightFramesNeededLessThanAQuarter)
{
  MemoryRule rule(0);
  EXPECT_EQ(answersOf(rule, {large}), ".");
  EXPECT_EQ(answersOf(rule, std::vector<std::size_t>(8, large / 4 - 1)), ".......r");
  // What is left is right for them.
  EXPECT_EQ(answersOf(rule, std::vector<std::size_t>(40, large / 4 - 1)), kept(40));
}

TEST(MemoryRule, OneFrameOfEightKeepsTheMemory)
{
  MemoryRule rule(0);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < 80; ++i)
    frames.push_back(i % 8 == 0 ? large : 1);
  EXPECT_EQ(answersOf(rule, frames), kept(80));
  // With this one eight in a row did without.
  EXPECT_EQ(answersOf(rule, {1}), "r");
}

TEST(MemoryRule, NothingBelowTheFloorIsReleased)
{
  for (const bool is_default : {false, true}) {
    MemoryRule rule = is_default ? MemoryRule() : MemoryRule(large);
    std::vector<std::size_t> frames(30, 0);
    frames.front() = is_default ? 65536 : large;
    EXPECT_EQ(answersOf(rule, frames), kept(30));
    ++frames.front();
    EXPECT_EQ(answersOf(rule, frames), kept(8) + "r" + kept(21));
  }
}

TEST(MemoryRule, TheLargestNumbersDoNotOverflow)
{
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  MemoryRule rule(0);
  std::vector<std::size_t> frames(20, most / 2 + 2);
  frames.front() = most;
  EXPECT_EQ(answersOf(rule, frames), kept(20));
}

} // namespace
