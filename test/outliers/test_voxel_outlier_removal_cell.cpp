// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "simulator/labelled_lidar.h"
#include "simulator/labelled_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext;
using noise::VoxelTruth;

std::array<double, 4>
keptOf(noise::Law law, double resolution, float min_log_odds)
{
  constexpr std::uint32_t frames = 12;
  noise::LabelledStream stream(1, 1, resolution);
  VoxelOutlierRemoval removal({densityUnitSettings(densityUnitOf(law)), min_log_odds});
  std::array<double, 4> all{};
  std::array<double, 4> kept{};
  noise::LabelledFrame frame;
  std::vector<float> log_odds;
  for (std::uint32_t i = 0; i < frames; ++i) {
    // While the person walks and all arms move.
    stream.read(40 + i, frame);
    removal.score(frame.of(law), log_odds);
    for (std::size_t voxel = 0; voxel < log_odds.size(); ++voxel) {
      const auto truth = static_cast<std::size_t>(frame.truth[voxel]);
      all[truth] += 1.0;
      kept[truth] += log_odds[voxel] < min_log_odds ? 0.0 : 1.0;
    }
  }
  for (std::size_t truth = 0; truth < 4; ++truth) {
    EXPECT_GT(all[truth], 500.0);
    kept[truth] /= all[truth];
  }
  return kept;
}

TEST(VoxelOutlierRemovalInTheCell, SeparatesNoiseFromMovingSurfaces)
{
  using noise::Law;
  // Law, voxel edge, threshold; most of the noise, least of the surfaces that is kept.
  const std::tuple<Law, double, float, double, double> cases[] = {
      {Law::Quadratic, 0.04, 0.0f, 0.2, 0.98},
      {Law::Quadratic, 0.04, 2.2f, 0.09, 0.92},
      {Law::Linear, 0.04, 0.0f, 0.2, 0.98},
      {Law::Linear, 0.04, 2.2f, 0.09, 0.92},
      {Law::Count, 0.04, 0.0f, 0.2, 0.95},
      {Law::Quadratic, 0.02, 0.0f, 0.25, 0.97},
      {Law::Quadratic, 0.01, 0.0f, 0.3, 0.97}};
  for (const auto& [law, edge, threshold, most_noise, least] : cases) {
    SCOPED_TRACE(edge);
    const auto kept = keptOf(law, edge, threshold);
    EXPECT_LT(kept[static_cast<std::size_t>(VoxelTruth::Noise)], most_noise);
    EXPECT_GT(kept[static_cast<std::size_t>(VoxelTruth::Still)], least);
    EXPECT_GT(kept[static_cast<std::size_t>(VoxelTruth::Machine)], least);
    EXPECT_GT(kept[static_cast<std::size_t>(VoxelTruth::Person)], least);
  }
}

TEST(VoxelOutlierRemovalInTheCell, ALidarsSurfacesStay)
{
  for (const double resolution : {0.04, 0.1, 0.2}) {
    noise::LabelledLidar stream(1, resolution);
    VoxelOutlierRemoval removal;
    noise::LabelledFrame frame;
    std::array<double, 2> all{};
    std::array<double, 2> removed{}; // above log-odds 0, and of noise at 2
    std::vector<float> log_odds;
    for (std::uint32_t i = 0; i < 40; ++i) {
      stream.read(i, frame);
      EXPECT_TRUE(removal.score(frame.of(noise::Law::Native), log_odds).ok());
      for (std::size_t voxel = 0; voxel < log_odds.size(); ++voxel) {
        const bool is_noise = frame.truth[voxel] == VoxelTruth::Noise;
        all[is_noise ? 1 : 0] += 1.0;
        removed[is_noise ? 1 : 0] +=
            log_odds[voxel] < (is_noise ? 2.0f : 0.0f) ? 1.0 : 0.0;
      }
    }
    EXPECT_LT(removed[0], 0.003 * all[0]) << resolution;
    EXPECT_GT(removed[1], 0.2 * all[1]) << resolution;
  }
}

} // namespace
