// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/point_cloud_messages.h"
#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

namespace pcl_ext::tools::test {

namespace {

using recording::PointCloudMessage;
using recording::PointFieldMessage;

constexpr std::uint32_t rows = 4;
constexpr std::uint32_t columns = 50;
constexpr std::uint32_t row_padding = 24;

/** \brief What a driver's program casts a point to: with gaps, and behind them more. */
struct DriverPoint {
  float x, y, z;
  float unused = 0.0f;
  float intensity;
  std::uint32_t t;
  std::uint16_t reflectivity;
  std::uint8_t ring;
  std::uint8_t gap = 0;
  std::uint32_t range;
  std::array<std::uint8_t, 16> rest{};
};
static_assert(sizeof(DriverPoint) == 48);

DriverPoint
driverPoint(std::uint32_t row, std::uint32_t column)
{
  DriverPoint point{};
  const float angle = 0.02f * static_cast<float>(column);
  point.x = 5.0f * std::cos(angle);
  point.y = 5.0f * std::sin(angle);
  point.z = 0.2f * static_cast<float>(row);
  point.intensity = static_cast<float>(column % 7);
  point.t = 1000 * column + row;
  point.reflectivity = static_cast<std::uint16_t>(300 + column);
  point.ring = static_cast<std::uint8_t>(row);
  point.range = 70000 + column;
  return point;
}

const std::vector<PointFieldMessage> driver_fields = {
    {"x", 0, pcl::PCLPointField::FLOAT32, 1},
    {"y", 4, pcl::PCLPointField::FLOAT32, 1},
    {"z", 8, pcl::PCLPointField::FLOAT32, 1},
    {"intensity", 16, pcl::PCLPointField::FLOAT32, 1},
    {"t", 20, pcl::PCLPointField::UINT32, 1},
    {"reflectivity", 24, pcl::PCLPointField::UINT16, 1},
    {"ring", 26, pcl::PCLPointField::UINT8, 1},
    {"range", 28, pcl::PCLPointField::UINT32, 1}};

PointCloudMessage
driverMessage()
{
  PointCloudMessage message;
  message.frame_id = "lidar";
  message.stamp = recording::Time(1'000'000'000);
  message.height = rows;
  message.width = columns;
  message.fields = driver_fields;
  message.point_step = sizeof(DriverPoint);
  message.row_step = columns * message.point_step + row_padding;
  message.bytes.assign(std::size_t{rows} * message.row_step, 0);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const DriverPoint point = driverPoint(row, column);
      std::memcpy(&message.bytes[row * message.row_step + column * sizeof(point)],
                  &point,
                  sizeof(point));
    }
  message.is_dense = true;
  return message;
}

void
writeCloudBag(const std::string& path, const std::vector<PointCloudMessage>& clouds)
{
  std::vector<recording::McapMessage> messages;
  for (const PointCloudMessage& cloud : clouds) {
    recording::McapMessage& message = messages.emplace_back();
    message.log_time = message.publish_time = cloud.stamp;
    recording::writePointCloud(cloud, false, message.bytes);
  }
  writeMcap(path, {recording::pointCloudChannel("/points")}, messages);
}

void
writeCloudBag(const std::string& path, const PointCloudMessage& cloud)
{
  writeCloudBag(path, std::vector<PointCloudMessage>{cloud});
}

PointCloudMessage
readCloud(const std::string& path, std::size_t number, std::size_t count)
{
  const std::vector<PointCloudMessage> clouds = cloudsOf(path);
  EXPECT_EQ(clouds.size(), count);
  return clouds.at(number);
}

PointCloudMessage
readOnlyCloud(const std::string& path)
{
  return readCloud(path, 0, 1);
}

void
expectFields(const std::vector<PointFieldMessage>& fields,
             const std::vector<PointFieldMessage>& expected)
{
  ASSERT_EQ(fields.size(), expected.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    EXPECT_EQ(fields[i].name, expected[i].name);
    EXPECT_EQ(fields[i].offset, expected[i].offset) << fields[i].name;
    EXPECT_EQ(fields[i].datatype, expected[i].datatype) << fields[i].name;
    EXPECT_EQ(fields[i].count, expected[i].count) << fields[i].name;
  }
}

class ProgramLayouts : public ProgramTest {
protected:
  PointCloudMessage
  encodeAndDecode(const std::string& encode_options, const std::string& decode_options)
  {
    // It tells what is left out.
    EXPECT_EQ(run("encode bag.mcap -o small.mcap -r 0.01 --overwrite " + encode_options)
                  .status,
              0);
    expectRun("decode small.mcap -o again.mcap --overwrite " + decode_options);
    return readOnlyCloud(folder / "again.mcap");
  }
};

} // namespace

TEST_F(ProgramLayouts, PointsCanBeReadAsTheStructuresThatTheyWere)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  const PointCloudMessage cloud = encodeAndDecode("--keep-order --fields all", "");
  expectFields(cloud.fields, driver_fields);
  ASSERT_EQ(cloud.point_step, sizeof(DriverPoint));
  ASSERT_EQ(cloud.row_step, columns * sizeof(DriverPoint) + row_padding);
  ASSERT_EQ(cloud.height, rows);
  ASSERT_EQ(cloud.width, columns);
  ASSERT_EQ(cloud.bytes.size(), std::size_t{rows} * cloud.row_step);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const DriverPoint original = driverPoint(row, column);
      DriverPoint point{};
      std::memcpy(&point,
                  &cloud.bytes[row * cloud.row_step + column * sizeof(point)],
                  sizeof(point));
      EXPECT_NEAR(point.x, original.x, 0.0051f);
      EXPECT_NEAR(point.y, original.y, 0.0051f);
      EXPECT_NEAR(point.z, original.z, 0.0051f);
      // All else is the same, byte for byte.
      point.x = original.x;
      point.y = original.y;
      point.z = original.z;
      ASSERT_EQ(std::memcmp(&point, &original, sizeof(point)), 0)
          << row << " " << column;
    }
}

TEST_F(ProgramLayouts, MayChangeWithinATopic)
{
  // The same points, with fewer fields in another order, and without gaps.
  std::vector<PointCloudMessage> clouds(4, driverMessage());
  for (std::uint32_t i = 0; i < 4; ++i)
    clouds[i].stamp += std::chrono::seconds(i);
  for (std::uint32_t i = 2; i < 4; ++i) {
    PointCloudMessage& cloud = clouds[i];
    cloud.fields = {{"z", 0, pcl::PCLPointField::FLOAT32, 1},
                    {"x", 4, pcl::PCLPointField::FLOAT32, 1},
                    {"y", 8, pcl::PCLPointField::FLOAT32, 1},
                    {"intensity", 12, pcl::PCLPointField::FLOAT32, 1}};
    cloud.point_step = 16;
    cloud.row_step = 16 * columns;
    cloud.bytes.clear();
    for (std::uint32_t point = 0; point < rows * columns; ++point) {
      const DriverPoint driver = driverPoint(point / columns, point % columns);
      for (const float number : {driver.z, driver.x, driver.y, driver.intensity}) {
        std::array<std::uint8_t, sizeof(number)> bytes{};
        std::memcpy(bytes.data(), &number, sizeof(number));
        cloud.bytes.insert(cloud.bytes.end(), bytes.begin(), bytes.end());
      }
    }
  }
  writeCloudBag(folder / "bag.mcap", clouds);
  EXPECT_EQ(run("encode bag.mcap -o small.mcap -r 0.01 --keep-order").status, 0);
  expectRun("decode small.mcap -o again.mcap");
  expectRun("cut small.mcap -o part.mcap --frames 3:4");
  expectRun("decode part.mcap -o part_again.mcap --frames 1:2");
  for (std::uint32_t i = 0; i < 5; ++i) {
    const PointCloudMessage cloud = i < 4 ? readCloud(folder / "again.mcap", i, 4)
                                          : readOnlyCloud(folder / "part_again.mcap");
    const bool is_driver = i < 2;
    EXPECT_EQ(cloud.point_step, is_driver ? sizeof(DriverPoint) : 16u);
    ASSERT_EQ(cloud.row_step,
              columns * cloud.point_step + (is_driver ? row_padding : 0u));
    EXPECT_EQ(cloud.fields[0].name, is_driver ? "x" : "z");
    for (std::uint32_t point = 0; point < rows * columns; ++point) {
      float x = 0.0f;
      std::memcpy(
          &x,
          &cloud.bytes[point / columns * cloud.row_step +
                       point % columns * cloud.point_step + (is_driver ? 0 : 4)],
          sizeof(x));
      ASSERT_NEAR(x, driverPoint(point / columns, point % columns).x, 0.0051f);
    }
  }
}

TEST_F(ProgramLayouts, EmptyCloudsHaveThatOfTheirFields)
{
  std::vector<PointCloudMessage> clouds(3, driverMessage());
  for (std::uint32_t i = 0; i < 3; ++i)
    clouds[i].stamp += std::chrono::seconds(i);
  for (const std::size_t i : {0u, 2u}) {
    clouds[i].height = 1;
    clouds[i].width = clouds[i].row_step = 0;
    clouds[i].bytes.clear();
  }
  writeCloudBag(folder / "bag.mcap", clouds);
  EXPECT_EQ(run("encode bag.mcap -o small.mcap -r 0.01").status, 0);
  expectRun("decode small.mcap -o again.mcap");
  for (std::uint32_t i = 0; i < 3; ++i) {
    const PointCloudMessage cloud = readCloud(folder / "again.mcap", i, 3);
    EXPECT_EQ(cloud.point_step, sizeof(DriverPoint)) << i;
    expectFields(cloud.fields, {driver_fields.begin(), driver_fields.begin() + 4});
  }
}

TEST_F(ProgramLayouts, PackedPointsHaveNoPadding)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  const PointCloudMessage cloud =
      encodeAndDecode("--keep-order --fields all", "--packed");
  EXPECT_EQ(cloud.point_step, 4 * sizeof(float) + 4 + 2 + 1 + 4);
  EXPECT_EQ(cloud.row_step, columns * cloud.point_step);
  EXPECT_EQ(cloud.bytes.size(), std::size_t{rows} * cloud.row_step);
  expectFailure("decode small.mcap -o clouds --packed", 2, "--packed is for a bag");
}

TEST_F(ProgramLayouts, PointsAreSortedByTimeOrArrangedByRing)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  const std::string kept = "--keep-points --fields t,ring";
  const PointCloudMessage sorted = encodeAndDecode(kept, "--sort-by-time --packed");
  ASSERT_EQ(sorted.height, 1u);
  ASSERT_EQ(sorted.width, rows * columns);
  const std::size_t time_offset = 4 * sizeof(float);
  for (std::uint32_t i = 0; i < sorted.width; ++i) {
    std::uint32_t time = 0;
    std::memcpy(
        &time, &sorted.bytes[i * sorted.point_step + time_offset], sizeof(time));
    // By columns, and in these by rows.
    EXPECT_EQ(time, 1000 * (i / rows) + i % rows);
  }
  expectFailure("decode small.mcap -o clouds --sort-by-time --arrange-by-ring",
                2,
                "--sort-by-time excludes --arrange-by-ring");
}

TEST_F(ProgramLayouts, RowsAreThoseOfTheRings)
{
  PointCloudMessage message = driverMessage();
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t time = 1000 * column; // the same for a column
      std::memcpy(
          &message.bytes[row * message.row_step + column * sizeof(DriverPoint) + 20],
          &time,
          sizeof(time));
    }
  writeCloudBag(folder / "bag.mcap", message);
  const PointCloudMessage cloud =
      encodeAndDecode("--keep-points --fields t,ring", "--arrange-by-ring");
  ASSERT_EQ(cloud.height, rows);
  ASSERT_EQ(cloud.width, columns);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      DriverPoint point{};
      std::memcpy(&point,
                  &cloud.bytes[row * cloud.row_step + column * sizeof(point)],
                  sizeof(point));
      EXPECT_EQ(point.ring, row);
      EXPECT_EQ(point.t, 1000 * column);
    }
}

TEST_F(ProgramLayouts, CoordinatesThatNeedDoublesAreNotNarrowed)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  EXPECT_EQ(run("encode bag.mcap -o small.mcap -r 0.01 --pose=600000,5200000,0,0,0,0,1")
                .status,
            0);
  const ProgramRun decoded = run("decode small.mcap -o again.mcap");
  EXPECT_EQ(decoded.status, 0);
  EXPECT_TRUE(hasPart(decoded.errors, "as coordinates need FLOAT64 now"));
  const PointCloudMessage cloud = readOnlyCloud(folder / "again.mcap");
  ASSERT_EQ(cloud.fields[0].datatype, pcl::PCLPointField::FLOAT64);
  double x = 0.0;
  std::memcpy(&x, cloud.bytes.data(), sizeof(x));
  EXPECT_NEAR(x, 600000.0, 10.0);
}
TEST_F(ProgramLayouts, CloudsWithoutATimeAreNotSorted)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  EXPECT_EQ(run("encode bag.mcap -o small.mcap -r 0.01").status, 0);
  expectFailure(
      "decode small.mcap -o again.mcap --sort-by-time",
      1,
      "/points/pcl_ext, frame 0: its points stay in the order of the frame: the "
      "cloud has no field 't', ");
}

TEST_F(ProgramLayouts, CoordinatesStayDoublesAndIntensitiesWholeNumbers)
{
  PointCloudMessage message;
  message.stamp = recording::Time(1'000'000'000);
  message.height = 1;
  message.width = 100;
  message.fields = {{"intensity", 0, pcl::PCLPointField::UINT8, 1},
                    {"x", 8, pcl::PCLPointField::FLOAT64, 1},
                    {"y", 16, pcl::PCLPointField::FLOAT64, 1},
                    {"z", 24, pcl::PCLPointField::FLOAT64, 1}};
  message.point_step = 32;
  message.row_step = 32 * message.width;
  message.bytes.assign(message.row_step, 0);
  for (std::uint32_t i = 0; i < message.width; ++i) {
    const double position[3] = {0.03 * i, 1.0, 2.0};
    message.bytes[32 * i] = static_cast<std::uint8_t>(2 * i);
    std::memcpy(&message.bytes[32 * i + 8], position, sizeof(position));
  }
  writeCloudBag(folder / "bag.mcap", message);
  const PointCloudMessage cloud = encodeAndDecode("--keep-order", "");
  expectFields(cloud.fields, message.fields);
  ASSERT_EQ(cloud.bytes.size(), message.bytes.size());
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    double position[3];
    std::memcpy(position, &cloud.bytes[32 * i + 8], sizeof(position));
    EXPECT_EQ(cloud.bytes[32 * i], 2 * i);
    EXPECT_NEAR(position[0], 0.03 * i, 0.0051);
    EXPECT_NEAR(position[1], 1.0, 0.0051);
  }
}

} // namespace pcl_ext::tools::test
