// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/octomap_insertion.h>

#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

namespace {

using octomap::OcTree;
using octomap::OcTreeNode;
using octomap::point3d;
using pcl_ext::io::VoxelFrame;
using pcl_ext::io::VoxelPosition;
using pcl_ext::io::voxelPosition;
using pcl_ext::io::test::emptyFrame;
using pcl_ext::io::test::randomFrame;
using pcl_ext::nodes::insertVoxels;

constexpr double frame_resolution = 0.04; // of the frames

std::optional<float>
logOddsAt(const OcTree& map, const point3d& place)
{
  const OcTreeNode* const node = map.search(place);
  return node == nullptr ? std::nullopt : std::make_optional(node->getLogOdds());
}

OcTree
wideMap(double edge)
{
  OcTree map(edge);
  map.setClampingThresMin(1e-6);
  map.setClampingThresMax(1.0 - 1e-6);
  return map;
}

/** \brief Log-odds by key, as the documentation says; without rays. */
std::map<std::array<unsigned int, 3>, float>
naiveLogOdds(const VoxelFrame& frame, float full_intensity, const OcTree& map)
{
  std::map<std::array<unsigned int, 3>, float> log_odds;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame.keys[i]);
    const auto key = [&](std::size_t axis, std::uint32_t place) {
      // A centre on a face belongs to the node above.
      const double edges = frame.grid.centre(axis, place) / map.getResolution();
      return static_cast<unsigned int>(std::floor(edges + 1e-6) + 32768.0);
    };
    const float intensity = frame.intensity_scale.value(frame.intensities[i]);
    const float trust = std::max(std::min(intensity / full_intensity, 1.0f), 0.0f);
    float& node =
        log_odds[{key(0, position.x), key(1, position.y), key(2, position.z)}];
    node = std::min(node + trust * map.getProbHitLog(), map.getClampingThresMaxLog());
  }
  return log_odds;
}

/** \brief As insertVoxels() with rays, by OctoMap's functions for single nodes. */
void
insertNodeByNode(const VoxelFrame& frame,
                 float full_intensity,
                 const point3d& sensor,
                 OcTree& map)
{
  octomap::Pointcloud cloud;
  pcl_ext::io::forEachVoxelCentre(frame, [&](float x, float y, float z, float) {
    const float margin = pcl_ext::io::faceMargin(map.getResolution());
    cloud.push_back(x + margin, y + margin, z + margin);
  });
  octomap::KeySet free_nodes;
  octomap::KeySet occupied_nodes;
  map.computeUpdate(cloud, sensor, free_nodes, occupied_nodes, -1.0);
  for (const octomap::OcTreeKey& key : free_nodes)
    map.updateNode(key, false, true);
  insertVoxels(frame, full_intensity, std::nullopt, map);
}

/** \brief A frame along x from a voxel on, for rays that are easily followed.
 * \param[in] intensities of the voxels that follow each other
 */
VoxelFrame
rowFrom(std::uint32_t x, const std::vector<std::uint16_t>& intensities)
{
  VoxelFrame frame = emptyFrame(6);
  frame.grid.first_index = {0, 0, 0};
  for (std::size_t i = 0; i < intensities.size(); ++i)
    frame.keys.push_back(
        pcl_ext::io::mortonKey({x + static_cast<std::uint32_t>(i), 3, 3}));
  frame.intensities = intensities;
  EXPECT_TRUE(isConsistent(frame));
  return frame;
}

point3d
onRow(std::uint32_t x)
{
  return {static_cast<float>((x + 0.5) * frame_resolution),
          static_cast<float>(3.5 * frame_resolution),
          static_cast<float>(3.5 * frame_resolution)};
}

void
expectRow(const OcTree& map,
          std::uint32_t x,
          const std::vector<std::optional<float>>& log_odds)
{
  for (const std::optional<float>& expected : log_odds) {
    EXPECT_EQ(logOddsAt(map, onRow(x)), expected) << "voxel " << x;
    ++x;
  }
}

const std::optional<float> unknown;

TEST(OctomapInsertion, VoxelsWithoutIntensitiesAreHits)
{
  VoxelFrame frame = rowFrom(10, {1, 2});
  frame.intensities.clear();
  frame.intensity_scale.bits = 0;
  ASSERT_TRUE(isConsistent(frame));
  OcTree map(frame_resolution);
  insertVoxels(frame, 4.0f, std::nullopt, map);
  const float hit = map.getProbHitLog();
  expectRow(map, 9, {unknown, hit, hit, unknown});
}

TEST(OctomapInsertion, SumsUpInMapsOfAnyResolution)
{
  std::mt19937_64 random(1);
  VoxelFrame frame = randomFrame(random, 6, 4000);
  for (std::uint16_t& symbol : frame.intensities)
    symbol = static_cast<std::uint16_t>(symbol / 2 + 1);
  for (const double edge : {0.04, 0.02, 0.12, 0.3}) {
    OcTree map = wideMap(edge);
    insertVoxels(frame, 60.0f, std::nullopt, map);
    const auto expected = naiveLogOdds(frame, 60.0f, map);
    std::size_t nodes = 0;
    map.expand();
    for (auto leaf = map.begin_leafs(); leaf != map.end_leafs(); ++leaf, ++nodes) {
      const octomap::OcTreeKey key = leaf.getKey();
      const auto node = expected.find({key[0], key[1], key[2]});
      ASSERT_NE(node, expected.end());
      EXPECT_EQ(leaf->getLogOdds(), node->second);
    }
    EXPECT_EQ(nodes, expected.size());
  }
}

TEST(OctomapInsertion, LaterFramesAddToEarlierOnes)
{
  OcTree map(frame_resolution);
  const VoxelFrame frame = rowFrom(5, {1, 4});
  insertVoxels(frame, 4.0f, std::nullopt, map);
  insertVoxels(frame, 4.0f, std::nullopt, map);
  EXPECT_EQ(logOddsAt(map, onRow(5)), 0.25f * map.getProbHitLog() * 2.0f);
  for (int i = 0; i < 20; ++i)
    insertVoxels(frame, 4.0f, std::nullopt, map);
  EXPECT_EQ(logOddsAt(map, onRow(6)), map.getClampingThresMaxLog());
}

TEST(OctomapInsertion, VoxelsOfZeroIntensityAreIgnored)
{
  OcTree map(frame_resolution);
  insertVoxels(rowFrom(20, {0, 9}), 1.0f, onRow(2), map);
  // A node of log-odds 0 would count as occupied.
  expectRow(map, 19, {map.getProbMissLog(), unknown, map.getProbHitLog()});
  VoxelFrame negative = rowFrom(30, {0, 50});
  negative.intensity_scale.offset = -20.0f;
  insertVoxels(negative, 10.0f, std::nullopt, map);
  expectRow(map, 30, {unknown, map.getProbHitLog()});
}

TEST(OctomapInsertion, RaysMissEachNodeOnceAndInnerNodesFollow)
{
  std::mt19937_64 random(3);
  for (const bool notes_changes : {false, true})
    for (const double edge : {0.04, 0.12}) {
      OcTree map(edge);
      OcTree expected(edge);
      map.enableChangeDetection(notes_changes);
      expected.enableChangeDetection(notes_changes);
      // Until nodes are at both limits; whole parts of the tree are free.
      for (int round = 0; round < 8; ++round) {
        const VoxelFrame frame = randomFrame(random, round % 2 == 0 ? 5 : 4, 300);
        const point3d sensor(round % 3 == 0 ? -1.0f : 0.9f, 0.3f, -0.8f);
        insertVoxels(frame, 60.0f, sensor, map);
        insertNodeByNode(frame, 60.0f, sensor, expected);
        OcTree updated(map);
        updated.updateInnerOccupancy();
        EXPECT_TRUE(map == updated);
        map.prune();
        expected.prune();
        EXPECT_EQ(map.numChangesDetected(), expected.numChangesDetected());
        OcTree leaves(map);
        OcTree expected_leaves(expected);
        leaves.expand();
        expected_leaves.expand();
        ASSERT_TRUE(leaves == expected_leaves) << edge << ", round " << round;
      }
      EXPECT_LE(map.size(), expected.size());
      EXPECT_EQ(map.calcNumNodes(), map.size());
    }
}

TEST(OctomapInsertion, AFrameWithoutVoxelsChangesNothing)
{
  OcTree map(frame_resolution);
  insertVoxels(emptyFrame(5), 1.0f, std::nullopt, map);
  insertVoxels(emptyFrame(5), 1.0f, point3d(1.0f, 2.0f, 3.0f), map);
  EXPECT_EQ(map.size(), 0u);
  insertVoxels(rowFrom(20, {9}), 1.0f, onRow(2), map);
  const OcTree before(map);
  insertVoxels(emptyFrame(5), 1.0f, onRow(2), map);
  EXPECT_TRUE(map == before);
}

TEST(OctomapInsertion, VoxelsOutsideOfTheMapAreLeftOutAndCounted)
{
  VoxelFrame frame = rowFrom(5, {9, 9, 0, 9, 0});
  frame.grid.first_index = {32768 - 7, 0, 0}; // two are within
  OcTree map(frame_resolution);
  EXPECT_EQ(insertVoxels(frame, 1.0f, std::nullopt, map), 3u);
  EXPECT_EQ(map.getNumLeafNodes(), 2u);
  frame.grid.first_index = {0, 0, 0};
  EXPECT_EQ(insertVoxels(frame, 1.0f, std::nullopt, map), 0u);
}

} // namespace
