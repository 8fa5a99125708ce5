// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/cloud_outlier_removal.h>
#include <pcl_ext/filters/lidar_clouds.h>

#include "support/lidar_room.h"
#include "support/message_layouts.h"

#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::test;

LidarScan
snowyScan()
{
  LidarRoom room;
  room.width = 180;
  room.height = 16;
  room.snow = 0.05;
  return room.scan();
}

std::vector<bool>
noiseOf(const LidarScan& scan)
{
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  EXPECT_GT(removal.score(scan.view(), log_odds).removed, 50u);
  std::vector<bool> is_noise;
  for (const float number : log_odds)
    is_noise.push_back(number < 0.0f);
  return is_noise;
}

/** \brief A cloud of the points of a scan; all bytes but those of coordinates and ring
 * differ from point to point. */
PCLPointCloud2
messageOf(const LidarScan& scan,
          std::uint8_t datatype,
          bool is_organised,
          std::uint32_t row_padding)
{
  const std::uint32_t size = datatype == PCLPointField::FLOAT64 ? 8 : 4;
  PCLPointCloud2 message;
  message.header.frame_id = "lidar";
  message.header.stamp = 1234;
  message.header.seq = 7;
  message.fields = {makeField("intensity", 0, PCLPointField::FLOAT32),
                    makeField("z", 4, datatype),
                    makeField("x", 4 + 2 * size, datatype),
                    makeField("y", 4 + 3 * size, datatype),
                    makeField("ring", 4 + 4 * size, PCLPointField::UINT16)};
  message.point_step = 4 + 4 * size + 5;
  message.width = is_organised ? scan.width : scan.width * scan.height;
  message.height = is_organised ? scan.height : 1;
  message.row_step = message.width * message.point_step + row_padding;
  message.is_dense = 1;
  message.data.resize(std::size_t{message.row_step} * message.height);
  for (std::size_t i = 0; i < message.data.size(); ++i)
    message.data[i] = static_cast<std::uint8_t>(i * 37 + i / 256);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    std::uint8_t* const point = message.data.data() +
                                i / message.width * message.row_step +
                                i % message.width * message.point_step;
    const float* const xyz = &scan.coordinates[3 * i];
    writeNumber(point + 4, datatype, static_cast<double>(xyz[2]));
    writeNumber(point + 4 + 2 * size, datatype, static_cast<double>(xyz[0]));
    writeNumber(point + 4 + 3 * size, datatype, static_cast<double>(xyz[1]));
    writeNumber(point + 4 + 4 * size,
                PCLPointField::UINT16,
                static_cast<double>(i / scan.width));
  }
  return message;
}

void
expectSameDescription(const PCLPointCloud2& cloud, const PCLPointCloud2& before)
{
  EXPECT_EQ(cloud.header.frame_id, before.header.frame_id);
  EXPECT_EQ(cloud.header.stamp, before.header.stamp);
  EXPECT_EQ(cloud.header.seq, before.header.seq);
  EXPECT_EQ(cloud.point_step, before.point_step);
  EXPECT_EQ(cloud.is_bigendian, before.is_bigendian);
  ASSERT_EQ(cloud.fields.size(), before.fields.size());
  for (std::size_t i = 0; i < cloud.fields.size(); ++i) {
    EXPECT_EQ(cloud.fields[i].name, before.fields[i].name);
    EXPECT_EQ(cloud.fields[i].offset, before.fields[i].offset);
    EXPECT_EQ(cloud.fields[i].datatype, before.fields[i].datatype);
  }
}

TEST(CloudOutlierRemoval, PointsAreMissingInRowsAndColumnsAndElseErased)
{
  const LidarScan scan = snowyScan();
  const std::vector<bool> is_noise = noiseOf(scan);
  const auto count =
      static_cast<std::size_t>(std::count(is_noise.begin(), is_noise.end(), true));
  for (const bool is_organised : {true, false})
    for (const std::uint8_t datatype : {PCLPointField::FLOAT32, PCLPointField::FLOAT64})
      for (const std::uint32_t padding : {0u, 13u}) {
        PCLPointCloud2 before = messageOf(scan, datatype, is_organised, padding);
        // All other bytes stay.
        std::vector<std::uint8_t> expected;
        const std::uint32_t size = datatype == PCLPointField::FLOAT64 ? 8 : 4;
        for (std::size_t i = 0; i < scan.size(); ++i) {
          std::uint8_t* const point = before.data.data() +
                                      i / before.width * before.row_step +
                                      i % before.width * before.point_step;
          std::vector<std::uint8_t> bytes(point, point + before.point_step);
          for (const std::uint32_t offset : {4u, 4 + 2 * size, 4 + 3 * size})
            if (is_noise[i])
              writeNumber(bytes.data() + offset,
                          datatype,
                          std::numeric_limits<double>::quiet_NaN());
          if (is_organised || !is_noise[i])
            expected.insert(expected.end(), bytes.begin(), bytes.end());
          if (is_organised && i % scan.width + 1 == scan.width)
            expected.insert(expected.end(),
                            point + before.point_step,
                            point + before.point_step + padding);
        }
        PCLPointCloud2 cloud = before;
        PointOutlierRemoval removal;
        const OutlierRemovalStatus status = removeOutliers(cloud, removal);
        EXPECT_TRUE(status.ok()) << status.message();
        EXPECT_EQ(status.removed, count);
        expectSameDescription(cloud, before);
        EXPECT_EQ(cloud.width, is_organised ? scan.width : scan.size() - count);
        EXPECT_EQ(cloud.height, before.height);
        EXPECT_EQ(cloud.row_step, is_organised ? before.row_step : expected.size());
        EXPECT_EQ(cloud.is_dense, is_organised ? 0 : before.is_dense);
        EXPECT_EQ(cloud.data, expected);
      }
}

TEST(CloudOutlierRemoval, CoordinatesOfSeveralTypesBecomeReal)
{
  const LidarScan scan = snowyScan();
  const std::vector<bool> is_noise = noiseOf(scan);
  PCLPointCloud2 before = messageOf(scan, PCLPointField::FLOAT64, true, 13);
  fieldOf(before, "y").datatype = PCLPointField::FLOAT32;
  const auto placeOf = [&](const PCLPointCloud2& cloud, std::size_t i) {
    return i / scan.width * cloud.row_step + i % scan.width * cloud.point_step;
  };
  for (std::size_t i = 0; i < scan.size(); ++i)
    std::memcpy(&before.data[placeOf(before, i) + fieldOf(before, "y").offset],
                &scan.coordinates[3 * i + 1],
                sizeof(float));
  PCLPointCloud2 cloud = before;
  PointOutlierRemoval removal;
  const OutlierRemovalStatus status = removeOutliers(cloud, removal);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(status.removed, std::count(is_noise.begin(), is_noise.end(), true));
  ASSERT_EQ(cloud.data.size(), scan.size() * (before.point_step + 24));
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::uint8_t* const point = &cloud.data[placeOf(cloud, i)];
    ASSERT_EQ(std::memcmp(point, &before.data[placeOf(before, i)], before.point_step),
              0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const PCLPointField& field = fieldOf(cloud, std::string(1, "xyz"[axis]));
      ASSERT_EQ(field.datatype, PCLPointField::FLOAT64);
      double number = 0.0;
      std::memcpy(&number, point + field.offset, sizeof(number));
      const auto original = static_cast<double>(scan.coordinates[3 * i + axis]);
      ASSERT_EQ(std::isnan(number), is_noise[i] || std::isnan(original));
      ASSERT_TRUE(std::isnan(number) || number == original);
    }
  }
}

TEST(CloudOutlierRemoval, CloudsThatCannotBeJudgedAreNotChanged)
{
  const LidarScan scan = snowyScan();
  const auto expectRefused = [](const PCLPointCloud2& before,
                                OutlierRemovalCode code,
                                const std::string& text) {
    PCLPointCloud2 cloud = before;
    cloud.data.shrink_to_fit(); // so that a sanitizer sees the first byte too many
    PointOutlierRemoval removal;
    const OutlierRemovalStatus status = removeOutliers(cloud, removal);
    EXPECT_EQ(status.code(), code) << text;
    EXPECT_NE(status.message().find(text), std::string::npos) << status.message();
    EXPECT_EQ(status.removed, 0u);
    EXPECT_EQ(cloud.data, before.data);
    EXPECT_EQ(cloud.width, before.width);
    EXPECT_EQ(cloud.height, before.height);
    EXPECT_EQ(cloud.is_dense, before.is_dense);
  };
  const PCLPointCloud2 valid = messageOf(scan, PCLPointField::FLOAT32, true, 0);
  PCLPointCloud2 cloud = valid;
  fieldOf(cloud, "y").name = "Y";
  expectRefused(cloud, OutlierRemovalCode::InvalidCloud, "no field 'y'");
  cloud = valid;
  fieldOf(cloud, "z").datatype = detail::bool_datatype;
  expectRefused(cloud, OutlierRemovalCode::InvalidCloud, "field 'z'");
  cloud = valid;
  cloud.data.pop_back();
  expectRefused(cloud, OutlierRemovalCode::InvalidCloud, "invalid layout");
  cloud = valid;
  cloud.data.push_back(0); // else row_step is not used
  --cloud.row_step;
  expectRefused(cloud, OutlierRemovalCode::InvalidCloud, "invalid layout");
  cloud = valid;
  cloud.width = 4294967295u;
  expectRefused(cloud, OutlierRemovalCode::InvalidCloud, "invalid layout");
  cloud = valid;
  cloud.width = 0;
  cloud.data.clear();
  expectRefused(cloud, OutlierRemovalCode::NoImage, "no point was judged");
  // A field ring that is not within the points is none.
  cloud = messageOf(scan, PCLPointField::FLOAT32, false, 0);
  cloud.width = 100;
  fieldOf(cloud, "ring").offset = cloud.point_step - 1;
  expectRefused(cloud, OutlierRemovalCode::NoImage, "no point was judged");
}

TEST(CloudOutlierRemoval, TypedCloudsKeepTheirPose)
{
  const LidarScan scan = snowyScan();
  const std::vector<bool> is_noise = noiseOf(scan);
  for (const bool is_organised : {true, false}) {
    pcl::PointCloud<pcl::PointXYZI> cloud;
    for (std::size_t i = 0; i < scan.size(); ++i)
      cloud.push_back({scan.coordinates[3 * i],
                       scan.coordinates[3 * i + 1],
                       scan.coordinates[3 * i + 2],
                       static_cast<float>(i)});
    if (is_organised) {
      cloud.width = scan.width;
      cloud.height = scan.height;
    }
    cloud.header.frame_id = "lidar";
    cloud.header.stamp = 1234;
    cloud.sensor_origin_ = {1.0f, 2.0f, 3.0f, 0.0f};
    cloud.sensor_orientation_ = Eigen::Quaternionf(0.0f, 1.0f, 0.0f, 0.0f);
    PointOutlierRemoval removal;
    const OutlierRemovalStatus status = removeOutliers(cloud, removal);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(cloud.header.frame_id, "lidar");
    EXPECT_EQ(cloud.header.stamp, 1234u);
    EXPECT_EQ(cloud.sensor_origin_, Eigen::Vector4f(1.0f, 2.0f, 3.0f, 0.0f));
    EXPECT_EQ(cloud.sensor_orientation_.x(), 1.0f);
    EXPECT_EQ(cloud.height, is_organised ? scan.height : 1u);
    EXPECT_EQ(std::size_t{cloud.width} * cloud.height, cloud.size());
    std::size_t at = 0;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (is_noise[i] && !is_organised)
        continue;
      ASSERT_LT(at, cloud.size());
      EXPECT_EQ(cloud[at].intensity, static_cast<float>(i));
      EXPECT_EQ(std::isnan(cloud[at].x), is_noise[i] || scan.ranges[i] == 0.0f);
      ++at;
    }
    EXPECT_EQ(at, cloud.size());
  }
}

TEST(CloudOutlierRemoval, NothingIsLeftWhereAllIsNoise)
{
  LidarScan scan = snowyScan();
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (std::size_t i = 0; i < scan.size(); ++i)
    if (scan.ranges[i] > 0.0f)
      cloud.push_back({scan.coordinates[3 * i],
                       scan.coordinates[3 * i + 1],
                       scan.coordinates[3 * i + 2]});
  const std::size_t count = cloud.size();
  PointOutlierRemovalSettings settings;
  settings.min_log_odds = 1000.0f;
  PointOutlierRemoval removal(settings);
  const OutlierRemovalStatus status = removeOutliers(cloud, removal);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(status.removed, count);
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(removeOutliers(cloud, removal).code(), OutlierRemovalCode::NoImage);
}

TEST(LidarClouds, AreKnownByTheirRows)
{
  for (const bool is_organised : {true, false})
    EXPECT_TRUE(
        isOfLidar(messageOf(snowyScan(), PCLPointField::FLOAT32, is_organised, 0)));
  // A camera that looks along z at a wall and a floor.
  pcl::PointCloud<pcl::PointXYZ> image(80, 60);
  for (std::size_t i = 0; i < image.size(); ++i) {
    const float right = (static_cast<float>(i % 80) - 39.5f) / 80.0f;
    const float down = (static_cast<float>(i / 80) - 29.5f) / 80.0f;
    const float depth = down > 0.1f ? std::min(3.0f, 0.5f / down) : 3.0f;
    image[i] = {right * depth, down * depth, depth};
  }
  for (const std::uint32_t height : {60u, 1u}) {
    PCLPointCloud2 message;
    pcl::toPCLPointCloud2(image, message);
    message.width = 80 * 60 / height;
    message.height = height;
    message.row_step = message.width * message.point_step;
    EXPECT_FALSE(isOfLidar(message));
  }
  PCLPointCloud2 large = messageOf(snowyScan(), PCLPointField::FLOAT32, false, 0);
  large.width = (1u << 20) + 1;
  large.row_step = large.width * large.point_step;
  large.data.resize(large.row_step);
  EXPECT_FALSE(isOfLidar(large));
  EXPECT_FALSE(isOfLidar(PCLPointCloud2()));
}

} // namespace
