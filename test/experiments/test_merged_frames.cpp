#include "noise/merged_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace {

using namespace pcl_ext::noise;

/** \brief A camera's frame with counts; the other laws have ten times as much. */
LabelledFrame
frameOf(const std::vector<std::uint64_t>& keys,
        const std::vector<std::uint16_t>& counts,
        const std::vector<VoxelTruth>& truth)
{
  LabelledFrame frame;
  for (const Law law : camera_laws) {
    frame.of(law).grid.resolution = 0.04;
    frame.of(law).grid.first_index = {1, 2, 3};
    frame.of(law).keys = keys;
    for (const std::uint16_t count : counts)
      frame.of(law).intensities.push_back(
          law == Law::Count ? count : static_cast<std::uint16_t>(10 * count));
  }
  frame.truth = truth;
  frame.depth.assign(keys.size(), 5.0f);
  return frame;
}

TEST(MergedFrames, SumsWhatSensorsShare)
{
  LabelledFrame merged;
  mergeFrames({frameOf({1, 5}, {1, 2}, {VoxelTruth::Noise, VoxelTruth::Noise}),
               frameOf({5, 9}, {3, 4}, {VoxelTruth::Noise, VoxelTruth::Still}),
               frameOf({}, {}, {})},
              merged);
  for (const Law law : camera_laws) {
    EXPECT_EQ(merged.of(law).keys, (std::vector<std::uint64_t>{1, 5, 9}));
    EXPECT_EQ(merged.of(law).grid.first_index, (std::array<std::int32_t, 3>{1, 2, 3}));
    EXPECT_FALSE(merged.of(law).depth_model.has_value());
  }
  EXPECT_EQ(merged.of(Law::Count).intensities, (std::vector<std::uint16_t>{1, 5, 4}));
  EXPECT_EQ(merged.of(Law::Linear).intensities,
            (std::vector<std::uint16_t>{10, 50, 40}));
  EXPECT_EQ(merged.depth, (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(merged.truth,
            (std::vector<VoxelTruth>{
                VoxelTruth::Noise, VoxelTruth::Noise, VoxelTruth::Still}));
}

TEST(MergedFrames, NoiseIsWhatIsNoiseForAll)
{
  // From what decides last to what decides first.
  const std::vector<VoxelTruth> ranks = {
      VoxelTruth::Noise, VoxelTruth::Machine, VoxelTruth::Person, VoxelTruth::Still};
  for (std::size_t one = 0; one < ranks.size(); ++one)
    for (std::size_t other = 0; other < ranks.size(); ++other) {
      LabelledFrame merged;
      mergeFrames({frameOf({7}, {1}, {ranks[one]}), frameOf({7}, {1}, {ranks[other]})},
                  merged);
      EXPECT_EQ(merged.truth.front(), ranks[std::max(one, other)])
          << one << ", " << other;
    }
}

TEST(MergedFrames, ForgetsTheFrameBefore)
{
  LabelledFrame merged;
  mergeFrames({frameOf({1, 5}, {1, 2}, {VoxelTruth::Still, VoxelTruth::Still})},
              merged);
  mergeFrames({frameOf({5}, {3}, {VoxelTruth::Noise})}, merged);
  EXPECT_EQ(merged.of(Law::Count).intensities, (std::vector<std::uint16_t>{3}));
  EXPECT_EQ(merged.truth, (std::vector<VoxelTruth>{VoxelTruth::Noise}));
}

} // namespace
