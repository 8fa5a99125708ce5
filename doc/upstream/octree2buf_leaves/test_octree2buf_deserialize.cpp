/*
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *  Point Cloud Library (PCL) - www.pointclouds.org
 *  Copyright (c) 2014-, Open Perception Inc.
 *
 *  All rights reserved
 */

#include <pcl/octree/octree.h>
#include <pcl/octree/octree_impl.h>
#include <pcl/test/gtest.h>

#include <cstddef>
#include <vector>

using pcl::octree::OctreeContainerPointIndices;
using pcl::octree::OctreeKey;

namespace {

/** Adds a point to each leaf that is deserialized, as a decoder may. */
class Octree : public pcl::octree::Octree2BufBase<OctreeContainerPointIndices> {
public:
  void
  deserializeTreeCallback(OctreeContainerPointIndices& leaf, const OctreeKey&) override
  {
    if (adds_points)
      leaf.addPointIndex(7);
  }

  bool adds_points = false;
};

/** An octree with a point in each of the leaves (0, 0, 0) and (3, 1, 2). */
void
fill(Octree& octree)
{
  octree.createLeaf(0, 0, 0)->addPointIndex(1);
  octree.createLeaf(3, 1, 2)->addPointIndex(2);
}

class Octree2BufDeserializeTest : public testing::TestWithParam<bool> {
protected:
  void
  SetUp() override
  {
    octree_.setTreeDepth(2);
    fill(octree_);
  }

  /** The bytes of a frame with the leaves of the one before and (1, 1, 1). */
  std::vector<char>
  serializedNextFrame() const
  {
    Octree octree;
    octree.setTreeDepth(2);
    fill(octree);
    octree.switchBuffers();
    fill(octree);
    octree.createLeaf(1, 1, 1);
    std::vector<char> bytes;
    octree.serializeTree(bytes, GetParam());
    return bytes;
  }

  std::size_t
  pointsInLeaf(unsigned int x, unsigned int y, unsigned int z)
  {
    const auto* leaf = octree_.findLeaf(x, y, z);
    EXPECT_NE(leaf, nullptr);
    return leaf ? leaf->getSize() : 0;
  }

  Octree octree_;
};

} // namespace

TEST_P(Octree2BufDeserializeTest, LeavesOfFrameBeforeAreEmpty)
{
  auto bytes = serializedNextFrame();
  octree_.switchBuffers();
  octree_.deserializeTree(bytes, GetParam());
  EXPECT_EQ(octree_.getLeafCount(), 3u);
  EXPECT_EQ(pointsInLeaf(0, 0, 0), 0u);
  EXPECT_EQ(pointsInLeaf(3, 1, 2), 0u);
  EXPECT_EQ(pointsInLeaf(1, 1, 1), 0u);
}

TEST_P(Octree2BufDeserializeTest, CallbackGetsEmptyLeaves)
{
  auto bytes = serializedNextFrame();
  octree_.adds_points = true;
  octree_.switchBuffers();
  octree_.deserializeTree(bytes, GetParam());
  EXPECT_EQ(pointsInLeaf(0, 0, 0), 1u);
  EXPECT_EQ(pointsInLeaf(3, 1, 2), 1u);
  EXPECT_EQ(pointsInLeaf(1, 1, 1), 1u);
}

TEST_P(Octree2BufDeserializeTest, LeavesHaveTheGivenContainers)
{
  auto bytes = serializedNextFrame();
  OctreeContainerPointIndices given;
  for (int i = 0; i < 5; ++i)
    given.addPointIndex(i);
  // for the first of the three leaves, in the order of octree keys
  std::vector<OctreeContainerPointIndices*> containers{&given};
  octree_.switchBuffers();
  octree_.deserializeTree(bytes, containers, GetParam());
  EXPECT_EQ(pointsInLeaf(0, 0, 0), 5u);
  EXPECT_EQ(pointsInLeaf(1, 1, 1), 0u);
  EXPECT_EQ(pointsInLeaf(3, 1, 2), 0u);
}

INSTANTIATE_TEST_SUITE_P(XOR, Octree2BufDeserializeTest, testing::Bool());

int
main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return (RUN_ALL_TESTS());
}
