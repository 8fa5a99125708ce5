// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/octree/intensity_leaf.h>
#include <pcl_ext/octree/octree_pointcloud_intensity.h>

#include "support/cloud_streams.h"

#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/octree_base.h>
#include <pcl/octree/octree_container.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace {

using pcl::octree::OctreeContainerEmpty;
using pcl_ext::octree::IntensityLeaf;
using pcl_ext::octree::OctreePointCloudIntensity;
using pcl_ext::test::NaiveVoxels;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::VoxelIndex;
using pcl_ext::test::voxelOf;

template <typename Point, template <typename, typename> class BaseT>
struct OctreeKind {
  using PointT = Point;
  using Octree = OctreePointCloudIntensity<Point,
                                           IntensityLeaf,
                                           OctreeContainerEmpty,
                                           BaseT<IntensityLeaf, OctreeContainerEmpty>>;
};

template <typename KindT>
class OctreeIntensity : public ::testing::Test {
protected:
  using PointT = typename KindT::PointT;
  using Octree = typename KindT::Octree;
  using Cloud = pcl::PointCloud<PointT>;

  // Exact, so that faces are where the test expects them.
  static constexpr double resolution = 0.0625;
  static constexpr double box_side = 8.0;

  OctreeIntensity()
  {
    anchor(octree);
    anchor(receiver);
  }

  static PointT
  makePoint(float x, float y, float z, float intensity = 0.0f)
  {
    PointT point;
    point.x = x;
    point.y = y;
    point.z = z;
    pcl_ext::setNativeIntensity(point, intensity);
    return point;
  }

  /** \brief Few voxels, so that most hold several points; on both sides of zero. */
  static typename Cloud::Ptr
  someCloud(unsigned int seed, std::size_t size)
  {
    return pcl_ext::test::randomCloud<PointT>(seed, size, {0.0, 0.0, 0.0}, 0.4);
  }

  /** \brief Has an octree's voxels be those of naiveVoxels. */
  static void
  anchor(Octree& some_octree)
  {
    const double half = box_side / 2.0;
    some_octree.defineBoundingBox(-half, -half, -half, half, half, half);
  }

  static void
  add(Octree& some_octree, const typename Cloud::Ptr& cloud)
  {
    some_octree.setInputCloud(cloud);
    some_octree.addPointsFromInputCloud();
  }

  void
  add(const typename Cloud::Ptr& cloud)
  {
    add(octree, cloud);
  }

  static PointT
  centreOf(const VoxelIndex& index)
  {
    const auto centre = [](std::int64_t position) {
      return pcl_ext::test::centreOf(position, resolution);
    };
    return makePoint(centre(index[0]), centre(index[1]), centre(index[2]));
  }

  static void
  expectAgreement(const Octree& some_octree, const Cloud& cloud)
  {
    const NaiveVoxels voxels = naiveVoxels(cloud, resolution);
    ASSERT_EQ(some_octree.getLeafCount(), voxels.size());
    for (const auto& [index, voxel] : voxels) {
      const PointT centre = centreOf(index);
      EXPECT_TRUE(some_octree.isVoxelOccupiedAtPoint(centre));
      EXPECT_NEAR(some_octree.getVoxelIntensityAtPoint(centre),
                  voxel.sum,
                  1e-6 * std::max(1.0, voxel.sum));
      EXPECT_EQ(some_octree.getVoxelDensityAtPoint(centre), voxel.count);
      ASSERT_NE(some_octree.getLeafAtPoint(centre), nullptr);
      EXPECT_EQ(some_octree.getLeafAtPoint(centre)->getPointCounter(), voxel.count);
    }
  }

  Octree octree{resolution};
  Octree receiver{resolution};
};

using OctreeKinds =
    ::testing::Types<OctreeKind<pcl::PointXYZI, pcl::octree::OctreeBase>,
                     OctreeKind<pcl::PointXYZI, pcl::octree::Octree2BufBase>,
                     OctreeKind<pcl::PointXYZ, pcl::octree::OctreeBase>,
                     OctreeKind<pcl::PointXYZ, pcl::octree::Octree2BufBase>>;
TYPED_TEST_SUITE(OctreeIntensity, OctreeKinds);

TYPED_TEST(OctreeIntensity, AgreesWithANaiveMapOfAllFinitePoints)
{
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto first = this->someCloud(11, 3000);
  const auto second = this->someCloud(16, 1000);
  second->push_back(this->makePoint(not_a_number, 0.0f, 0.0f, 1000.0f));
  second->push_back(this->makePoint(0.0f, infinity, 0.0f, 1000.0f));
  second->push_back(this->makePoint(0.0f, 0.0f, -infinity, 1000.0f));
  second->is_dense = false;
  this->add(first);
  this->add(second);
  typename TestFixture::Cloud both = *first;
  both += *second;
  this->expectAgreement(this->octree, both);
  const auto voxels = naiveVoxels(both, this->resolution);
  std::size_t leaves[3] = {}; // by each of PCL's iterators
  for (auto node = this->octree.breadth_begin(); *node != nullptr; ++node)
    leaves[0] += node.isLeafNode() ? 1 : 0;
  for (auto node = this->octree.depth_begin(); *node != nullptr; ++node)
    leaves[1] += node.isLeafNode() ? 1 : 0;
  for (auto node = this->octree.leaf_breadth_begin(); *node != nullptr; ++node)
    ++leaves[2];
  for (const std::size_t count : leaves)
    EXPECT_EQ(count, voxels.size());
  for (const auto& point : *first)
    EXPECT_NEAR(this->octree.getVoxelIntensityAtPoint(point),
                voxels.at(voxelOf(point, this->resolution)).sum,
                1e-3);
}

TYPED_TEST(OctreeIntensity, AdoptsABoxOfItsOwnWhenNoneIsGiven)
{
  const auto cloud = this->someCloud(13, 1000);
  typename TestFixture::Octree unanchored(this->resolution);
  this->add(unanchored, cloud);
  // PCL chooses where the voxels begin; no point may be lost.
  double sum = 0.0;
  std::size_t points = 0;
  for (auto leaf = unanchored.leaf_depth_begin(); *leaf != nullptr; ++leaf) {
    sum += static_cast<double>(leaf.getLeafContainer().getIntensity());
    points += leaf.getLeafContainer().getPointCounter();
  }
  double expected_sum = 0.0;
  for (const auto& point : *cloud)
    expected_sum += static_cast<double>(pcl_ext::nativeIntensity(point, 1.0f));
  EXPECT_NEAR(sum, expected_sum, 1e-3);
  EXPECT_EQ(points, cloud->size());
}

TYPED_TEST(OctreeIntensity, EmptyVoxelsAndPlacesOutsideTheBoxShowZero)
{
  typename TestFixture::Cloud::Ptr cloud(new typename TestFixture::Cloud);
  cloud->push_back(this->makePoint(0.01f, 0.01f, 0.01f, 5.0f));
  this->add(cloud);
  const auto half = static_cast<float>(this->box_side / 2.0);
  const auto next_octant = 2.0f * half + 0.01f; // same key bits as the occupied voxel
  for (const auto& place : {this->makePoint(0.1f, 0.01f, 0.01f),
                            this->makePoint(-0.01f, 0.01f, 0.01f),
                            this->makePoint(half, 0.01f, 0.01f),
                            this->makePoint(-half - 0.001f, 0.01f, 0.01f),
                            this->makePoint(next_octant, 0.01f, 0.01f),
                            this->makePoint(0.01f, -next_octant, 0.01f),
                            this->makePoint(1e30f, 1e30f, 1e30f),
                            this->makePoint(-1e30f, 0.0f, 0.0f),
                            this->makePoint(0.01f, NAN, 0.01f)}) {
    for (const auto* const one : {&this->octree, &this->receiver}) { // which is empty
      EXPECT_EQ(one->getVoxelIntensityAtPoint(place), 0.0f) << place;
      EXPECT_EQ(one->getVoxelDensityAtPoint(place), 0u) << place;
      EXPECT_EQ(one->getLeafAtPoint(place), nullptr) << place;
    }
  }
}

TYPED_TEST(OctreeIntensity, ReadsOnlyTheIndicesItIsGiven)
{
  const auto cloud = this->someCloud(17, 200);
  const pcl::shared_ptr<pcl::Indices> indices(new pcl::Indices);
  typename TestFixture::Cloud chosen;
  for (pcl::index_t i = 0; i < 200; i += 7) {
    indices->push_back(i);
    chosen.push_back((*cloud)[static_cast<std::size_t>(i)]);
  }
  this->octree.setInputCloud(cloud, indices);
  this->octree.addPointsFromInputCloud();
  this->expectAgreement(this->octree, chosen);
}

TYPED_TEST(OctreeIntensity, SerializedTreesComeBackAsOccupancyAlone)
{
  const auto cloud = this->someCloud(22, 1500);
  this->add(cloud);
  std::vector<char> bytes;
  this->octree.serializeTree(bytes);
  this->receiver.deserializeTree(bytes);
  const auto voxels = naiveVoxels(*cloud, this->resolution);
  ASSERT_EQ(this->receiver.getLeafCount(), voxels.size());
  for (const auto& [index, voxel] : voxels) {
    EXPECT_TRUE(this->receiver.isVoxelOccupiedAtPoint(this->centreOf(index)));
    EXPECT_EQ(this->receiver.getVoxelIntensityAtPoint(this->centreOf(index)), 0.0f);
  }
}

class DoubleBufferedOctreeIntensity
: public OctreeIntensity<OctreeKind<pcl::PointXYZI, pcl::octree::Octree2BufBase>> {};

TEST_F(DoubleBufferedOctreeIntensity, NoLeafLeaksFromEarlierFrames)
{
  for (unsigned int frame = 0; frame < 8; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    // Alternating clouds with most voxels in common, so that leaves are taken over from
    // the other buffer and from two frames ago.
    const auto cloud = someCloud(30 + frame % 3, 1500);
    octree.switchBuffers();
    add(cloud);
    expectAgreement(octree, *cloud);
    // As PCL's compression does, which cleans the buffer behind.
    std::vector<char> bytes;
    octree.serializeTree(bytes, frame > 0);
    EXPECT_FALSE(bytes.empty());
  }
}

TEST_F(DoubleBufferedOctreeIntensity, NoLeafLeaksThroughDeserializedTrees)
{
  for (unsigned int frame = 0; frame < 4; ++frame) {
    const auto cloud = someCloud(40, 300);
    octree.switchBuffers();
    add(cloud);
    std::vector<char> bytes;
    octree.serializeTree(bytes, frame > 0);
    receiver.switchBuffers();
    receiver.deserializeTree(bytes, frame > 0);
    ASSERT_EQ(receiver.getLeafCount(), octree.getLeafCount());
    for (const auto& point : *cloud)
      ASSERT_EQ(receiver.getVoxelIntensityAtPoint(point), 0.0f)
          << "frame " << frame << " shows points of an earlier frame";
    // What a receiver does with its leaves: give them the decoded intensities.
    for (auto leaf = receiver.leaf_depth_begin(); *leaf != nullptr; ++leaf)
      leaf.getLeafContainer().addPointIntensity(1.0f);
  }
}

TEST_F(DoubleBufferedOctreeIntensity, DifferenceFramesComeBackWithTheirLeaves)
{
  for (unsigned int frame = 0; frame < 5; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    const auto cloud = someCloud(50 + frame, 800);
    octree.switchBuffers();
    add(cloud);
    std::vector<char> bytes;
    std::vector<IntensityLeaf*> leaves;
    octree.serializeTree(bytes, leaves, frame > 0);
    receiver.switchBuffers();
    receiver.deserializeTree(bytes, leaves, frame > 0);
    expectAgreement(receiver, *cloud);
  }
}

} // namespace
