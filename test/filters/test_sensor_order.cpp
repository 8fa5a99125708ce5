// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/lidar_clouds.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

struct TimedPoint {
  PCL_ADD_POINT4D
  double time;
  std::uint16_t ring;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;

} // namespace

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(TimedPoint,
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (double, time, time)(std::uint16_t, ring, ring))
// clang-format on

namespace {

using namespace pcl_ext;

constexpr int ring_count = 16;
constexpr int column_count = 90;
constexpr double begin = 1.6e9;
constexpr double period = 1e-4;

/** \brief A lidar's points, column after column; each fifth is missing, and columns 40
 * to 44 are.
 * \param[in] delay of a row to the one before, seconds
 */
pcl::PointCloud<TimedPoint>
measuredCloud(double delay = 0.0)
{
  std::mt19937 random(4);
  pcl::PointCloud<TimedPoint> cloud;
  for (int column = 0; column < column_count; ++column)
    for (int row = 0; row < ring_count; ++row) {
      if (random() % 5 == 0 || (column >= 40 && column < 45))
        continue;
      const double angle = 2.0 * M_PI / column_count * column;
      const float range = 4.0f + 0.001f * static_cast<float>(random() % 1000);
      TimedPoint point{};
      point.x = range * static_cast<float>(std::cos(angle));
      point.y = range * static_cast<float>(std::sin(angle));
      point.z = 0.1f * static_cast<float>(row);
      point.time = begin + period * column + delay * row;
      point.ring = static_cast<std::uint16_t>(row);
      cloud.push_back(point);
    }
  return cloud;
}

pcl::PCLPointCloud2
received(const pcl::PointCloud<TimedPoint>& cloud)
{
  using Compressor = io::OctreePointCloudIntensityCompression<TimedPoint, NoIntensity>;
  io::IntensityCompressionSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  settings.fields = {{"ring"}, {"time"}};
  std::vector<std::uint8_t> bytes;
  EXPECT_TRUE(Compressor(settings).encodePointCloud(cloud.makeShared(), bytes).ok());
  Compressor::PointCloudPtr decoded;
  EXPECT_TRUE(Compressor().decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(*decoded, message);
  return message;
}

pcl::PCLPointCloud2
shuffled(pcl::PointCloud<TimedPoint> cloud)
{
  std::mt19937 random(5);
  std::shuffle(cloud.begin(), cloud.end(), random);
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  return message;
}

TEST(SensorOrder, IsThatInWhichPointsWereMeasured)
{
  const pcl::PointCloud<TimedPoint> sent = measuredCloud(2e-6);
  for (pcl::PCLPointCloud2 message : {received(sent), shuffled(sent)}) {
    ASSERT_TRUE(sortByTime(message).ok());
    pcl::PointCloud<TimedPoint> cloud;
    pcl::fromPCLPointCloud2(message, cloud);
    ASSERT_EQ(cloud.size(), sent.size());
    EXPECT_EQ(cloud.height, 1u);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_EQ(cloud[i].ring, sent[i].ring);
      EXPECT_EQ(cloud[i].time, sent[i].time);
      EXPECT_NEAR(cloud[i].x, sent[i].x, 0.000501);
    }
  }
}

TEST(SensorOrder, RowsAreRingsAndColumnsAreTimes)
{
  const pcl::PointCloud<TimedPoint> sent = measuredCloud();
  for (const std::uint32_t width : {0u, 100u}) {
    pcl::PCLPointCloud2 message = received(sent);
    ASSERT_TRUE(arrangeByRing(message, {width, 0}).ok());
    EXPECT_EQ(message.width, width > 0 ? width : column_count);
    ASSERT_EQ(message.height, std::uint32_t{ring_count});
    EXPECT_FALSE(message.is_dense);
    pcl::PointCloud<TimedPoint> cloud;
    pcl::fromPCLPointCloud2(message, cloud);
    for (const TimedPoint& point : sent) {
      const auto column = static_cast<int>(std::lround((point.time - begin) / period));
      TimedPoint& found = cloud.at(column, point.ring);
      EXPECT_EQ(found.ring, point.ring);
      EXPECT_EQ(found.time, point.time);
      EXPECT_NEAR(found.y, point.y, 0.000501);
      found.x = std::numeric_limits<float>::quiet_NaN();
    }
    // All others are missing.
    for (const TimedPoint& point : cloud)
      EXPECT_TRUE(std::isnan(point.x));
    EXPECT_TRUE(std::isnan(cloud.at(42, 3).time));
    EXPECT_EQ(cloud.at(42, 3).ring, 0);
    // Without the missing ones the order is that of the times.
    message = received(sent);
    ASSERT_TRUE(arrangeByRing(message).ok());
    ASSERT_TRUE(sortByTime(message).ok());
    EXPECT_EQ(message.width, sent.size());
  }
}

/** \brief The message of an error; the cloud must be as it was. */
template <typename RestoreT>
std::string
errorOf(const pcl::PCLPointCloud2& cloud, const RestoreT& restore)
{
  pcl::PCLPointCloud2 changed = cloud;
  const PreprocessingStatus status = restore(changed);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(changed.data, cloud.data);
  EXPECT_EQ(changed.width, cloud.width);
  return status.message();
}

TEST(SensorOrder, OfCloudsThatDoNotTellItIsAnError)
{
  const auto by_time = [](pcl::PCLPointCloud2& cloud) { return sortByTime(cloud); };
  const auto by_ring = [](pcl::PCLPointCloud2& cloud) { return arrangeByRing(cloud); };
  const pcl::PCLPointCloud2 good = shuffled(measuredCloud());
  pcl::PCLPointCloud2 cloud = good;
  cloud.fields[4].name = "laser";
  EXPECT_EQ(errorOf(cloud, by_time),
            "the cloud has no field 'ring', 'channel', 'line'");
  EXPECT_TRUE(sortByTime(cloud, {"", "laser"}).ok());
  EXPECT_EQ(errorOf(good,
                    [](pcl::PCLPointCloud2& changed) {
                      return sortByTime(changed, {"stamp", ""});
                    }),
            "the cloud has no field 'stamp'");
  cloud = good;
  cloud.fields[1].datatype = pcl::PCLPointField::INT32;
  EXPECT_EQ(errorOf(cloud, by_ring),
            "coordinates must be FLOAT32, or FLOAT64, as those of missing points are "
            "NaN");
  cloud = good;
  cloud.fields[3].datatype = pcl::PCLPointField::FLOAT32;
  cloud.fields[3].count = 2;
  EXPECT_EQ(errorOf(cloud, by_time),
            "field 'time' has 2 values a point; it must have one");
  EXPECT_EQ(errorOf(good,
                    [](pcl::PCLPointCloud2& changed) {
                      return arrangeByRing(changed, {0, 8});
                    }),
            "the points need 90 columns and 16 rows; there may be 65536 and 8");
  EXPECT_EQ(errorOf(shuffled(measuredCloud(1e-6)), by_ring),
            "most points have a time of their own: there are no columns of points of "
            "the same time");

  const auto with = [](const auto& change) {
    pcl::PointCloud<TimedPoint> changed = measuredCloud();
    change(changed);
    return shuffled(changed);
  };
  EXPECT_EQ(errorOf(with([](auto& points) { points[7] = points[8]; }), by_ring),
            "two points have the same ring and time");
  EXPECT_EQ(errorOf(with([](auto& points) { points[7].time = NAN; }), by_time),
            "field 'time' of a point is not a number");
  EXPECT_EQ(errorOf(with([](auto& points) { points[7].time = INFINITY; }), by_ring),
            "the points need inf columns and 16 rows; there may be 65536 and 65536");
  EXPECT_EQ(errorOf(with([](auto& points) {
                      points[7].ring = 40000;
                      points.back().time += 1.0;
                    }),
                    by_ring),
            "10090 columns and 40001 rows are more than 16777216 pixels");
}

} // namespace
