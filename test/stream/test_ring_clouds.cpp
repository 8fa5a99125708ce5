// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/point_views.h"
#include "support/unordered_clouds.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

struct RingCloud {
  std::vector<std::array<float, 3>> points;
  std::vector<std::int16_t> rings;
};

/** \brief What differs from a lidar whose columns are always at the same angles. */
struct RingNoise {
  double begin = 0.0;      ///< angle of the first column
  double jitter = 0.0;     ///< of an angle, columns
  double speed = 1.0;      ///< columns of a turn as a share of those there are
  std::size_t echoes = 1;  ///< of each direction
  std::int16_t offset = 0; ///< of the numbers of the rings
  double lift = 0.0;       ///< of the lens, metres
  double turn = 0.0;       ///< of a ring against the one before, columns
  int columns = 360;       ///< of which a turn has 360
};

/** \brief A lidar in a room of rounded corners; each third point is missing. */
RingCloud
ringCloud(std::uint64_t seed, const RingNoise& noise = {})
{
  std::mt19937_64 random(seed);
  RingCloud cloud;
  constexpr int columns = 360;
  for (int column = 0; column < noise.columns; ++column)
    for (int ring = 0; ring < 16; ++ring) {
      if (below(random, 3) == 0)
        continue;
      const double angle =
          noise.begin -
          2.0 * M_PI / columns *
              (noise.speed * (column + 0.2 * (ring % 4)) + noise.turn * (ring % 8) +
               uniform(random, -0.5f, 0.5f) * noise.jitter);
      const double elevation = 0.02 * ring - 0.11;
      for (std::size_t echo = 0; echo < noise.echoes; ++echo) {
        const double range = 4.0 + std::cos(3.0 * angle) +
                             0.002 * static_cast<double>(below(random, 4)) +
                             0.5 * static_cast<double>(echo);
        cloud.points.push_back(
            {static_cast<float>(range * std::cos(elevation) * std::cos(angle)),
             static_cast<float>(range * std::cos(elevation) * std::sin(angle)),
             static_cast<float>(range * std::sin(elevation) + noise.lift)});
        cloud.rings.push_back(static_cast<std::int16_t>(ring + noise.offset));
      }
    }
  return cloud;
}

PointView
viewOf(const RingCloud& cloud)
{
  PointView view = io::test::viewOf(cloud.points);
  view.fields = {
      {{"ring", FieldType::Int16}, cloud.rings.data(), sizeof(std::int16_t)}};
  return view;
}

/** \brief Encodes clouds with their rings and without. */
class RingClouds : public testing::Test {
protected:
  /** \param[in] effort matters to voxels; scans have the same payload in all */
  static EncoderSettings
  settings(Effort effort = Effort::Fast)
  {
    EncoderSettings settings;
    settings.resolution = 0.001;
    settings.effort = effort;
    settings.keep_points = true;
    settings.i_frame_rate = 10;
    return settings;
  }

  static std::size_t
  encode(CloudEncoder& encoder,
         FrameDecoder& decoder,
         const PointView& view,
         VoxelFrame& back)
  {
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(view, {}, bytes).ok());
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    return bytes.size();
  }

  /** \brief Bytes of a cloud with its rings, whose points are checked. */
  std::size_t
  expectCloud(const RingCloud& cloud, bool is_in_order = true)
  {
    bytes_as_voxels_ = unordered_.encode(viewOf(cloud), WorldPose::Identity());
    VoxelFrame back;
    const std::size_t bytes = encode(encoder_, decoder_, viewOf(cloud), back);
    EXPECT_EQ(back.points.areThere(), encoder_.statistics().coding.has_points);
    EXPECT_EQ(back.cloudWidth(), cloud.points.size());
    EXPECT_EQ(back.cloudHeight(), 1u);
    EXPECT_TRUE(back.fields.empty());
    if (back.points.areThere())
      expectPoints(cloud, back, is_in_order);
    return bytes;
  }

  static void
  expectPoints(const RingCloud& cloud, const VoxelFrame& back, bool is_in_order)
  {
    ASSERT_EQ(back.pointCount(), cloud.points.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> found(cloud.points.size());
      std::vector<double> expected(cloud.points.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        found[back.cloudIndex(i)] = back.points.positions[i][axis];
        expected[i] = static_cast<double>(cloud.points[i][axis]);
      }
      if (!is_in_order) { // of the heights of rings and columns alone
        std::sort(found.begin(), found.end());
        std::sort(expected.begin(), expected.end());
      }
      for (std::size_t i = 0; i < found.size(); ++i)
        ASSERT_NEAR(found[i], expected[i], 0.00051);
    }
  }

  CloudEncoder encoder_{settings(), IntensityUnit::None};
  FrameDecoder decoder_;
  UnorderedClouds unordered_{settings(Effort::Small)};
  std::size_t bytes_as_voxels_ = 0;
};

TEST_F(RingClouds, TakeFewerBytes)
{
  for (std::uint64_t i = 0; i < 4; ++i) {
    const std::size_t bytes = expectCloud(ringCloud(i));
    EXPECT_LT((i == 0 ? 2 : 1) * bytes, bytes_as_voxels_);
    EXPECT_TRUE(encoder_.statistics().coding.has_points);
    EXPECT_EQ(encoder_.statistics().coding.is_i_frame, i == 0);
  }
}

TEST_F(RingClouds, AnywhereTakeHardlyMoreBytes)
{
  for (const double speed : {0.0, 0.05}) { // metres a frame
    WorldPose pose = WorldPose::Identity();
    pose.translate(Eigen::Vector3d(1.2, -0.3, 1.8));
    pose.rotate(Eigen::AngleAxisd(0.8, Eigen::Vector3d(0.6, -0.48, 0.64)));
    CloudEncoder other(settings(), IntensityUnit::None);
    FrameDecoder decoder;
    std::size_t bytes[2] = {};
    for (std::uint64_t i = 0; i < 4; ++i) {
      RingCloud cloud = ringCloud(i);
      VoxelFrame back;
      bytes[0] += encode(other, decoder, viewOf(cloud), back);
      pose.translate(Eigen::Vector3d(speed, 0.0, -0.5 * speed));
      pose.rotate(Eigen::AngleAxisd(0.2 * speed, Eigen::Vector3d(0.0, 0.6, 0.8)));
      for (std::array<float, 3>& point : cloud.points) {
        const Eigen::Vector3d moved =
            pose * Eigen::Vector3d(point[0], point[1], point[2]);
        point = {static_cast<float>(moved.x()),
                 static_cast<float>(moved.y()),
                 static_cast<float>(moved.z())};
      }
      bytes[1] += expectCloud(cloud);
      EXPECT_EQ(encoder_.statistics().coding.is_i_frame, i == 0);
    }
    EXPECT_LT(static_cast<double>(bytes[1]), 1.1 * static_cast<double>(bytes[0]));
    encoder_.requestIFrame();
  }
}

TEST_F(RingClouds, MayTurnFromFrameToFrameAndUnevenly)
{
  for (std::uint64_t i = 0; i < 4; ++i) {
    RingNoise noise;
    noise.begin = 0.3 + 0.0047 * static_cast<double>(i);
    noise.jitter = 0.05;
    noise.speed = i == 3 ? 0.999 : 1.0;
    const std::size_t bytes = expectCloud(ringCloud(i, noise));
    EXPECT_LT(bytes, bytes_as_voxels_) << i;
    EXPECT_TRUE(encoder_.statistics().coding.has_points);
    EXPECT_EQ(encoder_.statistics().coding.is_i_frame, i == 0);
  }
}

TEST_F(RingClouds, OfOtherRaysAndColumnsThatTurnedTakeAsFewBytesAsAtFirst)
{
  RingNoise noise;
  noise.begin = 0.3;
  expectCloud(ringCloud(1, noise));
  // Columns of before fit, a third of one further, but no rays.
  noise.begin += 0.006;
  noise.lift = 0.05;
  const RingCloud lifted = ringCloud(2, noise);
  encoder_.requestIFrame();
  const std::size_t bytes = expectCloud(lifted);
  EXPECT_TRUE(encoder_.statistics().coding.has_points);
  CloudEncoder other(settings(), IntensityUnit::None);
  FrameDecoder decoder;
  VoxelFrame back;
  const std::size_t at_first = encode(other, decoder, viewOf(lifted), back);
  EXPECT_LT(static_cast<double>(bytes), 1.02 * static_cast<double>(at_first));
}

TEST_F(RingClouds, MayHaveAPartOfAColumnInATurn)
{
  // As of a VLP-16, whose turns go on from where the last one ended.
  for (std::uint64_t i = 0; i < 4; ++i) {
    RingNoise noise;
    noise.speed = 360.0 / 360.45;
    noise.begin = -2.0 * M_PI * noise.speed * static_cast<double>(i);
    const std::size_t bytes = expectCloud(ringCloud(i, noise));
    EXPECT_LT(2 * bytes, bytes_as_voxels_) << i;
    EXPECT_EQ(encoder_.statistics().coding.is_i_frame, i == 0);
  }
}

TEST_F(RingClouds, WhoseRingsAreTurnedTakeAsFewBytes)
{
  // Points of a firing are not side by side then, but those of other firings are.
  std::size_t bytes[2] = {};
  for (const bool are_turned : {false, true}) {
    RingNoise noise;
    noise.turn = are_turned ? 5.0 : 0.0;
    encoder_.requestIFrame();
    for (std::uint64_t i = 0; i < 2; ++i)
      bytes[are_turned ? 1 : 0] += expectCloud(ringCloud(i, noise));
  }
  EXPECT_LT(10 * bytes[1], 12 * bytes[0]);
}

TEST_F(RingClouds, HaveAnyOrderOfPointsAndMayEndBehindTheirBegin)
{
  std::mt19937_64 random(20);
  RingNoise noise;
  noise.columns = 365;
  const RingCloud cloud = ringCloud(5, noise);
  std::vector<std::size_t> order(cloud.points.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  std::shuffle(order.begin(), order.end(), random);
  RingCloud shuffled;
  for (const std::size_t i : order) {
    shuffled.points.push_back(cloud.points[i]);
    shuffled.rings.push_back(cloud.rings[i]);
  }
  const std::size_t bytes = expectCloud(shuffled, false);
  EXPECT_LT(2 * bytes, bytes_as_voxels_);
}

TEST_F(RingClouds, MayHavePointsAtTheSensor)
{
  for (std::uint64_t i = 0; i < 2; ++i) {
    RingCloud cloud = ringCloud(i);
    for (std::size_t point = 0; point < cloud.points.size(); point += 100)
      cloud.points[point] = {0.0f, 0.0f, 0.0f};
    const std::size_t bytes = expectCloud(cloud);
    EXPECT_LT(2 * bytes, bytes_as_voxels_);
  }
}

TEST_F(RingClouds, GoOnBehindOneWithoutAnOrder)
{
  std::mt19937_64 random(22);
  RingCloud cloud = ringCloud(1);
  for (std::array<float, 3>& point : cloud.points)
    point = {uniform(random, -5.0f, 5.0f),
             uniform(random, -5.0f, 5.0f),
             uniform(random, -5.0f, 5.0f)};
  std::fill(cloud.rings.begin(), cloud.rings.end(), std::int16_t{-1});
  expectCloud(ringCloud(0));
  expectCloud(cloud);
  EXPECT_TRUE(encoder_.statistics().coding.is_i_frame);
  for (std::uint64_t i = 2; i < 4; ++i) {
    expectCloud(ringCloud(i));
    EXPECT_TRUE(encoder_.statistics().coding.has_points);
    EXPECT_EQ(encoder_.statistics().coding.is_i_frame, i == 2);
  }
}

TEST_F(RingClouds, ThatAreNoneAreFoundFromElevationsOrNotAtAll)
{
  RingNoise negative;
  negative.offset = -1;
  RingCloud of_one_ring = ringCloud(6);
  std::fill(of_one_ring.rings.begin(), of_one_ring.rings.end(), std::int16_t{3});
  RingCloud of_many_rings = ringCloud(7);
  of_many_rings.rings[9] = 32767;
  RingCloud of_one_place = ringCloud(8);
  std::fill(of_one_place.points.begin(),
            of_one_place.points.end(),
            std::array<float, 3>{0.0f, 0.0f, 1.0f});
  for (const RingCloud& cloud :
       {ringCloud(6, negative), of_one_ring, of_many_rings, of_one_place}) {
    expectCloud(cloud);
    PointView without_rings = viewOf(cloud);
    without_rings.fields.clear();
    Bytes bytes[2];
    for (const bool has_rings : {false, true}) {
      CloudEncoder encoder(settings(), IntensityUnit::None);
      const PointView view = has_rings ? viewOf(cloud) : without_rings;
      EXPECT_TRUE(encoder.encode(view, {}, bytes[has_rings ? 1 : 0]).ok());
    }
    EXPECT_EQ(bytes[0], bytes[1]);
    encoder_.requestIFrame();
  }
}

TEST_F(RingClouds, OfTwoEchoesAndOfColumnsAnywhereComeBack)
{
  RingNoise two_echoes;
  two_echoes.echoes = 2;
  expectCloud(ringCloud(6, two_echoes), false);
  RingNoise unordered;
  unordered.jitter = 20.0;
  encoder_.requestIFrame();
  expectCloud(ringCloud(6, unordered));
}

TEST_F(RingClouds, WithMoreRingsTakeAnIFrame)
{
  RingCloud fewer = ringCloud(9);
  for (std::size_t i = fewer.rings.size(); i-- > 0;)
    if (fewer.rings[i] > 13) {
      fewer.rings.erase(fewer.rings.begin() + static_cast<std::ptrdiff_t>(i));
      fewer.points.erase(fewer.points.begin() + static_cast<std::ptrdiff_t>(i));
    }
  const std::array<std::pair<RingCloud, bool>, 4> clouds = {
      {{fewer, true}, {ringCloud(9), true}, {fewer, false}, {ringCloud(9), false}}};
  for (const auto& [cloud, is_i_frame] : clouds) {
    expectCloud(cloud);
    EXPECT_TRUE(encoder_.statistics().coding.has_points);
    EXPECT_EQ(encoder_.statistics().coding.is_i_frame, is_i_frame);
  }
}

TEST_F(RingClouds, KeepTheRingsThatAreAskedFor)
{
  const RingCloud cloud = ringCloud(10);
  EncoderSettings with_rings = settings();
  with_rings.fields.push_back({"ring", 0.0});
  CloudEncoder encoder(with_rings, IntensityUnit::None);
  VoxelFrame back;
  const std::size_t bytes = encode(encoder, decoder_, viewOf(cloud), back);
  ASSERT_EQ(back.fields.size(), 1u);
  ASSERT_EQ(back.fields[0].numbers.size(), cloud.rings.size());
  for (std::size_t i = 0; i < back.fields[0].numbers.size(); ++i)
    EXPECT_EQ(fieldValue(back.fields[0], back.fields[0].numbers[i]),
              cloud.rings[back.cloudIndex(i)]);
  // The row says which ring it is.
  const std::size_t bytes_without_rings = expectCloud(cloud);
  EXPECT_LT(bytes, bytes_without_rings + 100);
}

} // namespace
