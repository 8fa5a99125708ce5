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
#include <type_traits>

using Octree = pcl::octree::Octree2BufBase<int>;

namespace {

/** Begin and end of one kind of iterator. */
struct DefaultRange {
  static auto
  begin(Octree& octree, pcl::uindex_t max_depth = 0)
  {
    return octree.begin(max_depth);
  }
  static auto
  end(Octree& octree)
  {
    return octree.end();
  }
};

struct DepthFirstRange {
  static auto
  begin(Octree& octree, pcl::uindex_t max_depth = 0)
  {
    return octree.depth_begin(max_depth);
  }
  static auto
  end(Octree& octree)
  {
    return octree.depth_end();
  }
};

struct BreadthFirstRange {
  static auto
  begin(Octree& octree, pcl::uindex_t max_depth = 0)
  {
    return octree.breadth_begin(max_depth);
  }
  static auto
  end(Octree& octree)
  {
    return octree.breadth_end();
  }
};

struct LeafDepthFirstRange {
  static auto
  begin(Octree& octree, pcl::uindex_t max_depth = 0)
  {
    return octree.leaf_depth_begin(max_depth);
  }
  static auto
  end(Octree& octree)
  {
    return octree.leaf_depth_end();
  }
};

struct LeafBreadthFirstRange {
  static auto
  begin(Octree& octree, pcl::uindex_t max_depth = 0)
  {
    return octree.leaf_breadth_begin(max_depth);
  }
  static auto
  end(Octree& octree)
  {
    return octree.leaf_breadth_end();
  }
};

} // namespace

template <typename RangeT>
struct Octree2BufIteratorTest : public testing::Test {
  static constexpr bool leaves_only = std::is_same_v<RangeT, LeafDepthFirstRange> ||
                                      std::is_same_v<RangeT, LeafBreadthFirstRange>;

  void
  SetUp() override
  {
    fill(octree_);
    fill(other_octree_);
  }

  /** 1 root, 8 branches, and a leaf in each of these. */
  static void
  fill(Octree& octree)
  {
    octree.setTreeDepth(2);
    for (unsigned int i = 0; i < 8; ++i)
      octree.createLeaf(2 * (i & 1), i & 2, (i & 4) / 2);
  }

  /** Number of steps from begin to end; if there is no end, one more than there are
   * nodes. */
  std::size_t
  countNodes(pcl::uindex_t max_depth = 0)
  {
    std::size_t count = 0;
    auto it = RangeT::begin(octree_, max_depth);
    while (it != RangeT::end(octree_) && count <= 17) {
      ++it;
      ++count;
    }
    return count;
  }

  Octree octree_;
  Octree other_octree_;
};

using Ranges = testing::Types<DefaultRange,
                              DepthFirstRange,
                              BreadthFirstRange,
                              LeafDepthFirstRange,
                              LeafBreadthFirstRange>;
TYPED_TEST_SUITE(Octree2BufIteratorTest, Ranges);

TYPED_TEST(Octree2BufIteratorTest, EndsOfOneOctreeAreEqual)
{
  EXPECT_EQ(TypeParam::end(this->octree_), TypeParam::end(this->octree_));
  EXPECT_NE(TypeParam::end(this->octree_), TypeParam::end(this->other_octree_));
  EXPECT_NE(TypeParam::begin(this->octree_), TypeParam::end(this->octree_));
}

TYPED_TEST(Octree2BufIteratorTest, LoopEndsBehindLastNode)
{
  EXPECT_EQ(this->countNodes(), this->leaves_only ? 8u : 17u);
}

TYPED_TEST(Octree2BufIteratorTest, LoopEndsAtMaximumDepth)
{
  EXPECT_EQ(this->countNodes(1), this->leaves_only ? 0u : 9u);
}

TYPED_TEST(Octree2BufIteratorTest, LoopEndsInBothBuffers)
{
  this->octree_.switchBuffers();
  this->octree_.createLeaf(0, 0, 0);
  this->octree_.createLeaf(1, 0, 0);
  EXPECT_EQ(this->countNodes(), this->leaves_only ? 2u : 4u);
}

int
main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return (RUN_ALL_TESTS());
}
