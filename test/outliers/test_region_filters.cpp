/** \file
 * \brief Filters of frames with regions: coarse voxels are judged as a frame of voxels of
 * their edge.
 */
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using Centres = std::map<std::array<float, 3>, float>; // and their intensities

constexpr double coarse_edge = 0.04;

/** \brief A floor that is 4 m wide and deep, seen with a little noise, and as many
 * points in the air as `flying`. */
Cloud
floorCloud(std::uint64_t seed, int flying = 300)
{
  std::mt19937_64 random(seed);
  Cloud cloud;
  for (int i = 0; i < 40000; ++i)
    cloud.push_back({uniform(random, -2.0, 2.0),
                     uniform(random, -2.0, 2.0),
                     uniform(random, 0.012, 0.02)});
  for (int i = 0; i < flying; ++i)
    cloud.push_back({uniform(random, -2.0, 2.0),
                     uniform(random, -2.0, 2.0),
                     uniform(random, 0.5, 2.0)});
  return cloud;
}

BoundingBox
boxFrom(double lowest_x)
{
  return {{lowest_x, -8.0, -8.0}, {8.0, 8.0, 8.0}};
}

/** \brief Voxels of 1 cm, but from an x on those of 4 cm. */
IntensityCompressionSettings
coarseFrom(double x)
{
  IntensityCompressionSettings settings = settingsOf(coarse_edge / 4.0);
  settings.intensity_bits = 16;
  settings.regions.boxes = {{boxFrom(x), 2}, {boxFrom(-8.0), 0}};
  return settings;
}

IntensityCompressionSettings
uniformSettings(double resolution = coarse_edge)
{
  IntensityCompressionSettings settings = settingsOf(resolution);
  settings.intensity_bits = 16;
  return settings;
}

Centres
centresOf(const VoxelFrame& frame, double from_x = -8.0, double to_x = 8.0)
{
  Centres centres;
  forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    if (x > from_x && x < to_x)
      centres[{std::round(200 * x), std::round(200 * y), std::round(200 * z)}] =
          intensity;
  });
  return centres;
}

VoxelOutlierRemovalSettings
removalSettings(DensityUnit unit)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = unit;
  return settings;
}

TEST(RegionFilters, OutliersOfOneEdgeAreThoseOfAGridOfThatEdge)
{
  for (const DensityUnit unit : {DensityUnit::Points, DensityUnit::Voxels}) {
    VoxelOutlierRemoval of_regions(removalSettings(unit));
    VoxelOutlierRemoval of_grid(removalSettings(unit));
    Stream coarse(coarseFrom(-8.0));
    Stream plain(uniformSettings());
    for (std::uint64_t i = 1; i < 4; ++i) {
      coarse.add(floorCloud(i));
      plain.add(floorCloud(i));
      ASSERT_EQ(centresOf(coarse.frame), centresOf(plain.frame));
      const OutlierRemovalStatus status = of_regions.filter(coarse.frame);
      EXPECT_TRUE(status.ok()) << status.message();
      EXPECT_TRUE(unit == DensityUnit::Voxels || status.removed > 100);
      EXPECT_EQ(status.removed, of_grid.filter(plain.frame).removed);
      EXPECT_EQ(centresOf(coarse.frame), centresOf(plain.frame));
      EXPECT_TRUE(isConsistent(coarse.frame));
    }
    EXPECT_EQ(of_regions.rememberedBlocks(), of_grid.rememberedBlocks());
  }
}

TEST(RegionFilters, FinerNeighboursCountForCoarseVoxels)
{
  VoxelOutlierRemoval of_regions(removalSettings(DensityUnit::Points));
  VoxelOutlierRemoval of_grid(removalSettings(DensityUnit::Points));
  Stream mixed(coarseFrom(0.0));
  Stream plain(uniformSettings());
  std::vector<float> log_odds;
  std::vector<float> expected;
  mixed.add(floorCloud(1));
  plain.add(floorCloud(1));
  ASSERT_TRUE(of_regions.score(mixed.frame, log_odds).ok());
  ASSERT_TRUE(of_grid.score(plain.frame, expected).ok());
  std::map<LatticeIndex, float> of_plain; // by index
  for (std::size_t i = 0; i < plain.frame.size(); ++i)
    of_plain[latticeIndex(plain.frame, i)] = expected[i];
  const std::vector<std::uint8_t> levels = voxelLevels(mixed.frame);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < mixed.frame.size(); ++i)
    if (levels[i] == 2) {
      LatticeIndex index = latticeIndex(mixed.frame, i);
      for (std::int64_t& coordinate : index)
        coordinate = coordinate / 4;
      // Also of those beside the fine ones.
      EXPECT_EQ(log_odds[i], of_plain.at(index));
      ++compared;
    }
  EXPECT_GT(compared, 2000u);
}

TEST(RegionFilters, VoxelsThatAreTooCoarseToBeJudgedStayAndTheMessageSaysSo)
{
  IntensityCompressionSettings settings = settingsOf(0.05);
  settings.regions.boxes = {{boxFrom(0.0), 3}, {boxFrom(-8.0), 0}};
  Stream stream(settings);
  stream.add({{1.0f, 1.0f, 1.0f}, {-1.0f, 1.0f, 1.0f}, {-3.0f, 1.0f, 1.0f}});
  VoxelOutlierRemoval removal(removalSettings(DensityUnit::Points));
  const OutlierRemovalStatus status = removal.filter(stream.frame);
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.message(),
            "1 of 3 voxels were not judged: they are coarser than 0.2 m");
  EXPECT_EQ(status.removed, 2u);
  EXPECT_EQ(voxelLevels(stream.frame), (std::vector<std::uint8_t>{3}));
}

TEST(RegionFilters, OverTimeOneEdgeIsFilteredAsAGridOfThatEdge)
{
  TemporalVoxelFilter of_regions(8);
  TemporalVoxelFilter of_grid(8);
  Stream coarse(coarseFrom(-8.0));
  Stream plain(uniformSettings());
  const std::array<double, 3> sensor = {0.0, 0.0, 3.0};
  for (std::uint64_t i = 1; i < 12; ++i) {
    const Cloud cloud = floorCloud(i, i < 9 ? 300 : 0);
    coarse.add(cloud);
    plain.add(cloud);
    const TemporalFilterStatus status =
        of_regions.filter(coarse.frame, {sensor, std::nullopt});
    const TemporalFilterStatus expected =
        of_grid.filter(plain.frame, {sensor, std::nullopt});
    ASSERT_TRUE(status.ok());
    EXPECT_EQ(status.hidden, expected.hidden);
    EXPECT_EQ(status.held, expected.held);
    EXPECT_EQ(centresOf(coarse.frame), centresOf(plain.frame));
    EXPECT_TRUE(isConsistent(coarse.frame));
  }
  EXPECT_EQ(of_regions.rememberedVoxels(), of_grid.rememberedVoxels());
}

TEST(RegionFilters, OverTimeTheFineAndTheCoarsePartAreThoseOfTheirEdges)
{
  TemporalVoxelFilter of_regions(8);
  TemporalVoxelFilter of_fine(8);
  TemporalVoxelFilter of_coarse(8);
  Stream mixed(coarseFrom(0.0));
  Stream fine(uniformSettings(coarse_edge / 4.0));
  Stream coarse(uniformSettings());
  for (std::uint64_t i = 1; i < 12; ++i) {
    const Cloud cloud = floorCloud(i);
    for (Stream* stream : {&mixed, &fine, &coarse})
      stream->add(cloud);
    ASSERT_TRUE(of_regions.filter(mixed.frame).ok());
    ASSERT_TRUE(of_fine.filter(fine.frame).ok());
    ASSERT_TRUE(of_coarse.filter(coarse.frame).ok());
    // Fine voxels beside the border lack neighbours beyond it, and what is usual is
    // learned of the fine ones alone.
    const Centres of_mixed = centresOf(mixed.frame, -8.0, 0.0);
    const Centres expected = centresOf(fine.frame, -8.0, 0.0);
    std::size_t others = 0;
    for (const auto& voxel : of_mixed)
      others += expected.count(voxel.first) == 0 ? 1 : 0;
    EXPECT_LE(100 * others, expected.size());
    EXPECT_NEAR(static_cast<double>(of_mixed.size()),
                static_cast<double>(expected.size()),
                0.01 * static_cast<double>(expected.size()));
    EXPECT_EQ(centresOf(mixed.frame, 0.0), centresOf(coarse.frame, 0.0));
  }
}

} // namespace
