// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Messages of a bag have the layout again that they had before they were encoded,
 * so that programs can read them as structures.
 */
#include "inputs/message_layout.h"
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

namespace pcl_ext {
namespace tools {
namespace test {

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
writeCloudBag(const std::string& path, const PointCloudMessage& cloud)
{
  recording::McapMessage message;
  message.log_time = message.publish_time = cloud.stamp;
  recording::writePointCloud(cloud, false, message.bytes);
  writeMcap(path, {recording::pointCloudChannel("/points")}, {message});
}

PointCloudMessage
readOnlyCloud(const std::string& path)
{
  const std::vector<PointCloudMessage> clouds = cloudsOf(path);
  EXPECT_EQ(clouds.size(), 1u);
  return clouds.at(0);
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

TEST_F(ProgramLayouts, FieldsThatWereLeftOutAreNotListed)
{
  writeCloudBag(folder / "bag.mcap", driverMessage());
  const PointCloudMessage cloud = encodeAndDecode("--keep-order --fields ring", "");
  expectFields(cloud.fields,
               {driver_fields[0],
                driver_fields[1],
                driver_fields[2],
                driver_fields[3],
                driver_fields[6]});
  EXPECT_EQ(cloud.point_step, sizeof(DriverPoint));
  DriverPoint point{};
  std::memcpy(&point, &cloud.bytes[cloud.row_step], sizeof(point));
  EXPECT_EQ(point.ring, 1u);
  EXPECT_EQ(point.t, 0u);
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
  EXPECT_NE(decoded.errors.find("as coordinates need FLOAT64 now"), std::string::npos)
      << decoded.errors;
  const PointCloudMessage cloud = readOnlyCloud(folder / "again.mcap");
  ASSERT_EQ(cloud.fields[0].datatype, pcl::PCLPointField::FLOAT64);
  double x = 0.0;
  std::memcpy(&x, cloud.bytes.data(), sizeof(x));
  EXPECT_NEAR(x, 600000.0, 10.0);
}

TEST_F(ProgramLayouts, WhatTheOrderTakesIsTold)
{
  // Points of no rays, shuffled.
  PointCloudMessage message = driverMessage();
  message.height = 1;
  message.width = rows * columns;
  message.row_step = message.width * message.point_step;
  message.bytes.resize(message.row_step);
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < message.width; ++i) {
    DriverPoint point{};
    for (float* coordinate : {&point.x, &point.y, &point.z})
      *coordinate = static_cast<float>(random() % 100000) * 1e-4f;
    std::memcpy(&message.bytes[i * sizeof(point)], &point, sizeof(point));
  }
  writeCloudBag(folder / "bag.mcap", message);
  const auto sizeOf = [&](const std::string& options) {
    EXPECT_EQ(run("encode bag.mcap -o x.pcxi --overwrite -r 0.01 " + options).status,
              0);
    return std::filesystem::file_size(folder / "x.pcxi");
  };
  const auto unordered = sizeOf("--keep-points");
  const auto ordered = sizeOf("--keep-order");
  const std::string errors =
      run("encode bag.mcap -o x.pcxi --overwrite -r 0.01 --keep-order").errors;
  const std::string expected = "the order of the points takes " +
                               std::to_string(ordered - unordered) + " bytes of ";
  EXPECT_NE(errors.find(expected), std::string::npos) << errors << expected;
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

TEST(MessageLayouts, OfAColourAndOfAnAdditionalField)
{
  pcl::PCLPointCloud2 original;
  original.point_step = 20;
  original.width = 1;
  original.row_step = 20;
  for (const char* name : {"x", "y", "z", "rgba"}) {
    original.fields.emplace_back();
    original.fields.back().name = name;
    original.fields.back().offset =
        static_cast<std::uint32_t>(4 * (original.fields.size() - 1));
    original.fields.back().datatype = pcl::PCLPointField::FLOAT32;
    original.fields.back().count = 1;
  }
  original.fields[3].offset = 16;
  original.fields[3].datatype = pcl::PCLPointField::UINT32;
  StreamMetadata metadata;
  addLayout(original, metadata);

  PointCloudMessage message;
  message.width = message.height = 1;
  message.fields = {{"x", 0, pcl::PCLPointField::FLOAT32, 1},
                    {"y", 4, pcl::PCLPointField::FLOAT32, 1},
                    {"z", 8, pcl::PCLPointField::FLOAT32, 1},
                    {"intensity", 12, pcl::PCLPointField::FLOAT32, 1},
                    {"rgb", 16, pcl::PCLPointField::FLOAT32, 1}};
  message.point_step = message.row_step = 20;
  for (std::uint8_t i = 0; i < 20; ++i)
    message.bytes.push_back(i);
  arrange(layoutOf(metadata), message);
  expectFields(message.fields,
               {{"x", 0, pcl::PCLPointField::FLOAT32, 1},
                {"y", 4, pcl::PCLPointField::FLOAT32, 1},
                {"z", 8, pcl::PCLPointField::FLOAT32, 1},
                {"rgba", 16, pcl::PCLPointField::UINT32, 1},
                {"intensity", 20, pcl::PCLPointField::FLOAT32, 1}});
  const std::vector<std::uint8_t> expected = {
      0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 0, 0, 0, 16, 17, 18, 19, 12, 13, 14, 15};
  EXPECT_EQ(message.bytes, expected);
}

TEST(MessageLayouts, ThatTakeTooMuchMemoryAreNotMade)
{
  MessageLayout layout;
  layout.point_step = 4096;
  PointCloudMessage message;
  message.height = 1;
  message.fields = {{"x", 0, pcl::PCLPointField::FLOAT32, 1}};
  layout.fields = message.fields;
  message.point_step = 4;
  message.width = 1u << 14; // 64 MiB
  message.row_step = 4 * message.width;
  message.bytes.resize(message.row_step);
  PointCloudMessage larger = message;
  larger.width += 1;
  larger.row_step += 4;
  larger.bytes.resize(larger.row_step);
  EXPECT_EQ(arrange(layout, message), "");
  EXPECT_EQ(message.bytes.size(), std::size_t{64} << 20);
  EXPECT_EQ(arrange(layout, larger), "it would take 64 MiB");
  EXPECT_EQ(larger.point_step, 4u);
}

TEST(MessageLayouts, PaddingIsThatOfRows)
{
  pcl::PCLPointCloud2 cloud;
  cloud.point_step = 16;
  cloud.width = 10;
  cloud.height = 1;
  cloud.row_step = 1000; // of a single row: no padding
  cloud.fields.resize(1);
  cloud.fields[0].name = "x";
  cloud.fields[0].datatype = pcl::PCLPointField::FLOAT32;
  cloud.fields[0].count = 0; // as some programs have it
  StreamMetadata metadata;
  ASSERT_TRUE(addLayout(cloud, metadata));
  EXPECT_EQ(layoutOf(metadata).row_padding, 0u);
  ASSERT_EQ(layoutOf(metadata).fields.size(), 1u);
  EXPECT_EQ(layoutOf(metadata).fields[0].count, 1u);
  cloud.height = 2;
  cloud.data.resize(320); // without gaps, whatever row_step says
  ASSERT_TRUE(addLayout(cloud, metadata));
  EXPECT_EQ(layoutOf(metadata).row_padding, 0u);
  cloud.data.resize(2000);
  ASSERT_TRUE(addLayout(cloud, metadata));
  EXPECT_EQ(layoutOf(metadata).row_padding, 840u);
  PointCloudMessage message;
  message.width = message.height = 1;
  message.fields = {{"x", 0, pcl::PCLPointField::FLOAT32, 1}};
  message.point_step = message.row_step = 4;
  message.bytes.resize(4);
  EXPECT_EQ(arrange(layoutOf(metadata), message), "");
  EXPECT_EQ(message.row_step, 16u);
  cloud.point_step = 0; // a message without points
  StreamMetadata none;
  EXPECT_FALSE(addLayout(cloud, none));
  EXPECT_TRUE(none.empty());
}

TEST(MessageLayouts, NumbersOutsideOfATypeAreLimited)
{
  const StreamMetadata metadata = {{layout_metadata,
                                    R"({"point_step":4,"row_padding":0,"fields":[
           {"name":"a","offset":0,"datatype":2,"count":3}]})"}};
  PointCloudMessage message;
  message.width = message.height = 1;
  message.fields = {{"a", 0, pcl::PCLPointField::FLOAT32, 3}};
  message.point_step = message.row_step = 12;
  const float numbers[3] = {-5.0f, 300.0f, std::nanf("")};
  message.bytes.resize(12);
  std::memcpy(message.bytes.data(), numbers, 12);
  arrange(layoutOf(metadata), message);
  EXPECT_EQ(message.bytes, (std::vector<std::uint8_t>{0, 255, 0, 0}));
}

TEST(MessageLayouts, DamagedOnesAreNone)
{
  const auto step_of = [](const std::string& text) {
    return layoutOf({{layout_metadata, text}}).point_step;
  };
  const std::string fields = R"(,"row_padding":0,"fields":[)";
  EXPECT_EQ(step_of(R"({"point_step":8)" + fields + "]}"), 8u);
  EXPECT_EQ(layoutOf({}).point_step, 0u);
  for (const std::string& text :
       {std::string(),
        std::string("{"),
        std::string("[1,2]"),
        R"({"point_step":8})" + std::string(),
        R"({"point_step":5000)" + fields + "]}",
        R"({"point_step":-1)" + fields + "]}",
        R"({"point_step":"8")" + fields + "]}",
        R"({"point_step":1e30)" + fields + "]}",
        R"({"point_step":true)" + fields + "]}",
        R"({"point_step":4294967304)" + fields + "]}",
        R"({"point_step":8)" + fields +
            R"({"name":"x","offset":0,"datatype":263,"count":1}]})",
        R"({"point_step":8,"row_padding":100000,"fields":[]})" + std::string(),
        R"({"point_step":8)" + fields +
            R"({"name":"x","offset":6,"datatype":7,"count":1}]})",
        R"({"point_step":8)" + fields +
            R"({"name":"x","offset":0,"datatype":9,"count":1}]})",
        R"({"point_step":8)" + fields +
            R"({"name":"x","offset":0,"datatype":7,"count":4294967295}]})",
        R"({"point_step":8)" + fields + R"({"name":"x","offset":0,"datatype":7}]})"})
    EXPECT_EQ(step_of(text), 0u) << text;
}

} // namespace test
} // namespace tools
} // namespace pcl_ext
