// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <cmath>
#include <limits>

namespace {

namespace origins {

using namespace pcl_ext::nodes::test;

constexpr double small_resolution = 0.01;
using Place = std::array<double, 3>;

/** \brief UTM coordinates of a site, a corner of a voxel. */
constexpr Place site{432100.25, 5812345.75, 60.5};

Place
moved(const Place& place, int voxels)
{
  Place other = place;
  for (double& coordinate : other)
    coordinate = std::round(coordinate / small_resolution + voxels) * small_resolution;
  return other;
}

VoxelFrame
frameAt(const Place& origin, std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  VoxelFrame frame = pcl_ext::io::test::randomFrame(random, 4, 800, 9);
  frame.grid.resolution = small_resolution;
  frame.grid.origin = origin;
  return frame;
}

/** \brief Intensities by the position of a voxel's centre about the site, in tenths of
 * a voxel. */
using SiteVoxels = std::map<std::array<std::int64_t, 3>, double>;

void
addSiteVoxels(const VoxelFrame& frame, SiteVoxels& voxels)
{
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const auto position = pcl_ext::io::voxelPosition(frame.keys[i]);
    const auto place = [&](std::size_t axis, std::uint32_t index) {
      return std::llround((frame.grid.centre(axis, index) - site[axis]) * 10.0 /
                          small_resolution);
    };
    voxels[{place(0, position.x), place(1, position.y), place(2, position.z)}] +=
        static_cast<double>(frame.intensity_scale.value(frame.intensities[i]));
  }
}

class Origins : public ::testing::Test {
protected:
  static CentralNodeSettings
  settings()
  {
    CentralNodeSettings settings = centralSettings();
    settings.resolution = small_resolution;
    settings.max_merge_age = Time::max();
    return settings;
  }

  void
  show(const std::string& name, const VoxelFrame& frame)
  {
    node.addStream(name);
    sendAndWait(node, name, coded(frame));
  }

  SiteVoxels
  merged(CentralNode& merging)
  {
    VoxelFrame frame;
    merging.merge(frame);
    EXPECT_TRUE(isConsistent(frame));
    // Others may encode it.
    EXPECT_FALSE(coded(frame).empty());
    SiteVoxels voxels;
    addSiteVoxels(frame, voxels);
    return voxels;
  }

  std::size_t
  outside(const std::string& name) const
  {
    for (const StreamHealth& health : node.health())
      if (health.name == name)
        return health.voxels_outside_grid;
    ADD_FAILURE() << "there is no stream " << name;
    return 0;
  }

  CentralNode node{settings()};
};

TEST_F(Origins, OfStreamsNearEachOtherAreOneGrid)
{
  const VoxelFrame first = frameAt(moved(site, 0), 1);
  const VoxelFrame second = frameAt(moved(site, 7), 2);
  // A stream whose own lattice is shared by the world's origin only on one axis.
  VoxelFrame third = frameAt(moved({site[0], site[1], 0.0}, 0), 3);
  third.grid.first_index[2] += 6050;
  SiteVoxels expected;
  for (const auto& [name, frame] : std::map<std::string, VoxelFrame>{
           {"first", first}, {"second", second}, {"third", third}}) {
    show(name, frame);
    addSiteVoxels(frame, expected);
  }
  ASSERT_LT(expected.size(), first.size() + second.size() + third.size());
  EXPECT_EQ(merged(node), expected);
  for (const StreamHealth& health : node.health())
    EXPECT_EQ(health.voxels_outside_grid, 0u);
  EXPECT_EQ(merged(node), expected); // again
}

TEST_F(Origins, VoxelsThatAreTooFarApartAreLeftOutAndCounted)
{
  const VoxelFrame large = frameAt(moved(site, 0), 1);
  VoxelFrame small = frameAt({}, 2);
  small.keys.resize(10);
  small.intensities.resize(10);
  show("large", large);
  show("small", small);
  SiteVoxels expected;
  addSiteVoxels(large, expected);
  EXPECT_EQ(merged(node), expected);
  EXPECT_EQ(outside("large"), 0u);
  EXPECT_EQ(outside("small"), 10u);
  // The origin follows the voxels.
  sendAndWait(node, "large", coded(frameAt(moved({}, 3), 1)));
  expected.clear();
  addSiteVoxels(frameAt(moved({}, 3), 1), expected);
  addSiteVoxels(small, expected);
  EXPECT_EQ(merged(node), expected);
  EXPECT_EQ(outside("small"), 0u);
}

TEST_F(Origins, CanBeSet)
{
  CentralNodeSettings fixed = settings();
  fixed.origin = moved(site, -4);
  CentralNode fixed_node(fixed);
  ASSERT_TRUE(fixed_node.settingsStatus().ok());
  fixed_node.addStream("site");
  fixed_node.addStream("world");
  sendAndWait(fixed_node, "world", coded(frameAt({}, 2)));
  EXPECT_TRUE(merged(fixed_node).empty());
  const VoxelFrame frame = frameAt(moved(site, 0), 1);
  sendAndWait(fixed_node, "site", coded(frame));
  SiteVoxels expected;
  addSiteVoxels(frame, expected);
  EXPECT_EQ(merged(fixed_node), expected);
  VoxelFrame voxels;
  fixed_node.merge(voxels);
  EXPECT_EQ(voxels.grid.origin, *fixed.origin);
  fixed.origin = Place{0.0, std::numeric_limits<double>::quiet_NaN(), 0.0};
  EXPECT_EQ(CentralNode(fixed).settingsStatus().code(),
            CentralNodeCode::InvalidSettings);
}

TEST_F(Origins, AStreamThatIsNotMergedHasNoVoxelsOutside)
{
  FakeClock clock;
  CentralNodeSettings aging = settings();
  aging.max_merge_age = std::chrono::seconds(1);
  aging.clock = clock.clock();
  CentralNode aging_node(aging);
  aging_node.addStream("a");
  aging_node.addStream("b");
  clock.set(std::chrono::seconds(10));
  VoxelFrame small = frameAt({}, 2);
  small.keys.resize(3);
  small.intensities.resize(3);
  sendAndWait(aging_node, "a", coded(small));
  sendAndWait(aging_node, "b", coded(frameAt(moved(site, 0), 1)));
  merged(aging_node);
  EXPECT_EQ(aging_node.health()[0].voxels_outside_grid, 3u);
  clock.set(std::chrono::seconds(20));
  EXPECT_TRUE(merged(aging_node).empty());
  EXPECT_EQ(aging_node.health()[0].voxels_outside_grid, 0u);
  EXPECT_EQ(aging_node.health()[0].merges_outside_grid, 1u);
}

} // namespace origins

} // namespace
