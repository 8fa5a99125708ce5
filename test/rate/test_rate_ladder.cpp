// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/rate_ladder.h"
#include "rate/rate_texts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace {

namespace rate_ladder {

using namespace pcl_ext::io;
using Texts = std::vector<std::string>;

EncoderSettings
limitedSettings()
{
  EncoderSettings settings;
  settings.max_rate = 1e6;
  settings.rate_doublings = 1;
  return settings;
}

Texts
stepsOf(const EncoderSettings& settings,
        bool has_intensities = true,
        bool can_remove_outliers = false,
        const std::optional<float>& min_log_odds = std::nullopt)
{
  const RateLadder ladder(settings, has_intensities, can_remove_outliers, min_log_odds);
  Texts texts;
  for (std::size_t i = 0; i < ladder.size(); ++i)
    texts.push_back(stepText(
        ladder[i],
        std::ldexp(settings.resolution, static_cast<int>(ladder[i].doublings))));
  return texts;
}

TEST(RateLadder, StepsAreOrderedByQuality)
{
  EncoderSettings settings = limitedSettings();
  settings.max_encode_ms = 50.0;
  settings.effort = Effort::Fast;
  settings.rate_temporal_filter = 16;
  settings.rate_doublings = 2;
  EXPECT_EQ(
      stepsOf(settings, true, true, -2.0f),
      (Texts{"voxels of 0.01 m, effort fast, outliers removed at -2",
             "voxels of 0.01 m, effort balanced, outliers removed at -2",
             "voxels of 0.01 m, effort small, outliers removed at -2",
             "voxels of 0.01 m, effort small, temporal filter of 8, outliers removed "
             "at -2",
             "voxels of 0.01 m, effort small, temporal filter of 16, outliers removed "
             "at -2",
             "voxels of 0.01 m, effort small, temporal filter of 16, 4 companded bits, "
             "outliers removed at -2",
             "voxels of 0.01 m, effort small, temporal filter of 16, 4 companded bits, "
             "outliers removed at 0",
             "voxels of 0.02 m, effort small, temporal filter of 16, 4 companded bits, "
             "outliers removed at 0",
             "voxels of 0.04 m, effort small, temporal filter of 16, 4 companded bits, "
             "outliers removed at 0"}));
}

TEST(RateLadder, EffortsRiseWithALimitOfTimeOnly)
{
  EncoderSettings settings = limitedSettings();
  settings.rate_temporal_filter = 0;
  const Texts steps{"voxels of 0.01 m, effort fast", "voxels of 0.02 m, effort fast"};
  EXPECT_EQ(stepsOf(settings, false), steps);
  settings.max_rate = 0.0;
  settings.max_encode_ms = 50.0;
  EXPECT_EQ(stepsOf(settings, true, true), steps);
}

TEST(RateLadder, PointsAndFieldsHaveNoTemporalFilter)
{
  const Texts steps{"voxels of 0.01 m, effort fast",
                    "voxels of 0.01 m, effort fast, 4 companded bits",
                    "voxels of 0.02 m, effort fast, 4 companded bits"};
  EncoderSettings settings = limitedSettings();
  settings.keep_points = true;
  EXPECT_EQ(stepsOf(settings), steps);
  settings = limitedSettings();
  settings.fields = {{"ring"}};
  EXPECT_EQ(stepsOf(settings), steps);
}

TEST(RateLadder, WhatIsSetAlreadyIsNoStep)
{
  EncoderSettings settings = limitedSettings();
  settings.temporal_filter = 8;
  settings.intensity_bits = 4;
  EXPECT_EQ(stepsOf(settings, true, true, 0.0f),
            (Texts{"voxels of 0.01 m, effort fast, temporal filter of 8, outliers "
                   "removed at 0",
                   "voxels of 0.02 m, effort fast, temporal filter of 8, outliers "
                   "removed at 0"}));
  settings.rate_doublings = 0;
  settings.temporal_filter = 12;
  settings.rate_temporal_filter = 10;
  settings.intensity_bits = 5;
  EXPECT_EQ(stepsOf(settings, true, true, -1.0f),
            (Texts{"voxels of 0.01 m, effort fast, temporal filter of 12, outliers "
                   "removed at -1",
                   "voxels of 0.01 m, effort fast, temporal filter of 12, 4 "
                   "companded bits, outliers removed at -1",
                   "voxels of 0.01 m, effort fast, temporal filter of 12, 4 "
                   "companded bits, outliers removed at 0"}));
}

TEST(RateLadder, PublishedFramesHaveNoCompandedBitsAndNoEffort)
{
  EncoderSettings settings = limitedSettings();
  settings.format = StreamFormat::Published;
  settings.max_encode_ms = 50.0;
  EXPECT_EQ(stepsOf(settings),
            (Texts{"voxels of 0.01 m, effort fast",
                   "voxels of 0.01 m, effort fast, temporal filter of 8",
                   "voxels of 0.02 m, effort fast, temporal filter of 8"}));
}

TEST(RateLadder, VoxelsEndWithTheirRangeAndOutlierRemovalWithIts)
{
  EncoderSettings settings = limitedSettings();
  settings.rate_temporal_filter = 0;
  settings.rate_doublings = 8;
  settings.resolution = 3e5;
  EXPECT_EQ(
      stepsOf(settings, false, true),
      (Texts{"voxels of 300000 m, effort fast", "voxels of 600000 m, effort fast"}));
  settings.resolution = 0.15;
  settings.rate_doublings = 1;
  EXPECT_EQ(stepsOf(settings, false, true, 0.0f),
            (Texts{"voxels of 0.15 m, effort fast, outliers removed at 0",
                   "voxels of 0.3 m, effort fast"}));
  // What is off stays off.
  EXPECT_EQ(stepsOf(settings, false, true),
            (Texts{"voxels of 0.15 m, effort fast", "voxels of 0.3 m, effort fast"}));
}

TEST(RateLadder, SavingsAreLearnedFromWhatTheStreamTook)
{
  EncoderSettings settings = limitedSettings();
  settings.rate_doublings = 3;
  RateLadder ladder(settings, false, false, std::nullopt); // with the temporal filter
  ASSERT_EQ(ladder.size(), 5u);
  EXPECT_FALSE(ladder.isLearned(1, 0));
  ladder.learn(0, 1, {0.8, 0.5});
  EXPECT_TRUE(ladder.isLearned(1, 0));
  EXPECT_FALSE(ladder.isLearned(2, 0));
  EXPECT_NEAR(ladder.ratios(0, 1).i_frame, 0.8, 1e-12);
  EXPECT_NEAR(ladder.ratios(1, 0).p_frame, 2.0, 1e-12);
  // Of several steps, in either direction.
  ladder.learn(3, 0, {10.0, 20.0});
  EXPECT_TRUE(ladder.isLearned(3, 0));
  EXPECT_NEAR(ladder.ratios(0, 3).i_frame, 0.1, 1e-12);
  EXPECT_NEAR(ladder.ratios(3, 0).p_frame, 20.0, 1e-9);
  // No step takes more than a better one.
  ladder.learn(0, 1, {2.0, 2.0});
  EXPECT_EQ(ladder.ratios(0, 1).p_frame, 1.0);
}

TEST(RateLadder, WhereTheSensorMovesTheTemporalFilterIsNoStep)
{
  EncoderSettings settings = limitedSettings();
  settings.intensity_bits = 4;
  RateLadder ladder(settings, true, false, std::nullopt); // filter, edge
  ASSERT_EQ(ladder.size(), 3u);
  const double doubling = ladder.ratios(1, 2).p_frame;
  EXPECT_LT(ladder.ratios(0, 1).p_frame, 0.5);
  EXPECT_FALSE(ladder.isLearned(1, 0));
  EXPECT_EQ(ladder.inForce(2).temporal_filter, 8u);
  ladder.setFilterIdle(true);
  EXPECT_EQ(ladder.ratios(0, 1).p_frame, 1.0);
  EXPECT_EQ(ladder.ratios(0, 2).p_frame, doubling);
  EXPECT_TRUE(ladder.isLearned(1, 0));
  EXPECT_EQ(ladder.inForce(2).temporal_filter, 0u);
  EXPECT_EQ(ladder.inForce(2).doublings, 1u);
  // What is seen is the edge's alone.
  ladder.learn(0, 2, {0.5, 0.4});
  EXPECT_NEAR(ladder.ratios(1, 2).p_frame, 0.4, 1e-12);
  ladder.setFilterIdle(false);
  EXPECT_LT(ladder.ratios(0, 1).p_frame, 0.5);
}

TEST(RateLadder, AFilterThatWasNotAskedForHoldsNothing)
{
  EncoderSettings settings = limitedSettings();
  const auto holdsOf = [&settings](unsigned int temporal_filter) {
    RateStep step;
    step.temporal_filter = temporal_filter;
    return settingsOf(step, settings, std::nullopt).temporal_filter_holds;
  };
  EXPECT_FALSE(holdsOf(8));
  EXPECT_TRUE(holdsOf(0));
  settings.temporal_filter = 4;
  EXPECT_TRUE(holdsOf(8));
}

} // namespace rate_ladder

} // namespace
