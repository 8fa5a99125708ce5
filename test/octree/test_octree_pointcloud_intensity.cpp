#include <pcl_ext/octree/intensity_leaf.h>
#include <pcl_ext/octree/octree_pointcloud_intensity.h>

#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/octree_base.h>
#include <pcl/octree/octree_container.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

namespace {

using pcl::octree::OctreeContainerEmpty;
using pcl_ext::octree::IntensityLeaf;
using pcl_ext::octree::OctreePointCloudIntensity;

/** \brief Point type and octree base of a typed test. */
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

  struct NaiveVoxel {
    double sum = 0.0;
    unsigned int count = 0;
  };
  using VoxelIndex = std::array<std::int64_t, 3>;
  using NaiveVoxels = std::map<VoxelIndex, NaiveVoxel>;

  static constexpr double resolution =
      0.0625; // exact, so that faces are where we think
  static constexpr double box_side = 8.0;

  static PointT
  makePoint(float x, float y, float z, float intensity)
  {
    PointT point;
    point.x = x;
    point.y = y;
    point.z = z;
    if constexpr (std::is_same<PointT, pcl::PointXYZI>::value)
      point.intensity = intensity;
    else
      static_cast<void>(intensity);
    return point;
  }

  static float
  expectedIntensity(const PointT& point)
  {
    if constexpr (std::is_same<PointT, pcl::PointXYZI>::value)
      return point.intensity;
    else
      return point.x == point.x ? 1.0f : 0.0f;
  }

  static typename Cloud::Ptr
  randomCloud(unsigned int seed, std::size_t size)
  {
    std::mt19937 generator(seed);
    // Few voxels, so that most hold several points; on both sides of zero.
    std::uniform_real_distribution<float> coordinate(-0.4f, 0.4f);
    std::uniform_real_distribution<float> intensity(-2.0f, 100.0f);
    typename Cloud::Ptr cloud(new Cloud);
    for (std::size_t i = 0; i < size; ++i) {
      const float x = coordinate(generator);
      const float y = coordinate(generator);
      const float z = coordinate(generator);
      cloud->push_back(makePoint(x, y, z, intensity(generator)));
    }
    return cloud;
  }

  static VoxelIndex
  voxelOf(const PointT& point)
  {
    const auto index = [](float coordinate) {
      return static_cast<std::int64_t>(
          std::floor(static_cast<double>(coordinate) / resolution));
    };
    return {index(point.x), index(point.y), index(point.z)};
  }

  static NaiveVoxels
  voxelize(const Cloud& cloud)
  {
    NaiveVoxels voxels;
    for (const PointT& point : cloud) {
      if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z))
        continue;
      NaiveVoxel& voxel = voxels[voxelOf(point)];
      voxel.sum += static_cast<double>(expectedIntensity(point));
      ++voxel.count;
    }
    return voxels;
  }

  static PointT
  centreOf(const VoxelIndex& index)
  {
    const auto centre = [](std::int64_t position) {
      return static_cast<float>((static_cast<double>(position) + 0.5) * resolution);
    };
    return makePoint(centre(index[0]), centre(index[1]), centre(index[2]), 0.0f);
  }

  /** \brief An empty octree whose voxels are those of voxelOf. */
  static void
  anchor(Octree& octree)
  {
    const double half = box_side / 2.0;
    octree.defineBoundingBox(-half, -half, -half, half, half, half);
  }

  static void
  expectAgreement(const Octree& octree, const NaiveVoxels& voxels)
  {
    ASSERT_EQ(octree.getLeafCount(), voxels.size());
    for (const auto& [index, voxel] : voxels) {
      const PointT centre = centreOf(index);
      EXPECT_TRUE(octree.isVoxelOccupiedAtPoint(centre));
      EXPECT_NEAR(octree.getVoxelIntensityAtPoint(centre),
                  voxel.sum,
                  1e-6 * std::max(1.0, std::abs(voxel.sum)));
      EXPECT_EQ(octree.getVoxelDensityAtPoint(centre), voxel.count);
      ASSERT_NE(octree.getLeafAtPoint(centre), nullptr);
      EXPECT_EQ(octree.getLeafAtPoint(centre)->getPointCounter(), voxel.count);
    }
  }
};

using OctreeKinds =
    ::testing::Types<OctreeKind<pcl::PointXYZI, pcl::octree::OctreeBase>,
                     OctreeKind<pcl::PointXYZI, pcl::octree::Octree2BufBase>,
                     OctreeKind<pcl::PointXYZ, pcl::octree::OctreeBase>,
                     OctreeKind<pcl::PointXYZ, pcl::octree::Octree2BufBase>>;
TYPED_TEST_SUITE(OctreeIntensity, OctreeKinds);

TYPED_TEST(OctreeIntensity, AgreesWithANaiveMap)
{
  const auto cloud = this->randomCloud(11, 4000);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  this->expectAgreement(octree, this->voxelize(*cloud));
}

TYPED_TEST(OctreeIntensity, AgreesWithANaiveMapAtThePointsThemselves)
{
  const auto cloud = this->randomCloud(12, 500);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  const auto voxels = this->voxelize(*cloud);
  for (const auto& point : *cloud)
    EXPECT_NEAR(octree.getVoxelIntensityAtPoint(point),
                voxels.at(this->voxelOf(point)).sum,
                1e-3);
}

TYPED_TEST(OctreeIntensity, AdoptsABoxOfItsOwnWhenNoneIsGiven)
{
  const auto cloud = this->randomCloud(13, 1000);
  typename TestFixture::Octree octree(this->resolution);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  // Where PCL anchors the voxels is its own affair; nothing may be lost all the same.
  double sum = 0.0;
  std::size_t points = 0;
  for (auto leaf = octree.leaf_depth_begin(); *leaf != nullptr; ++leaf) {
    sum += static_cast<double>(leaf.getLeafContainer().getIntensity());
    points += leaf.getLeafContainer().getPointCounter();
  }
  double expected_sum = 0.0;
  for (const auto& point : *cloud)
    expected_sum += static_cast<double>(this->expectedIntensity(point));
  EXPECT_NEAR(sum, expected_sum, 1e-3);
  EXPECT_EQ(points, cloud->size());
}

TYPED_TEST(OctreeIntensity, LeavesOutPointsThatAreNotFinite)
{
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto cloud = this->randomCloud(14, 50);
  cloud->push_back(this->makePoint(not_a_number, 0.0f, 0.0f, 1000.0f));
  cloud->push_back(this->makePoint(0.0f, infinity, 0.0f, 1000.0f));
  cloud->push_back(this->makePoint(0.0f, 0.0f, -infinity, 1000.0f));
  cloud->is_dense = false;
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  this->expectAgreement(octree, this->voxelize(*cloud));
}

TYPED_TEST(OctreeIntensity, EmptyVoxelsAndPlacesOutsideTheBoxShowZero)
{
  typename TestFixture::Cloud::Ptr cloud(new typename TestFixture::Cloud);
  cloud->push_back(this->makePoint(0.01f, 0.01f, 0.01f, 5.0f));
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  const auto half = static_cast<float>(this->box_side / 2.0);
  const auto next_octant = 2.0f * half + 0.01f; // same key bits as the occupied voxel
  for (const auto& place : {this->makePoint(0.1f, 0.01f, 0.01f, 0.0f),
                            this->makePoint(-0.01f, 0.01f, 0.01f, 0.0f),
                            this->makePoint(half, 0.01f, 0.01f, 0.0f),
                            this->makePoint(-half - 0.001f, 0.01f, 0.01f, 0.0f),
                            this->makePoint(next_octant, 0.01f, 0.01f, 0.0f),
                            this->makePoint(0.01f, -next_octant, 0.01f, 0.0f),
                            this->makePoint(1e30f, 1e30f, 1e30f, 0.0f),
                            this->makePoint(-1e30f, 0.0f, 0.0f, 0.0f)}) {
    EXPECT_EQ(octree.getVoxelIntensityAtPoint(place), 0.0f) << place;
    EXPECT_EQ(octree.getVoxelDensityAtPoint(place), 0u) << place;
    EXPECT_EQ(octree.getLeafAtPoint(place), nullptr) << place;
  }
}

TYPED_TEST(OctreeIntensity, AnEmptyOctreeShowsZero)
{
  const typename TestFixture::Octree octree(this->resolution);
  const auto origin = this->makePoint(0.0f, 0.0f, 0.0f, 1.0f);
  EXPECT_EQ(octree.getVoxelIntensityAtPoint(origin), 0.0f);
  EXPECT_EQ(octree.getVoxelDensityAtPoint(origin), 0u);
  EXPECT_EQ(octree.getLeafAtPoint(origin), nullptr);
}

TYPED_TEST(OctreeIntensity, PointsAddedInTwoCallsAddUp)
{
  const auto first = this->randomCloud(15, 300);
  const auto second = this->randomCloud(16, 300);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(first);
  octree.addPointsFromInputCloud();
  octree.setInputCloud(second);
  octree.addPointsFromInputCloud();
  typename TestFixture::Cloud both = *first;
  both += *second;
  this->expectAgreement(octree, this->voxelize(both));
}

TYPED_TEST(OctreeIntensity, ReadsOnlyTheIndicesItIsGiven)
{
  const auto cloud = this->randomCloud(17, 200);
  const pcl::shared_ptr<pcl::Indices> indices(new pcl::Indices);
  typename TestFixture::Cloud chosen;
  for (pcl::index_t i = 0; i < 200; i += 7) {
    indices->push_back(i);
    chosen.push_back((*cloud)[static_cast<std::size_t>(i)]);
  }
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud, indices);
  octree.addPointsFromInputCloud();
  this->expectAgreement(octree, this->voxelize(chosen));
}

TYPED_TEST(OctreeIntensity, PclsIteratorsVisitEveryVoxelOnce)
{
  const auto cloud = this->randomCloud(18, 2000);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  const auto voxels = this->voxelize(*cloud);

  // Until *node is null: the end iterators of PCL's Octree2BufBase belong to no octree,
  // so that nothing ever equals them.
  const auto expect_all_once = [&](auto begin) {
    std::map<typename TestFixture::VoxelIndex, int> visits;
    for (auto& node = begin; *node != nullptr; ++node) {
      if (!node.isLeafNode())
        continue;
      const auto key = node.getCurrentOctreeKey();
      const auto half =
          static_cast<std::int64_t>(this->box_side / this->resolution) / 2;
      const typename TestFixture::VoxelIndex index = {std::int64_t{key.x} - half,
                                                      std::int64_t{key.y} - half,
                                                      std::int64_t{key.z} - half};
      ASSERT_EQ(voxels.count(index), 1u);
      EXPECT_EQ(node.getLeafContainer().getPointCounter(), voxels.at(index).count);
      EXPECT_NEAR(node.getLeafContainer().getIntensity(), voxels.at(index).sum, 1e-3);
      ++visits[index];
    }
    EXPECT_EQ(visits.size(), voxels.size());
    for (const auto& [index, count] : visits)
      EXPECT_EQ(count, 1);
  };
  expect_all_once(octree.leaf_depth_begin());
  expect_all_once(octree.depth_begin());
  expect_all_once(octree.breadth_begin());
  expect_all_once(octree.begin());
  expect_all_once(octree.leaf_breadth_begin());
}

TYPED_TEST(OctreeIntensity, OccupiedVoxelCentresAreTheVoxels)
{
  const auto cloud = this->randomCloud(19, 2000);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  typename TestFixture::Octree::AlignedPointTVector centres;
  const auto voxels = this->voxelize(*cloud);
  EXPECT_EQ(octree.getOccupiedVoxelCenters(centres), voxels.size());
  ASSERT_EQ(centres.size(), voxels.size());
  for (const auto& centre : centres) {
    const auto index = this->voxelOf(centre);
    ASSERT_EQ(voxels.count(index), 1u);
    EXPECT_EQ(centre.x, this->centreOf(index).x);
    EXPECT_EQ(centre.y, this->centreOf(index).y);
    EXPECT_EQ(centre.z, this->centreOf(index).z);
  }
}

TYPED_TEST(OctreeIntensity, AVoxelCanBeDeletedAndFilledAgain)
{
  typename TestFixture::Cloud::Ptr cloud(new typename TestFixture::Cloud);
  const auto point = this->makePoint(0.01f, 0.01f, 0.01f, 5.0f);
  cloud->push_back(point);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  octree.deleteVoxelAtPoint(point);
  EXPECT_EQ(octree.getVoxelIntensityAtPoint(point), 0.0f);
  octree.addPointsFromInputCloud();
  EXPECT_EQ(octree.getVoxelIntensityAtPoint(point), this->expectedIntensity(point));
}

TYPED_TEST(OctreeIntensity, DeleteTreeForgetsEverything)
{
  const auto cloud = this->randomCloud(20, 100);
  typename TestFixture::Octree octree(this->resolution);
  this->anchor(octree);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  octree.deleteTree();
  EXPECT_EQ(octree.getLeafCount(), 0u);
  this->anchor(octree);
  for (const auto& point : *cloud)
    EXPECT_EQ(octree.getVoxelIntensityAtPoint(point), 0.0f);
  octree.addPointsFromInputCloud();
  this->expectAgreement(octree, this->voxelize(*cloud));
}

TYPED_TEST(OctreeIntensity, SerializedTreesComeBackWithTheirLeaves)
{
  const auto cloud = this->randomCloud(21, 1500);
  typename TestFixture::Octree sender(this->resolution);
  this->anchor(sender);
  sender.setInputCloud(cloud);
  sender.addPointsFromInputCloud();
  std::vector<char> bytes;
  std::vector<IntensityLeaf*> leaves;
  sender.serializeTree(bytes, leaves);
  ASSERT_EQ(leaves.size(), sender.getLeafCount());
  EXPECT_FALSE(bytes.empty());

  typename TestFixture::Octree receiver(this->resolution);
  this->anchor(receiver);
  receiver.deserializeTree(bytes, leaves);
  this->expectAgreement(receiver, this->voxelize(*cloud));
}

TYPED_TEST(OctreeIntensity, SerializedTreesComeBackAsOccupancyAlone)
{
  const auto cloud = this->randomCloud(22, 1500);
  typename TestFixture::Octree sender(this->resolution);
  this->anchor(sender);
  sender.setInputCloud(cloud);
  sender.addPointsFromInputCloud();
  std::vector<char> bytes;
  sender.serializeTree(bytes);

  typename TestFixture::Octree receiver(this->resolution);
  this->anchor(receiver);
  receiver.deserializeTree(bytes);
  const auto voxels = this->voxelize(*cloud);
  ASSERT_EQ(receiver.getLeafCount(), voxels.size());
  for (const auto& [index, voxel] : voxels) {
    EXPECT_TRUE(receiver.isVoxelOccupiedAtPoint(this->centreOf(index)));
    EXPECT_EQ(receiver.getVoxelIntensityAtPoint(this->centreOf(index)), 0.0f);
  }
}

class DoubleBufferedOctreeIntensity
: public OctreeIntensity<OctreeKind<pcl::PointXYZI, pcl::octree::Octree2BufBase>> {};

TEST_F(DoubleBufferedOctreeIntensity, NoLeafLeaksFromEarlierFrames)
{
  Octree octree(resolution);
  anchor(octree);
  for (unsigned int frame = 0; frame < 8; ++frame) {
    // Alternating clouds with most voxels in common, so that leaves are taken over from
    // the other buffer and from two frames ago.
    const auto cloud = randomCloud(30 + frame % 3, 1500);
    octree.switchBuffers();
    octree.setInputCloud(cloud);
    octree.addPointsFromInputCloud();
    SCOPED_TRACE("frame " + std::to_string(frame));
    expectAgreement(octree, voxelize(*cloud));
    // As PCL's compression does, which cleans the buffer behind.
    std::vector<char> bytes;
    octree.serializeTree(bytes, frame > 0);
    EXPECT_FALSE(bytes.empty());
  }
}

TEST_F(DoubleBufferedOctreeIntensity, NoLeafLeaksThroughDeserializedTrees)
{
  Octree sender(resolution);
  Octree receiver(resolution);
  anchor(sender);
  anchor(receiver);
  for (unsigned int frame = 0; frame < 4; ++frame) {
    const auto cloud = randomCloud(40, 300);
    sender.switchBuffers();
    sender.setInputCloud(cloud);
    sender.addPointsFromInputCloud();
    std::vector<char> bytes;
    sender.serializeTree(bytes, frame > 0);

    receiver.switchBuffers();
    receiver.deserializeTree(bytes, frame > 0);
    ASSERT_EQ(receiver.getLeafCount(), sender.getLeafCount());
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
  Octree sender(resolution);
  Octree receiver(resolution);
  anchor(sender);
  anchor(receiver);
  for (unsigned int frame = 0; frame < 5; ++frame) {
    const auto cloud = randomCloud(50 + frame, 800);
    sender.switchBuffers();
    sender.setInputCloud(cloud);
    sender.addPointsFromInputCloud();
    std::vector<char> bytes;
    std::vector<IntensityLeaf*> leaves;
    sender.serializeTree(bytes, leaves, frame > 0);
    receiver.switchBuffers();
    receiver.deserializeTree(bytes, leaves, frame > 0);
    SCOPED_TRACE("frame " + std::to_string(frame));
    expectAgreement(receiver, voxelize(*cloud));
  }
}

} // namespace
