// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/cloud_messages.h>

#include "support/point_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

struct Message {
  struct Field {
    std::string name;
    std::uint32_t offset = 0;
    std::uint8_t datatype = 0;
    std::uint32_t count = 0;
  };
  struct {
    std::string frame_id;
  } header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<Field> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  std::vector<std::uint8_t> data;
  bool is_dense = false;
  std::string format; // of a compressed one
};

template <typename ValueT>
ValueT
valueAt(const std::vector<std::uint8_t>& data, std::size_t offset)
{
  ValueT value;
  std::memcpy(&value, data.data() + offset, sizeof(value));
  return value;
}

/** \brief Fields by name, offset and type: "x0:7 y4:7 ". */
std::string
fieldsOf(const Message& message)
{
  std::string text;
  for (const Message::Field& field : message.fields)
    text += field.name + std::to_string(field.offset) + ':' +
            std::to_string(field.datatype) + ' ';
  return text;
}

TEST(CloudMessages, OfAnotherFrameOrFormatAreNotForACentralNode)
{
  struct {
    pcl::PCLHeader header;
    std::string format = "pcl_ext/version1";
  } message;
  message.header.frame_id = "/world";
  EXPECT_EQ(faultOfMessage(message, "world"), "");
  message.format = "pcl_ext/published";
  EXPECT_EQ(faultOfMessage(message, "world"), "");
  for (const std::string other : {"draco", ""}) {
    message.format = other;
    EXPECT_EQ(faultOfMessage(message, "world"), "unknown format '" + other + "'");
  }
  message.header.frame_id = "//world";
  EXPECT_EQ(faultOfMessage(message, "world"), "its frame_id is '//world', not 'world'");
  message.header.frame_id = "";
  EXPECT_EQ(faultOfMessage(message, "world"), "its frame_id is '', not 'world'");
}

TEST(CloudMessages, VoxelsBecomePointsAtTheirCentres)
{
  VoxelFrame frame;
  frame.grid.resolution = 0.5;
  frame.grid.depth = 3;
  frame.grid.first_index = {-2, 0, 4};
  frame.keys = {0, 7}; // the first voxel and its diagonal neighbour
  frame.intensities = {3, 200};
  frame.intensity_scale.bits = 8;
  for (const bool has_colours : {false, true}) {
    if (has_colours) {
      frame.colour_bits = 8;
      frame.colours = {{1, 2, 3}, {255, 0, 128}};
    }
    Message message;
    writeVoxels(frame, message);
    const std::uint32_t step = has_colours ? 20 : 16;
    EXPECT_EQ(message.height, 1u);
    EXPECT_EQ(message.width, 2u);
    EXPECT_EQ(message.point_step, step);
    EXPECT_EQ(message.row_step, 2 * step);
    EXPECT_TRUE(message.is_dense);
    EXPECT_FALSE(message.is_bigendian);
    EXPECT_EQ(fieldsOf(message),
              has_colours ? "x0:7 y4:7 z8:7 intensity12:7 rgb16:7 "
                          : "x0:7 y4:7 z8:7 intensity12:7 ");
    for (const Message::Field& field : message.fields)
      EXPECT_EQ(field.count, 1u);
    ASSERT_EQ(message.data.size(), 2 * step);
    EXPECT_EQ(valueAt<float>(message.data, 0), -0.75f);
    EXPECT_EQ(valueAt<float>(message.data, 4), 0.25f);
    EXPECT_EQ(valueAt<float>(message.data, 8), 2.25f);
    EXPECT_EQ(valueAt<float>(message.data, 12), 3.0f);
    EXPECT_EQ(valueAt<float>(message.data, step), -0.25f);
    EXPECT_EQ(valueAt<float>(message.data, step + 12), 200.0f);
    if (has_colours) {
      EXPECT_EQ(valueAt<std::uint32_t>(message.data, 16), 0x010203u);
      EXPECT_EQ(valueAt<std::uint32_t>(message.data, step + 16), 0xff0080u);
    }
  }
}

TEST(CloudMessages, FarVoxelsHaveCoordinatesInDoublePrecision)
{
  VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.origin = {600000.0, 5200000.0, 0.0};
  frame.grid.depth = 3;
  frame.keys = {0, 7};
  frame.intensities = {3, 200};
  frame.colour_bits = 8;
  frame.colours = {{1, 2, 3}, {255, 0, 128}};
  frame.has_point_counts = true;
  frame.point_counts = {2, 1};
  Message message;
  writeVoxels(frame, message);
  EXPECT_EQ(fieldsOf(message), "x0:8 y8:8 z16:8 intensity24:7 rgb28:7 ");
  EXPECT_EQ(message.point_step, 32u);
  ASSERT_EQ(message.data.size(), 96u);
  EXPECT_EQ(message.width, 3u);
  EXPECT_EQ(valueAt<double>(message.data, 32), 600000.02);
  EXPECT_EQ(valueAt<std::uint32_t>(message.data, 60), 0x010203u);
  EXPECT_EQ(valueAt<double>(message.data, 64), 600000.06);
  EXPECT_EQ(valueAt<double>(message.data, 72), 5200000.06);
  EXPECT_EQ(valueAt<float>(message.data, 88), 200.0f);
  EXPECT_EQ(valueAt<std::uint32_t>(message.data, 92), 0xff0080u);
}

TEST(CloudMessages, PointsHaveTheOrderOfTheirSensor)
{
  std::mt19937_64 random(3);
  PointContent content;
  content.intensity_bits = content.colour_bits = 0;
  const VoxelFrame points = frameOfPoints(random, content);
  VoxelFrame with_voxels = points;
  pcl_ext::io::setVoxels(with_voxels);
  Message message;
  writeVoxels(points, message);
  EXPECT_EQ(message.width, 48u);
  EXPECT_EQ(message.height, 32u);
  EXPECT_FALSE(message.is_dense);
  EXPECT_EQ(message.point_step, layoutOf(points).pointStep());
  ASSERT_EQ(message.data.size(), std::size_t{48} * 32 * message.point_step);
  std::size_t next = 0;
  for (std::uint32_t pixel = 0; pixel < 48 * 32; ++pixel) {
    const std::size_t point = pixel * message.point_step;
    const auto x = valueAt<float>(message.data, point);
    const auto index = valueAt<std::uint32_t>(message.data, point + 16);
    if (next == points.pointCount() || points.points.indices[next] != pixel) {
      EXPECT_TRUE(std::isnan(x));
      EXPECT_EQ(index, 0u);
      continue;
    }
    EXPECT_EQ(x, static_cast<float>(points.points.positions[next][0]));
    EXPECT_EQ(index, pixel);
    ++next;
  }
  EXPECT_EQ(next, points.pointCount());
  Message of_voxels;
  writeVoxels(with_voxels, of_voxels);
  EXPECT_EQ(of_voxels.data, message.data);
}

TEST(CloudMessages, PointsHaveTheirOwnIntensitiesAndColours)
{
  std::mt19937_64 random(4);
  PointContent content;
  content.width = 300;
  content.height = 1;
  content.has_fields = false;
  const VoxelFrame frame = pointFrame(random, content);
  Message message;
  writeVoxels(frame, message);
  EXPECT_EQ(message.width, 300u);
  EXPECT_EQ(message.height, 1u);
  EXPECT_TRUE(message.is_dense);
  for (std::size_t i = 0; i < frame.pointCount(); ++i) {
    const std::size_t point = frame.cloudIndex(i) * message.point_step;
    EXPECT_EQ(valueAt<float>(message.data, point + 4),
              static_cast<float>(frame.points.positions[i][1]));
    EXPECT_EQ(valueAt<float>(message.data, point + 12),
              frame.intensity_scale.value(frame.points.intensities[i]));
    const VoxelColour colour = frame.fullColour(frame.points.colours[i]);
    EXPECT_EQ(valueAt<std::uint32_t>(message.data, point + 16),
              std::uint32_t{colour.r} << 16 | std::uint32_t{colour.g} << 8 | colour.b);
  }
}

TEST(CloudMessages, AFrameIsDescribedAsTheCloudThatItBecomes)
{
  SensorNodeStatistics statistics;
  statistics.decoded_width = 7;
  statistics.frame.coding.voxels = 3;
  SensorNodeSettings settings;
  for (const bool has_colours : {false, true}) {
    statistics.preprocessing.has_colours = has_colours;
    Message message;
    describeFrame(statistics, settings, message);
    EXPECT_EQ(message.width, 7u);
    EXPECT_EQ(message.row_step, has_colours ? 140u : 112u);
    EXPECT_EQ(message.fields.size(), has_colours ? 5u : 4u);
    EXPECT_EQ(message.format, "pcl_ext/version1");
  }
  statistics.decoded_doubles = true;
  Message of_doubles;
  describeFrame(statistics, settings, of_doubles);
  EXPECT_EQ(of_doubles.row_step, 7u * 32u);
  settings.compression.format = StreamFormat::Published;
  Message message;
  describeFrame(statistics, settings, message);
  EXPECT_EQ(message.format, "pcl_ext/published");
}

TEST(CloudMessages, FieldsFollowTheOthersOrTakeTheirPlace)
{
  VoxelFrame frame = emptyFrame(2);
  frame.keys = {5, 9};
  frame.intensities = {60, 70};
  frame.has_point_counts = true;
  frame.point_counts = {2, 1};
  const auto add = [&frame](const char* name,
                            FieldType type,
                            std::uint32_t count,
                            const std::vector<std::uint64_t>& numbers) {
    FrameField& field = frame.fields.emplace_back();
    field.name = name;
    field.type = type;
    field.count = count;
    field.numbers = numbers;
  };
  add("ring", FieldType::UInt8, 1, {3, 4, 5});
  add("pair", FieldType::Int16, 2, {32769, 32770, 32771, 32772, 32773, 32774});
  for (const bool has_own_intensity : {false, true}) {
    if (has_own_intensity)
      add("intensity", FieldType::UInt8, 1, {7, 8, 9});
    ASSERT_TRUE(isConsistent(frame));
    Message message;
    writeVoxels(frame, message);
    const std::uint32_t ring = has_own_intensity ? 12 : 16;
    EXPECT_EQ(fieldsOf(message),
              has_own_intensity ? "x0:7 y4:7 z8:7 ring12:2 pair13:3 intensity17:2 "
                                : "x0:7 y4:7 z8:7 intensity12:7 ring16:2 pair17:3 ");
    ASSERT_EQ(message.data.size(), 3 * message.point_step);
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::size_t point = i * message.point_step;
      EXPECT_EQ(message.data[point + ring], 3 + i);
      EXPECT_EQ(valueAt<std::int16_t>(message.data, point + ring + 1), 1 + 2 * i);
      EXPECT_EQ(valueAt<std::int16_t>(message.data, point + ring + 3), 2 + 2 * i);
      if (has_own_intensity)
        EXPECT_EQ(message.data[point + 17], 7 + i);
      else
        EXPECT_EQ(valueAt<float>(message.data, point + 12), i < 2 ? 60.0f : 70.0f);
    }
  }
}

TEST(CloudMessages, CloudsAreCopiedOrMoved)
{
  Message message;
  message.header.frame_id = "camera";
  message.height = 2;
  message.width = 3;
  message.fields = {{"x", 0, 7, 1}, {"rgb", 16, 6, 2}};
  message.is_bigendian = true;
  message.point_step = 20;
  message.row_step = 64;
  message.is_dense = true;
  message.data = {1, 2, 3};
  const std::uint8_t* const memory = message.data.data();
  pcl::PCLPointCloud2 copy;
  toPcl(message, copy);
  pcl::PCLPointCloud2 moved;
  moveToPcl(message, moved);
  EXPECT_EQ(moved.data.data(), memory);
  for (const pcl::PCLPointCloud2& cloud : {copy, moved}) {
    EXPECT_EQ(cloud.header.frame_id, "camera");
    EXPECT_EQ(cloud.height, 2u);
    EXPECT_EQ(cloud.width, 3u);
    ASSERT_EQ(cloud.fields.size(), 2u);
    EXPECT_EQ(cloud.fields[1].name, "rgb");
    EXPECT_EQ(cloud.fields[1].offset, 16u);
    EXPECT_EQ(cloud.fields[1].datatype, 6);
    EXPECT_EQ(cloud.fields[1].count, 2u);
    EXPECT_TRUE(cloud.is_bigendian);
    EXPECT_EQ(cloud.point_step, 20u);
    EXPECT_EQ(cloud.row_step, 64u);
    EXPECT_TRUE(cloud.is_dense);
    EXPECT_EQ(cloud.data, (std::vector<std::uint8_t>{1, 2, 3}));
  }
}

} // namespace
