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

DriverPoint
pointOf(const PointCloudMessage& cloud, std::uint32_t row, std::uint32_t column)
{
  DriverPoint point{};
  std::memcpy(&point,
              &cloud.bytes[row * cloud.row_step + column * sizeof(point)],
              sizeof(point));
  return point;
}

class ProgramLayouts : public ProgramTest {
protected:
  /** \brief Encodes a bag, which tells what is left out. */
  void
  encode(const std::vector<PointCloudMessage>& clouds, const std::string& options)
  {
    writeCloudBag(folder / "bag.mcap", clouds);
    EXPECT_EQ(
        run("encode bag.mcap -o small.mcap -r 0.01 --overwrite " + options).status, 0);
  }

  std::vector<PointCloudMessage>
  decode(const std::string& options = "")
  {
    expectRun("decode small.mcap -o again.mcap --overwrite " + options);
    return cloudsOf(folder / "again.mcap");
  }
};

} // namespace

TEST_F(ProgramLayouts, PointsCanBeReadAsTheStructuresThatTheyWere)
{
  encode({driverMessage()}, "--keep-order --fields all");
  const PointCloudMessage cloud = decode().at(0);
  expectFields(cloud.fields, driver_fields);
  ASSERT_EQ(cloud.point_step, sizeof(DriverPoint));
  ASSERT_EQ(cloud.row_step, columns * sizeof(DriverPoint) + row_padding);
  ASSERT_EQ(cloud.height, rows);
  ASSERT_EQ(cloud.width, columns);
  ASSERT_EQ(cloud.bytes.size(), std::size_t{rows} * cloud.row_step);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const DriverPoint original = driverPoint(row, column);
      DriverPoint point = pointOf(cloud, row, column);
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
  const PointCloudMessage packed = decode("--packed").at(0);
  EXPECT_EQ(packed.point_step, 4 * sizeof(float) + 4 + 2 + 1 + 4);
  EXPECT_EQ(packed.row_step, columns * packed.point_step);
  EXPECT_EQ(packed.bytes.size(), std::size_t{rows} * packed.row_step);
  expectFailure("decode small.mcap -o clouds --packed", 2, "--packed is for a bag");
}

TEST_F(ProgramLayouts, MayChangeWithinATopicAndAreThoseOfEmptyClouds)
{
  PointCloudMessage empty = driverMessage();
  empty.height = 1;
  empty.width = empty.row_step = 0;
  empty.bytes.clear();
  PointCloudMessage other; // coordinates in doubles, and whole intensities before them
  other.height = 1;
  other.width = 100;
  other.fields = {{"intensity", 0, pcl::PCLPointField::UINT8, 1},
                  {"x", 8, pcl::PCLPointField::FLOAT64, 1},
                  {"y", 16, pcl::PCLPointField::FLOAT64, 1},
                  {"z", 24, pcl::PCLPointField::FLOAT64, 1}};
  other.point_step = 32;
  other.row_step = 32 * other.width;
  other.bytes.assign(other.row_step, 0);
  for (std::uint32_t i = 0; i < other.width; ++i) {
    const double position[3] = {0.03 * i, 1.0, 2.0};
    other.bytes[32 * i] = static_cast<std::uint8_t>(2 * i);
    std::memcpy(&other.bytes[32 * i + 8], position, sizeof(position));
  }
  std::vector<PointCloudMessage> clouds = {
      empty, driverMessage(), driverMessage(), other, other};
  for (std::size_t i = 0; i < clouds.size(); ++i)
    clouds[i].stamp = std::chrono::seconds(1 + i);
  encode(clouds, "--keep-order");
  std::vector<PointCloudMessage> decoded = decode();
  ASSERT_EQ(decoded.size(), 5u);
  // A part has them, too.
  expectRun("cut small.mcap -o part.mcap --frames 4:5");
  expectRun("decode part.mcap -o again.mcap --overwrite");
  decoded.push_back(cloudsOf(folder / "again.mcap").back());
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    SCOPED_TRACE(i);
    const PointCloudMessage& cloud = decoded[i];
    if (i < 3) {
      EXPECT_EQ(cloud.point_step, sizeof(DriverPoint));
      expectFields(cloud.fields, {driver_fields.begin(), driver_fields.begin() + 4});
      continue;
    }
    expectFields(cloud.fields, other.fields);
    ASSERT_EQ(cloud.bytes.size(), other.bytes.size());
    for (std::uint32_t point = 0; point < cloud.width; ++point) {
      double position[3];
      std::memcpy(position, &cloud.bytes[32 * point + 8], sizeof(position));
      EXPECT_EQ(cloud.bytes[32 * point], 2 * point);
      EXPECT_NEAR(position[0], 0.03 * point, 0.0051);
      EXPECT_NEAR(position[1], 1.0, 0.0051);
    }
  }
  EXPECT_NEAR(pointOf(decoded[2], 1, 1).x, driverPoint(1, 1).x, 0.0051f);
}

TEST_F(ProgramLayouts, PointsAreSortedByTimeOrArrangedByRing)
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
  encode({message}, "--keep-points --fields t,ring");
  const PointCloudMessage sorted = decode("--sort-by-time").at(0);
  ASSERT_EQ(sorted.height, 1u);
  ASSERT_EQ(sorted.width, rows * columns);
  for (std::uint32_t i = 0; i < sorted.width; ++i) { // by columns, and in these by rows
    EXPECT_EQ(pointOf(sorted, 0, i).t, 1000 * (i / rows));
    EXPECT_EQ(pointOf(sorted, 0, i).ring, i % rows);
  }
  const PointCloudMessage arranged = decode("--arrange-by-ring").at(0);
  ASSERT_EQ(arranged.height, rows);
  ASSERT_EQ(arranged.width, columns);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      EXPECT_EQ(pointOf(arranged, row, column).ring, row);
      EXPECT_EQ(pointOf(arranged, row, column).t, 1000 * column);
    }
  expectFailure("decode small.mcap -o clouds --sort-by-time --arrange-by-ring",
                2,
                "--sort-by-time excludes --arrange-by-ring");
  encode({message}, "");
  expectFailure(
      "decode small.mcap -o again.mcap --overwrite --sort-by-time",
      1,
      "/points/pcl_ext, frame 0: its points stay in the order of the frame: the "
      "cloud has no field 't', ");
}

TEST_F(ProgramLayouts, NumbersThatTheirTypesCannotHoldAreTold)
{
  PointCloudMessage message;
  message.height = 1;
  message.width = 6;
  message.fields = {{"x", 0, pcl::PCLPointField::FLOAT32, 1},
                    {"y", 4, pcl::PCLPointField::FLOAT32, 1},
                    {"z", 8, pcl::PCLPointField::FLOAT32, 1},
                    {"intensity", 12, pcl::PCLPointField::UINT8, 1}};
  message.point_step = 13;
  message.row_step = 13 * message.width;
  for (std::uint32_t i = 0; i < message.width; ++i) {
    // Voxels of three, two and one.
    const float position[3] = {i < 3 ? 0.5f : i < 5 ? 1.5f : 2.5f, 0.5f, 0.5f};
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(position);
    message.bytes.insert(message.bytes.end(), bytes, bytes + sizeof(position));
    message.bytes.push_back(200);
  }
  writeCloudBag(folder / "bag.mcap", {message});
  expectRun("encode -q bag.mcap -o small.mcap -r 1 --aggregation sum");
  expectRemark("decode small.mcap -o again.mcap",
               ": 2 numbers (intensities or fields) outside of the types that the "
               "messages had are limited to these; --packed keeps them");
  expectRun("decode small.mcap -o packed.mcap --packed");
}

TEST_F(ProgramLayouts, CoordinatesThatNeedDoublesAreNotNarrowed)
{
  encode({driverMessage()}, "--pose=600000,5200000,0,0,0,0,1");
  expectRemark("decode small.mcap -o again.mcap", "as coordinates need FLOAT64 now");
  const PointCloudMessage cloud = cloudsOf(folder / "again.mcap").at(0);
  ASSERT_EQ(cloud.fields[0].datatype, pcl::PCLPointField::FLOAT64);
  double x = 0.0;
  std::memcpy(&x, cloud.bytes.data(), sizeof(x));
  EXPECT_NEAR(x, 600000.0, 10.0);
}

} // namespace pcl_ext::tools::test
