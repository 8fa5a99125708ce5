// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/octree/intensity_leaf.h>

#include <pcl/octree/octree_container.h>

#include <gtest/gtest.h>

#include <memory>
#include <type_traits>
#include <vector>

namespace {

using pcl::octree::OctreeContainerEmpty;
using pcl_ext::octree::IntensityLeaf;

static_assert(std::is_base_of<pcl::octree::OctreeContainerBase, IntensityLeaf>::value,
              "");
static_assert(std::is_default_constructible<IntensityLeaf>::value, "");
static_assert(std::is_copy_constructible<IntensityLeaf>::value, "");
static_assert(std::is_copy_assignable<IntensityLeaf>::value, "");

IntensityLeaf
leafOf(const std::vector<float>& intensities)
{
  IntensityLeaf leaf;
  for (const float intensity : intensities)
    leaf.addPointIntensity(intensity);
  return leaf;
}

TEST(IntensityLeaf, SumsCountsAndAverages)
{
  const IntensityLeaf leaf = leafOf({1.5f, -0.5f, 5.0f});
  EXPECT_EQ(leaf.getPointCounter(), 3u);
  EXPECT_EQ(leaf.getSize(), 3u);
  EXPECT_EQ(leaf.getIntensity(), 6.0f);
  EXPECT_EQ(leaf.getMeanIntensity(), 2.0f);
}

TEST(IntensityLeaf, ManySmallSharesAreNotLostAgainstALargeSum)
{
  IntensityLeaf leaf;
  leaf.addPointIntensity(16777216.0f); // where a float stops seeing a 1
  for (int i = 0; i < 1000; ++i)
    leaf.addPointIntensity(1.0f);
  EXPECT_EQ(leaf.getIntensity(), 16778216.0f);
}

TEST(IntensityLeaf, HasTheMeanOfItsColours)
{
  IntensityLeaf leaf = leafOf({1.0f, 1.0f, 1.0f});
  EXPECT_FALSE(leaf.getColour().has_value());
  leaf.addPointColour({255, 0, 1});
  leaf.addPointColour({255, 1, 1});
  leaf.addPointColour({255, 1, 0});
  ASSERT_TRUE(leaf.getColour().has_value());
  EXPECT_TRUE(*leaf.getColour() == (pcl_ext::io::VoxelColour{255, 1, 1}));
  EXPECT_FALSE(leaf == leafOf({1.0f, 1.0f, 1.0f}));
  const std::unique_ptr<IntensityLeaf> copy(leaf.deepCopy());
  EXPECT_TRUE(leaf == *copy);
  leaf.reset();
  EXPECT_FALSE(leaf.getColour().has_value());
  EXPECT_TRUE(copy->getColour().has_value());
}

TEST(IntensityLeaf, PointIndicesCountWithoutIntensity)
{
  IntensityLeaf leaf;
  leaf.addPointIndex(17);
  leaf.addPointIndex(4);
  EXPECT_EQ(leaf.getPointCounter(), 2u);
  EXPECT_EQ(leaf.getIntensity(), 0.0f);
}

TEST(IntensityLeaf, EqualityComparesSumAndCount)
{
  const IntensityLeaf leaf = leafOf({1.0f, 3.0f});
  EXPECT_TRUE(leaf == leafOf({2.0f, 2.0f}));
  EXPECT_FALSE(leaf == leafOf({4.0f}));
  EXPECT_FALSE(leaf == leafOf({1.0f, 2.0f}));
  EXPECT_FALSE(IntensityLeaf() == OctreeContainerEmpty());
  EXPECT_FALSE(IntensityLeaf() == pcl::octree::OctreeContainerPointIndex());
  EXPECT_FALSE(IntensityLeaf() == pcl::octree::OctreeContainerPointIndices());
}

} // namespace
