// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "filters/moved_points.h"
#include "support/all_lanes.h"
#include "support/float_values.h"
#include "support/test_memory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using pcl_ext::test::AllLanes;
using pcl_ext::test::infinity;
using pcl_ext::test::MemoryUse;
using pcl_ext::test::TestOfLanes;

constexpr float largest = std::numeric_limits<float>::max();

float
anyCoordinate(std::mt19937_64& random)
{
  const std::uint64_t kind = random() % 16;
  const auto bits = static_cast<std::uint32_t>(random());
  float any;
  std::memcpy(&any, &bits, sizeof(any));
  const float special[] = {std::numeric_limits<float>::quiet_NaN(),
                           infinity,
                           -infinity,
                           largest,
                           -largest,
                           std::numeric_limits<float>::denorm_min(),
                           -0.0f};
  if (kind == 0)
    return special[random() % 7];
  if (kind == 1)
    return any;
  return static_cast<float>(static_cast<std::int32_t>(bits)) * 0x1p-28f;
}

detail::PointMove
randomMove(std::mt19937_64& random, bool has_box)
{
  detail::PointMove move;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const auto uniform = [&] {
    return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
  };
  pose.translate(Eigen::Vector3d(uniform(), uniform(), uniform()));
  pose.rotate(Eigen::AngleAxisd(
      3.0 * uniform(), Eigen::Vector3d(uniform(), uniform(), 1.1).normalized()));
  const Eigen::Isometry3f float_pose = pose.cast<float>();
  for (Eigen::Index row = 0; row < 3; ++row) {
    const auto axis = static_cast<std::size_t>(row);
    for (Eigen::Index column = 0; column < 4; ++column)
      move.rows[axis][static_cast<std::size_t>(column)] =
          float_pose.matrix()(row, column);
    move.min[axis] = has_box ? -4.0f - static_cast<float>(row) : -infinity;
    move.max[axis] = has_box ? 3.0f + static_cast<float>(row) : infinity;
  }
  return move;
}

/** \brief The move as it is specified, which is how Eigen does it where it has no
 * instruction for a product and a sum. */
Eigen::Vector3f
moveOne(const Eigen::Vector3f& point, const detail::PointMove& move)
{
  Eigen::Vector3f place;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const std::array<float, 4>& row = move.rows[static_cast<std::size_t>(axis)];
    // Volatile, so that the compiler uses no such instruction either.
    volatile float sum = row[0] * point.x();
    for (Eigen::Index column = 1; column < 3; ++column) {
      volatile float product = row[static_cast<std::size_t>(column)] * point[column];
      sum = sum + product;
    }
    place[axis] = sum + row[3];
  }
  return place;
}

using MovePointsT = void (*)(const detail::PointBytes&,
                             const detail::PointMove&,
                             float*,
                             detail::MovedPoints&);

void
expectMoved(MovePointsT move_points, std::mt19937_64& random, bool has_box)
{
  const detail::PointMove move = randomMove(random, has_box);
  const std::size_t count = random() % (detail::MovedPoints::capacity + 1);
  const std::size_t stride = 12 + random() % 30; // bytes, not aligned
  std::vector<Eigen::Vector3f> points(count);
  // Not a byte more than the last z, so that a sanitizer sees what is read after it.
  std::vector<unsigned char> bytes(count == 0 ? 0 : (count - 1) * stride + 12);
  for (std::size_t i = 0; i < count; ++i) {
    points[i] = {anyCoordinate(random), anyCoordinate(random), anyCoordinate(random)};
    std::memcpy(&bytes[i * stride], points[i].data(), 12);
  }
  std::vector<float> output(count * detail::moved_point_floats, -7.0f);
  detail::MovedPoints moved;
  move_points({bytes.data(), stride, count}, move, output.data(), moved);

  std::size_t kept = 0;
  std::size_t not_finite = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f place = moveOne(points[i], move);
    if (!place.allFinite()) {
      ++not_finite;
      continue;
    }
    bool is_inside = true;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      is_inside &= place[axis] >= move.min[static_cast<std::size_t>(axis)] &&
                   place[axis] <= move.max[static_cast<std::size_t>(axis)];
    if (!is_inside)
      continue;
    ASSERT_LT(kept, moved.count);
    const float* const result = &output[kept * detail::moved_point_floats];
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      ASSERT_EQ(result[axis], place[axis]) << "of point " << i; // to the last bit
    ASSERT_EQ(result[3], 1.0f);
    ASSERT_EQ(std::memcmp(&moved.depths[kept], &points[i].z(), sizeof(float)), 0);
    ASSERT_EQ(moved.sources[kept], i);
    ++kept;
  }
  EXPECT_EQ(moved.count, kept);
  EXPECT_EQ(moved.not_finite, not_finite);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t field = 4; field < detail::moved_point_floats; ++field)
      EXPECT_EQ(output[i * detail::moved_point_floats + field], -7.0f);
}

template <typename LanesOfT>
using MovedPointsOf = TestOfLanes<LanesOfT>;
TYPED_TEST_SUITE(MovedPointsOf, AllLanes);

TYPED_TEST(MovedPointsOf, AnyLanesAreTheSameToTheLastBit)
{
  std::mt19937_64 random(1);
  for (int i = 0; i < 3000; ++i)
    expectMoved(&detail::movePointsWith<typename TypeParam::Lanes>, random, i % 2 == 0);
}

TEST(MovedPoints, ABoxMayBeAtInfinity)
{
  std::mt19937_64 random(2);
  detail::PointMove move = randomMove(random, true);
  const float points[] = {1.0f, 2.0f, 3.0f, infinity, 2.0f, 3.0f};
  std::array<float, 2 * detail::moved_point_floats> output;
  detail::MovedPoints moved;
  for (const float at : {infinity, -infinity}) {
    move.min.fill(at);
    move.max.fill(at);
    detail::movePoints({reinterpret_cast<const unsigned char*>(points), 12, 2},
                       move,
                       output.data(),
                       moved);
    EXPECT_EQ(moved.count, 0u);
    EXPECT_EQ(moved.not_finite, 1u);
  }
}

template <typename PointT>
void
expectNoAllocations()
{
  std::mt19937_64 random(3);
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  preprocessor.setCropBox({-4.0, -4.0, -4.0}, {4.0, 4.0, 4.0});
  pcl::PointCloud<PointT> cloud;
  for (int i = 0; i < 5000; ++i) {
    PointT point;
    point.x = anyCoordinate(random);
    point.y = anyCoordinate(random);
    point.z = anyCoordinate(random);
    cloud.push_back(point);
  }
  cloud.header.frame_id = "a frame_id too long for the string itself";
  pcl::PointCloud<pcl::PointXYZI> output;
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  // PCL's clouds have an allocator of their own, which is not counted.
  const pcl::PointXYZI* const memory = output.points.data();
  const MemoryUse memory_use;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(preprocessor.process(cloud, output).ok());
    EXPECT_EQ(output.points.data(), memory);
  }
  EXPECT_EQ(memory_use.allocations(), 0u);
  EXPECT_GT(output.size(), 100u);
}

TEST(SensorPreprocessorMemory, NothingIsAllocatedOnceTheStreamRuns)
{
  expectNoAllocations<pcl::PointXYZ>();
  expectNoAllocations<pcl::PointXYZI>();
  expectNoAllocations<pcl::PointXYZINormal>();
}

TEST(SensorPreprocessorMemory, ACloudMayBeItsOwnOutputAgainAndAgain)
{
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (int round = 0; round < 4; ++round) {
    cloud.clear();
    for (int i = 0; i < 1000; ++i) {
      pcl::PointXYZI point;
      point.x = static_cast<float>(i);
      point.intensity = static_cast<float>(round);
      cloud.push_back(point);
    }
    cloud.header.stamp = static_cast<std::uint64_t>(round);
    cloud.header.frame_id = "cell";
    ASSERT_TRUE(preprocessor.process(cloud, cloud).ok());
    ASSERT_EQ(cloud.size(), 1000u);
    EXPECT_EQ(cloud.width, 1000u);
    EXPECT_EQ(cloud.header.stamp, static_cast<std::uint64_t>(round));
    EXPECT_EQ(cloud.header.frame_id, "cell");
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_EQ(cloud[i].x, static_cast<float>(i));
      EXPECT_EQ(cloud[i].intensity, static_cast<float>(round));
    }
  }
}

} // namespace
