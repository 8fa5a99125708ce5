// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "noise/judged_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace {

using namespace pcl_ext::noise;

struct Voxel {
  float score;
  VoxelTruth truth;
};

void
add(const std::vector<Voxel>& voxels, ScoredVoxels& scored)
{
  std::vector<VoxelTruth> truth;
  std::vector<float> scores;
  for (const Voxel& voxel : voxels) {
    truth.push_back(voxel.truth);
    scores.push_back(voxel.score);
  }
  scored.add(truth, scores);
}

JudgedVoxels
judged(const std::vector<Voxel>& voxels)
{
  ScoredVoxels scored;
  add(voxels, scored);
  return JudgedVoxels(scored);
}

const std::vector<Voxel> mixed = {{1, VoxelTruth::Noise},
                                  {2, VoxelTruth::Still},
                                  {3, VoxelTruth::Noise},
                                  {4, VoxelTruth::Machine}};

TEST(JudgedVoxels, AreaUnderPrecisionOverRecall)
{
  // Recall 1/2 with precision 1, then the other half with 2/3.
  EXPECT_DOUBLE_EQ(judged(mixed).averagePrecision(), 0.5 * 1.0 + 0.5 * 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(judged(mixed).noiseShare(), 0.5);
}

TEST(JudgedVoxels, TheOrderOfVoxelsDoesNotMatter)
{
  std::vector<Voxel> reversed = mixed;
  std::reverse(reversed.begin(), reversed.end());
  EXPECT_DOUBLE_EQ(judged(reversed).averagePrecision(),
                   judged(mixed).averagePrecision());
  ScoredVoxels two_frames;
  add({reversed[0], reversed[1]}, two_frames);
  add({reversed[2], reversed[3]}, two_frames);
  EXPECT_DOUBLE_EQ(JudgedVoxels(two_frames).averagePrecision(),
                   judged(mixed).averagePrecision());
}

TEST(JudgedVoxels, VoxelsOfOneScoreCountTogether)
{
  const JudgedVoxels voxels = judged({{1, VoxelTruth::Noise},
                                      {1, VoxelTruth::Still},
                                      {1, VoxelTruth::Noise},
                                      {2, VoxelTruth::Still}});
  EXPECT_DOUBLE_EQ(voxels.averagePrecision(), 2.0 / 3.0);
  // A threshold of 2 is the lowest that removes anything, and it takes half.
  EXPECT_EQ(voxels.thresholdThatKeeps(0.5), 2.0f);
  EXPECT_EQ(voxels.thresholdThatKeeps(0.9), 1.0f);
  EXPECT_DOUBLE_EQ(voxels.at(1.0f).surface_kept, 1.0);
}

TEST(JudgedVoxels, DecisionsOfAThreshold)
{
  const Decision decision = judged(mixed).at(4.0f);
  EXPECT_EQ(decision.threshold, 4.0f);
  EXPECT_DOUBLE_EQ(decision.precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(decision.recall, 1.0);
  EXPECT_DOUBLE_EQ(decision.f1, 0.8);
  EXPECT_DOUBLE_EQ(decision.surface_kept, 0.5);
  EXPECT_DOUBLE_EQ(decision.kept[static_cast<std::size_t>(VoxelTruth::Noise)], 0.0);
  EXPECT_DOUBLE_EQ(decision.kept[static_cast<std::size_t>(VoxelTruth::Still)], 0.0);
  EXPECT_DOUBLE_EQ(decision.kept[static_cast<std::size_t>(VoxelTruth::Machine)], 1.0);
  EXPECT_TRUE(std::isnan(decision.kept[static_cast<std::size_t>(VoxelTruth::Person)]));
}

TEST(JudgedVoxels, ThresholdsThatAreWanted)
{
  // F1 is 2/3, 1/2, 4/5 and 2/3 where 1, 2, 3 and 4 voxels go.
  EXPECT_EQ(judged(mixed).bestThreshold(), 4.0f);
  EXPECT_EQ(judged(mixed).thresholdThatKeeps(1.0), 2.0f);
  EXPECT_EQ(judged(mixed).thresholdThatKeeps(0.5), 4.0f);
}

TEST(JudgedVoxels, PrecisionsOverRecall)
{
  const std::vector<double> wanted = {1.0, 1.0, 2.0 / 3.0, 2.0 / 3.0};
  EXPECT_EQ(judged(mixed).precisionsOverRecall(4), wanted);
}

TEST(JudgedVoxels, WithoutNoiseThereIsNothingToFind)
{
  const JudgedVoxels voxels = judged({{1, VoxelTruth::Still}, {2, VoxelTruth::Person}});
  EXPECT_TRUE(std::isnan(voxels.averagePrecision()));
  EXPECT_TRUE(std::isnan(voxels.at(2.0f).recall));
  EXPECT_DOUBLE_EQ(voxels.at(2.0f).precision, 0.0);
  EXPECT_TRUE(std::isnan(voxels.at(0.0f).precision));
  EXPECT_EQ(voxels.bestThreshold(), 0.0f);
  EXPECT_TRUE(voxels.precisionsOverRecall(4).empty());
  EXPECT_DOUBLE_EQ(voxels.noiseShare(), 0.0);
}

TEST(JudgedVoxels, WithoutSurfacesAnyThresholdIsValid)
{
  const JudgedVoxels voxels = judged({{1, VoxelTruth::Noise}, {2, VoxelTruth::Noise}});
  EXPECT_DOUBLE_EQ(voxels.averagePrecision(), 1.0);
  EXPECT_EQ(voxels.thresholdThatKeeps(0.95), std::numeric_limits<float>::infinity());
  EXPECT_EQ(voxels.bestThreshold(), std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(voxels.at(2.0f).surface_kept));
}

TEST(JudgedVoxels, ThePersonFrameByFrame)
{
  ScoredVoxels scored;
  std::vector<Voxel> voxels(least_person_voxels, Voxel{0, VoxelTruth::Person});
  for (std::size_t i = 0; i < voxels.size(); ++i)
    voxels[i].score = static_cast<float>(i);
  add(voxels, scored);
  for (Voxel& voxel : voxels)
    voxel.score = 100.0f;
  add(voxels, scored);
  // One voxel too few to judge this frame by.
  for (Voxel& voxel : voxels)
    voxel.score = 0.0f;
  voxels.back().truth = VoxelTruth::Still;
  add(voxels, scored);

  EXPECT_DOUBLE_EQ(JudgedVoxels(scored).at(5.0f).person_worst, 0.75);
  EXPECT_TRUE(std::isnan(judged(mixed).at(5.0f).person_worst));
}

} // namespace
