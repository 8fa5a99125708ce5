// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/point_views.h"
#include "support/unordered_clouds.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::io::test::viewOf;

using Points = std::vector<std::array<double, 3>>;

EncoderSettings
orderSettings(double resolution = 0.001)
{
  EncoderSettings settings;
  settings.resolution = resolution;
  settings.keep_order = true;
  settings.i_frame_rate = 5;
  return settings;
}

/** \brief A stream whose decoded points are compared with the encoded ones. */
class OrderedStream {
public:
  explicit OrderedStream(const EncoderSettings& settings = orderSettings())
  : edge_(settings.resolution), encoder_(settings, IntensityUnit::None)
  {
    decoder_.setDecodesVoxels(false);
  }

  /** \brief Bytes of a cloud, each coordinate of which is within half an edge in its
   * place. */
  std::size_t
  encode(const PointView& view, const Points& points)
  {
    mean_edges_off = {};
    Bytes bytes;
    const CompressionStatus status = encoder_.encode(view, {}, bytes);
    EXPECT_TRUE(status.ok()) << status.message();
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder_, bytes, back), CompressionCode::Ok);
    EXPECT_TRUE(back.points.areThere());
    EXPECT_EQ(back.cloudSize(), points.size());
    Points decoded(points.size(), {NAN, NAN, NAN});
    for (std::size_t i = 0; i < back.pointCount(); ++i)
      decoded[back.cloudIndex(i)] = back.points.positions[i];
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (std::isnan(points[i][axis])) {
          EXPECT_TRUE(std::isnan(decoded[i][axis]));
          continue;
        }
        const double off = decoded[i][axis] - points[i][axis];
        EXPECT_LE(std::abs(off), 0.5001 * edge_) << i << ' ' << points[i][axis];
        mean_edges_off[axis] += off / edge_ / static_cast<double>(points.size());
      }
    return bytes.size();
  }

  std::size_t
  encode(const Points& points)
  {
    return encode(viewOf(points), points);
  }

  void
  expectRefusal(const Points& points, const std::string& words)
  {
    Bytes bytes;
    const CompressionStatus status = encoder_.encode(viewOf(points), {}, bytes);
    EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
    EXPECT_NE(status.message().find(words), std::string::npos) << status;
    EXPECT_TRUE(bytes.empty());
  }

  bool
  isIFrame() const
  {
    return encoder_.statistics().coding.is_i_frame;
  }

  std::array<double, 3> mean_edges_off{}; ///< of the last cloud

private:
  double edge_;
  CloudEncoder encoder_;
  FrameDecoder decoder_;
};

Points
anywhere(std::uint64_t seed, std::size_t count, float extent)
{
  std::mt19937_64 random(seed);
  Points points(count);
  for (std::array<double, 3>& point : points)
    for (double& coordinate : point)
      coordinate = static_cast<double>(uniform(random, -extent, extent));
  return points;
}

TEST(OrderedClouds, OnAGridOfTheirOwnAreOffByNothingOnAverage)
{
  std::mt19937_64 random(8);
  for (const double grid : {0.01, 0.005, 0.0025, 0.001}) { // an edge and parts of it
    OrderedStream stream(orderSettings(0.01));
    for (unsigned int cloud = 0; cloud < 2; ++cloud) {
      Points points;
      for (unsigned int i = 0; i < 4000; ++i)
        points.push_back({1000.003 + grid * static_cast<double>(below(random, 50'000)),
                          4000.0 + 0.5 * static_cast<double>(below(random, 90)),
                          -0.25 + 0.003});
      stream.encode(points);
      EXPECT_NEAR(stream.mean_edges_off[0], 0.0, 0.02) << grid;
      EXPECT_NEAR(stream.mean_edges_off[1], 0.0, 1e-4) << grid;
      EXPECT_NEAR(stream.mean_edges_off[2], 0.0, 1e-4) << grid;
    }
  }
}

/** \brief Heights along lines to and fro, as an aircraft scans them: whole centimetres
 * far from the world's origin. */
Points
airborneScan(std::uint64_t seed, std::size_t count)
{
  std::mt19937_64 random(seed);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const double along = static_cast<double>(i) / 100.0;
    const double across = 200.0 * std::abs(std::remainder(along, 2.0));
    const double height = 400.0 + 3.0 * std::sin(0.05 * across);
    const std::array<double, 3> point = {
        637000.0 + across,
        4848000.0 + along,
        height + 0.05 * static_cast<double>(below(random, 4))};
    points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      points.back()[axis] = std::round(100.0 * point[axis]) / 100.0;
  }
  return points;
}

/** \brief A lidar that drives: `lasers` fire in turns, none of them is known. */
Points
drivingScan(std::size_t lasers, std::size_t firings)
{
  Points points;
  for (std::size_t firing = 0; firing < firings; ++firing)
    for (std::size_t laser = 0; laser < lasers; ++laser) {
      const double angle = -2.0 * M_PI * static_cast<double>(firing) / 1080.0;
      const double slope = 0.03 * (static_cast<double>(5 * laser % 16) - 8.0);
      const double range = 9.0 + 3.0 * slope + 2.0 * std::sin(5.0 * angle) +
                           0.002 * static_cast<double>((37 * firing + 11 * laser) % 5);
      points.push_back({range * std::cos(angle) + 0.001 * static_cast<double>(firing),
                        range * std::sin(angle) + 0.02 * range * range / 90.0,
                        range * slope});
    }
  return points;
}

TEST(OrderedClouds, OfAnyPointsComeBackInTheirOrder)
{
  OrderedStream stream;
  for (unsigned int i = 0; i < 7; ++i) {
    SCOPED_TRACE(i);
    stream.encode(anywhere(i, i == 4 ? 1 : 500 + 30 * i, i == 5 ? 5000.0f : 8.0f));
    EXPECT_EQ(stream.isIFrame(), i % 5 == 0);
  }
}

TEST(OrderedClouds, KeepRowsAndColumnsWithoutRays)
{
  OrderedStream stream;
  for (unsigned int i = 0; i < 3; ++i) {
    Points points = anywhere(10 + i, 40 * 30, 3.0f);
    for (std::size_t pixel = 0; pixel < points.size(); pixel += 7)
      points[pixel] = {NAN, NAN, NAN};
    for (std::size_t pixel = 3; pixel < points.size(); pixel += 11)
      points[pixel] = {0.0, 0.0, 0.0};
    stream.encode(viewOf(points, {40, 30}), points);
    EXPECT_EQ(stream.isIFrame(), i == 0);
  }
}

TEST(OrderedClouds, FarFromTheOriginTakeFewBytes)
{
  // Coordinates are whole centimetres, so that a finer edge takes hardly more.
  for (const double edge : {0.01, 0.001}) {
    OrderedStream stream(orderSettings(edge));
    const Points points = airborneScan(1, 20000);
    EXPECT_LT(8 * stream.encode(points), 12 * points.size());
  }
}

TEST(OrderedClouds, FartherThanFloatsReachAreInDoublePrecision)
{
  for (const double extent : {900.0, 17000.0}) {
    const Points points = anywhere(2, 100, static_cast<float>(extent));
    CloudEncoder encoder(orderSettings(), IntensityUnit::None);
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(viewOf(points), {}, bytes).ok());
    FrameDecoder decoder;
    decoder.setDecodesVoxels(false);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(back.needsDoubles(), extent > 1e3);
  }
}

TEST(OrderedClouds, WithoutPointsKeepRowsAndColumns)
{
  OrderedStream stream;
  const Points nothing(40 * 30, {NAN, NAN, NAN});
  Points one = nothing; // with more than 64 pixels a point
  one[77] = {1.0, 2.0, 3.0};
  for (const Points& points : {nothing, one, nothing, one})
    stream.encode(viewOf(points, {40, 30}), points);
}

TEST(OrderedClouds, PointsThatAreLeftOutAreCounted)
{
  Points points = anywhere(3, 40 * 30, 2.0f);
  for (std::size_t pixel = 0; pixel < points.size(); pixel += 3)
    points[pixel] = {NAN, NAN, NAN};
  CloudEncoder encoder(orderSettings(), IntensityUnit::None);
  Bytes bytes;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(encoder.encode(viewOf(points, {40, 30}), {}, bytes).ok());
    const VoxelizationStatistics& counts = encoder.statistics().voxelization;
    EXPECT_EQ(counts.points, 1200u);
    EXPECT_EQ(counts.points_not_finite, 400u);
    EXPECT_EQ(counts.points_used, 800u);
    EXPECT_EQ(counts.points_outside_box, 0u);
  }
}

TEST(OrderedClouds, OfLasersInTurnsTakeFewerBytesThanVoxels)
{
  const Points points = drivingScan(16, 400);
  const std::size_t bytes = OrderedStream().encode(points);
  EXPECT_LT(
      2 * bytes,
      UnorderedClouds(orderSettings()).encode(viewOf(points), WorldPose::Identity()));
  // It is the period of the lasers that does it.
  Points by_laser;
  for (std::size_t laser = 0; laser < 17; ++laser)
    for (std::size_t i = laser; i < points.size(); i += 17)
      by_laser.push_back(points[i]);
  EXPECT_LT(2 * bytes, OrderedStream().encode(by_laser));
}

TEST(OrderedClouds, OfLidarsWithAnotherOrderThanTheirFirings)
{
  // On rays they would come back row by row.
  std::mt19937_64 random(4);
  Points points;
  std::vector<std::uint16_t> rings;
  for (int column = 0; column < 200; ++column) {
    std::array<std::uint16_t, 8> order = {0, 1, 2, 3, 4, 5, 6, 7};
    std::shuffle(order.begin(), order.end(), random);
    for (const std::uint16_t ring : order) {
      const double angle = 2.0 * M_PI * column / 200;
      const double range = 5.0 + std::sin(3.0 * angle);
      points.push_back({range * std::cos(angle),
                        range * std::sin(angle),
                        range * (0.1 * ring - 0.3)});
      rings.push_back(ring);
    }
  }
  PointView view = viewOf(points);
  view.fields.push_back({{"ring", FieldType::UInt16}, rings.data(), sizeof(rings[0])});
  OrderedStream stream;
  for (int i = 0; i < 2; ++i)
    stream.encode(view, points);
}

TEST(OrderedClouds, NeedsSettingsThatKeepPoints)
{
  EncoderSettings settings = orderSettings();
  settings.aggregation = Aggregation::Sum;
  CloudEncoder encoder(settings, IntensityUnit::Native);
  Bytes bytes;
  const CompressionStatus status =
      encoder.encode(viewOf(anywhere(1, 10, 1.0f)), {}, bytes);
  EXPECT_TRUE(bytes.empty());
  EXPECT_FALSE(status.ok());
  EXPECT_NE(status.message().find("aggregation"), std::string::npos);
}

TEST(OrderedClouds, ThatCannotBeKeptAreLeftOut)
{
  OrderedStream stream;
  const Points points = anywhere(1, 10, 1.0f);
  stream.encode(points);
  Points with_far = points;
  with_far[3][1] = 1e6; // 2^29 edges away
  const char* const words = "from each other, or 2^40 from the origin of their "
                            "coordinates: set bounding_box around the points to keep, "
                            "or take a larger resolution";
  stream.expectRefusal(with_far, words);
  with_far[3][1] = std::numeric_limits<double>::max();
  stream.expectRefusal(with_far, words);
  std::swap(with_far.front(), with_far[3]);
  stream.expectRefusal(with_far, words);
  stream.encode(points); // the stream goes on
}
} // namespace
