// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "simulator/labelled_lidar.h"
#include "simulator/labelled_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <vector>

namespace {

using namespace pcl_ext;
using noise::VoxelTruth;

struct Case {
  noise::Law law;
  float threshold;
  double most_noise;   ///< kept
  double least_others; ///< kept
};

TEST(VoxelOutlierRemovalInTheCell, SeparatesNoiseFromMovingSurfaces)
{
  using noise::Law;
  const std::map<double, std::vector<Case>> cases = {
      {0.04,
       {{Law::Quadratic, 0.0f, 0.2, 0.98},
        {Law::Quadratic, 2.2f, 0.09, 0.92},
        {Law::Linear, 0.0f, 0.2, 0.98},
        {Law::Linear, 2.2f, 0.09, 0.92},
        {Law::Count, 0.0f, 0.2, 0.95}}},
      {0.02, {{Law::Quadratic, 0.0f, 0.25, 0.97}}},
      {0.01, {{Law::Quadratic, 0.0f, 0.3, 0.97}}}};
  for (const auto& [edge, of_edge] : cases) {
    SCOPED_TRACE(edge);
    noise::LabelledStream stream(1, 1, edge);
    std::vector<VoxelOutlierRemoval> removals;
    for (const Case& one : of_edge)
      removals.emplace_back(
          VoxelOutlierRemovalSettings{densityUnitSettings(densityUnitOf(one.law))});
    std::array<double, 4> all{};
    std::vector<std::array<double, 4>> kept(of_edge.size());
    noise::LabelledFrame frame;
    std::vector<float> log_odds;
    for (std::uint32_t i = 0; i < 12; ++i) {
      // While the person walks and all arms move.
      stream.read(40 + i, frame);
      for (const VoxelTruth truth : frame.truth)
        all[static_cast<std::size_t>(truth)] += 1.0;
      for (std::size_t one = 0; one < of_edge.size(); ++one) {
        removals[one].score(frame.of(of_edge[one].law), log_odds);
        for (std::size_t voxel = 0; voxel < log_odds.size(); ++voxel)
          kept[one][static_cast<std::size_t>(frame.truth[voxel])] +=
              log_odds[voxel] < of_edge[one].threshold ? 0.0 : 1.0;
      }
    }
    for (std::size_t one = 0; one < of_edge.size(); ++one) {
      const auto share = [&](VoxelTruth truth) {
        EXPECT_GT(all[static_cast<std::size_t>(truth)], 500.0);
        return kept[one][static_cast<std::size_t>(truth)] /
               all[static_cast<std::size_t>(truth)];
      };
      EXPECT_LT(share(VoxelTruth::Noise), of_edge[one].most_noise) << one;
      for (const VoxelTruth truth :
           {VoxelTruth::Still, VoxelTruth::Machine, VoxelTruth::Person})
        EXPECT_GT(share(truth), of_edge[one].least_others) << one;
    }
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
