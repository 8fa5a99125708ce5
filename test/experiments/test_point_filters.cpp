#include "noise/point_filters.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext;
using noise::Centres;

/** \brief A sheet of voxels with holes, and some that float about it. */
io::VoxelFrame
sheetWithOutliers()
{
  std::mt19937 random(7);
  const auto position = [](std::mt19937& from) {
    // One after the other: compilers differ in the order of arguments.
    io::VoxelPosition place{};
    place.x = static_cast<std::uint32_t>(from() % 64);
    place.y = static_cast<std::uint32_t>(from() % 64);
    place.z = static_cast<std::uint32_t>(from() % 64);
    return place;
  };
  std::set<std::uint64_t> keys;
  for (std::uint32_t x = 0; x < 30; ++x)
    for (std::uint32_t y = 0; y < 30; ++y)
      if (random() % 4 != 0)
        keys.insert(io::mortonKey({x, y, 20}));
  for (int i = 0; i < 60; ++i)
    keys.insert(io::mortonKey(position(random)));
  io::VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.depth = 6;
  frame.keys.assign(keys.begin(), keys.end());
  frame.intensities.assign(frame.keys.size(), 1);
  return frame;
}

/** \brief Which points one of PCL's filters keeps. */
template <typename FilterT>
std::vector<int>
keptBy(FilterT& filter, const Centres::Ptr& centres)
{
  std::vector<int> kept;
  filter.setInputCloud(centres);
  filter.filter(kept);
  return kept;
}

std::vector<int>
notBelow(float threshold, const std::vector<float>& scores)
{
  std::vector<int> kept;
  for (std::size_t i = 0; i < scores.size(); ++i)
    if (scores[i] >= threshold)
      kept.push_back(static_cast<int>(i));
  return kept;
}

TEST(PointFilters, CentresAreTheVoxelsMiddles)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  const io::VoxelFrame frame = sheetWithOutliers();
  ASSERT_EQ(centres->size(), frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
    EXPECT_FLOAT_EQ((*centres)[i].x, (static_cast<float>(at.x) + 0.5f) * 0.04f);
    EXPECT_FLOAT_EQ((*centres)[i].z, (static_cast<float>(at.z) + 0.5f) * 0.04f);
  }
}

TEST(PointFilters, StatisticalScoresDecideAsPclsFilter)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  std::vector<float> scores;
  noise::statisticalScores(centres, 8, scores);
  for (const double multiplier : {-0.25, 0.5, 1.0, 2.0}) {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZI> filter;
    filter.setMeanK(8);
    filter.setStddevMulThresh(multiplier);
    const std::vector<int> kept = keptBy(filter, centres);
    EXPECT_LT(kept.size(), centres->size());
    EXPECT_EQ(notBelow(static_cast<float>(-multiplier), scores), kept) << multiplier;
  }
}

TEST(PointFilters, RadiusScoresDecideAsPclsFilter)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  for (const double voxels : {1.5, 2.5}) {
    std::vector<float> scores;
    noise::radiusScores(centres, voxels * 0.04, scores);
    for (const int least : {1, 3, 5}) {
      pcl::RadiusOutlierRemoval<pcl::PointXYZI> filter;
      filter.setRadiusSearch(voxels * 0.04);
      filter.setMinNeighborsInRadius(least);
      const std::vector<int> kept = keptBy(filter, centres);
      EXPECT_LT(kept.size(), centres->size());
      EXPECT_EQ(notBelow(static_cast<float>(least), scores), kept) << voxels << least;
    }
  }
}

} // namespace
