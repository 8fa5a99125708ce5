// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/float_values.h"
#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using pcl_ext::test::infinity;
using pcl_ext::test::not_a_number;

std::vector<std::pair<VoxelOutlierRemovalSettings, std::string>>
refusedSettings()
{
  std::vector<std::pair<VoxelOutlierRemovalSettings, std::string>> refused;
  const auto add = [&refused](const DensityUnitSettings& unit,
                              const std::string& message,
                              float min_log_odds = 0.0f) {
    refused.emplace_back(VoxelOutlierRemovalSettings{unit, min_log_odds}, message);
  };
  for (const auto& [number, text] : {std::pair(infinity, std::string("inf")),
                                     std::pair(-infinity, std::string("-inf")),
                                     std::pair(not_a_number, std::string("nan"))}) {
    add(AutomaticUnit(),
        "min_log_odds is " + text + "; it must be a finite number",
        number);
    add(RaysUnit{{{0.0, 0.0, double{number}}}},
        "sensor_position has " + text + "; it must be finite numbers");
  }
  for (const auto& [number, text] : {std::pair(0.0f, std::string("0")),
                                     std::pair(-1.0f, std::string("-1")),
                                     std::pair(infinity, std::string("inf")),
                                     std::pair(not_a_number, std::string("nan"))})
    add(FacesUnit{{}, number},
        "full_intensity is " + text + "; it must be a finite number above 0");
  for (const auto& [number, text] : {std::pair(0.0, std::string("0")),
                                     std::pair(0.000099, std::string("9.9e-05")),
                                     std::pair(1.00000001, std::string("1.00000001")),
                                     std::pair(-0.0035, std::string("-0.0035")),
                                     std::pair(std::nan(""), std::string("nan"))}) {
    const std::string message = text + "; it must be 0.0001 to 1 radians";
    add(RaysUnit{{}, number}, "azimuth_step is " + message);
    add(RaysUnit{{}, 0.0035, number}, "elevation_step is " + message);
  }
  return refused;
}

TEST(VoxelOutlierRemovalSettings, EndsOfTheRangesAreValid)
{
  VoxelOutlierRemovalSettings settings;
  EXPECT_TRUE(checkSettings(settings).ok());
  settings.max_blocks = 0;
  const std::array<double, 3> far = {
      0.0, std::numeric_limits<double>::lowest(), 1e-300};
  for (const float number :
       {std::numeric_limits<float>::lowest(), -1.0f, std::numeric_limits<float>::max()})
    for (const float full :
         {std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max()})
      for (const DensityUnitSettings& unit :
           {DensityUnitSettings(AutomaticUnit{{false}}),
            DensityUnitSettings(FacesUnit{{false}, full}),
            DensityUnitSettings(PointsUnit{{false}}),
            DensityUnitSettings(VoxelsUnit{{false}}),
            DensityUnitSettings(RaysUnit{far, 0.0001, 1.0})}) {
        settings.min_log_odds = number;
        settings.unit = unit;
        EXPECT_TRUE(checkSettings(settings).ok());
        EXPECT_EQ(checkSettings(settings).message(), "");
      }
}

TEST(VoxelOutlierRemovalSettings, EachLawHasAUnit)
{
  EXPECT_EQ(densityUnitOf(IntensityLaw::Count), DensityUnit::Points);
  EXPECT_EQ(densityUnitOf(IntensityLaw::Quadratic), DensityUnit::Faces);
  EXPECT_EQ(densityUnitOf(IntensityLaw::Linear), DensityUnit::Automatic);
  EXPECT_EQ(densityUnitOf(IntensityLaw::Native), DensityUnit::Voxels);
  EXPECT_EQ(densityUnitOf(IntensityLaw::None), DensityUnit::Voxels);
}

TEST(VoxelOutlierRemovalSettings, UnitsHaveTheirNamesAndWhatTheyShareWithAutomatic)
{
  for (const auto& [unit, name] : density_units)
    for (const bool is_changed : {false, true}) {
      SCOPED_TRACE(name);
      const DensityUnitSettings settings =
          densityUnitSettings(unit, {{!is_changed}, is_changed});
      EXPECT_EQ(densityUnitOf(settings), unit);
      EXPECT_EQ(settings == densityUnitSettings(unit), !is_changed);
    }
}

TEST(VoxelOutlierRemovalSettings, UnsupportedVoxelEdgesAreRefused)
{
  std::mt19937_64 random(16);
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  // At the ends less than a millionth is rounding.
  for (const auto& [edge, is_made_for] : {std::pair(0.0001, false),
                                          std::pair(0.000999, false),
                                          std::pair(0.0009999999, true),
                                          std::pair(0.01, true),
                                          std::pair(0.2, true),
                                          std::pair(0.20000001, true),
                                          std::pair(0.2001, false),
                                          std::pair(1e6, false)}) {
    SCOPED_TRACE(edge);
    EXPECT_EQ(VoxelOutlierRemoval::isMadeFor(edge), is_made_for);
    frame.grid.resolution = edge;
    VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Points);
    settings.min_log_odds = 1000.0f;
    VoxelOutlierRemoval removal(settings);
    io::VoxelFrame filtered = frame;
    const OutlierRemovalStatus status = removal.filter(filtered);
    EXPECT_EQ(status.removed, is_made_for ? frame.size() : 0u);
    EXPECT_EQ(status.code(),
              is_made_for ? OutlierRemovalCode::Ok
                          : OutlierRemovalCode::UnsupportedResolution);
    EXPECT_EQ(filtered.size(), is_made_for ? 0u : frame.size());
    std::vector<float> log_odds;
    EXPECT_EQ(removal.score(frame, log_odds).code(), status.code());
    for (const float score : log_odds)
      EXPECT_EQ(score == infinity, !is_made_for);
    EXPECT_EQ(removal.rememberedBlocks() == 0, !is_made_for);
  }
  frame.grid.resolution = 0.5;
  EXPECT_EQ(VoxelOutlierRemoval().filter(frame).message(),
            "no voxel was judged: the voxel edge is 0.5 m; it must be 0.001 to 0.2");
}

TEST(VoxelOutlierRemovalSettings, OutOfRangeIsRefusedForEachFrame)
{
  std::mt19937_64 random(15);
  const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  for (const auto& [settings, message] : refusedSettings()) {
    EXPECT_EQ(checkSettings(settings).message(), message);
    VoxelOutlierRemoval removal(settings);
    for (int i = 0; i < 2; ++i) {
      io::VoxelFrame filtered = frame;
      const OutlierRemovalStatus status = removal.filter(filtered);
      EXPECT_EQ(status.code(), OutlierRemovalCode::InvalidSettings);
      EXPECT_EQ(status.message(), message);
      EXPECT_EQ(status.removed, 0u);
      EXPECT_EQ(filtered.keys, frame.keys);
      EXPECT_EQ(filtered.intensities, frame.intensities);
      std::vector<float> log_odds = {1.0f};
      EXPECT_EQ(removal.score(frame, log_odds).code(), status.code());
      EXPECT_EQ(log_odds, std::vector<float>(frame.size(), infinity));
      EXPECT_EQ(removal.rememberedBlocks(), 0u);
    }
  }
}

TEST(VoxelOutlierRemovalSettings, UnitsNeedWhatTheyAreOf)
{
  std::mt19937_64 random(17);
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  frame.intensity_scale.bits = 0;
  frame.intensities.clear();
  io::VoxelFrame with_counts = frame;
  with_counts.has_point_counts = true;
  with_counts.point_counts.assign(frame.size(), 2);
  io::VoxelFrame of_points = frame;
  of_points.clearVoxels();
  of_points.points.width = static_cast<std::uint32_t>(frame.size());
  of_points.points.height = 1;
  for (std::uint32_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
    of_points.points.indices.push_back(i);
    of_points.points.positions.push_back({frame.grid.centre(0, at.x),
                                          frame.grid.centre(1, at.y),
                                          frame.grid.centre(2, at.z)});
  }
  for (const auto& [unit, judges_frame, judges_counts] :
       {std::tuple(DensityUnit::Automatic, true, true),
        std::tuple(DensityUnit::Faces, false, false),
        std::tuple(DensityUnit::Points, false, true),
        std::tuple(DensityUnit::Voxels, true, true)}) {
    const auto statusOf = [unit = unit](io::VoxelFrame filtered) {
      VoxelOutlierRemoval removal(settingsOf(unit));
      OutlierRemovalStatus status = removal.filter(filtered);
      EXPECT_EQ(status.ok(), removal.rememberedBlocks() > 0);
      return status;
    };
    EXPECT_EQ(statusOf(frame).code(),
              judges_frame ? OutlierRemovalCode::Ok : OutlierRemovalCode::NoDensities);
    for (const io::VoxelFrame* const counted : {&with_counts, &of_points})
      EXPECT_EQ(statusOf(*counted).code(),
                judges_counts ? OutlierRemovalCode::Ok
                              : OutlierRemovalCode::NoDensities);
  }
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Points));
  EXPECT_EQ(
      removal.filter(frame).message(),
      "no voxel was judged: the frame has no intensities, and unit is points; choose "
      "voxels or, for a lidar, rays, which need none");
}

TEST(VoxelOutlierRemovalSettings, AutomaticSaysThatIntensitiesWereNotUsed)
{
  std::mt19937_64 random(18);
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  std::vector<float> log_odds;
  VoxelOutlierRemoval automatic;
  const OutlierRemovalStatus status = automatic.score(frame, log_odds);
  EXPECT_TRUE(status.ok());
  EXPECT_NE(status.message().find("choose the unit points"), std::string::npos);
  io::VoxelFrame bare = frame;
  bare.intensities.clear();
  bare.intensity_scale.bits = 0;
  EXPECT_NE(VoxelOutlierRemoval()
                .score(bare, log_odds)
                .message()
                .find("points, as the frame has no intensities"),
            std::string::npos);
  for (const DensityUnit unit :
       {DensityUnit::Faces, DensityUnit::Points, DensityUnit::Voxels}) {
    VoxelOutlierRemoval named(settingsOf(unit));
    EXPECT_EQ(named.score(frame, log_odds).message(), "");
  }
  frame.depth_model = io::depthModelOf(
      {2, 14.57, 255.0}, {}, {1.0, 0.0, 0.0}, frame.grid, frame.intensity_scale);
  EXPECT_EQ(automatic.score(frame, log_odds).message(), "");
}

} // namespace
