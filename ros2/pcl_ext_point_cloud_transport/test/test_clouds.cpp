// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "test_clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace pcl_ext_point_cloud_transport::test {

namespace {

namespace io = pcl_ext::io;
using sensor_msgs::msg::PointField;

/** \brief A number within [begin, end). The standard distributions differ between
 * standard libraries. */
float
between(std::mt19937& random, float begin, float end)
{
  constexpr std::uint32_t numbers = 1u << 20;
  return begin + (end - begin) * static_cast<float>(random() % numbers) /
                     static_cast<float>(numbers);
}

void
addField(Cloud& cloud, const char* name, std::uint32_t offset, std::uint8_t type)
{
  PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
  cloud.fields.push_back(field);
}

/** \brief Fields and point_step. */
void
describe(Layout layout, Cloud& cloud)
{
  const std::uint32_t first = layout == Layout::Lidar ? 3 : 0; // nothing is aligned
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    addField(cloud,
             axis == 0   ? "x"
             : axis == 1 ? "y"
                         : "z",
             first + 4 * axis,
             PointField::FLOAT32);
  switch (layout) {
  case Layout::Xyz:
  case Layout::Organized:
    cloud.point_step = 12;
    break;
  case Layout::XyzPadded:
    cloud.point_step = 16;
    break;
  case Layout::XyziPacked:
    addField(cloud, "intensity", 12, PointField::FLOAT32);
    cloud.point_step = 16;
    break;
  case Layout::Xyzi:
  case Layout::PaddedRows:
    addField(cloud, "intensity", 16, PointField::FLOAT32);
    cloud.point_step = 32;
    break;
  case Layout::XyzRgb:
    addField(cloud, "rgb", 16, PointField::FLOAT32);
    cloud.point_step = 32;
    break;
  case Layout::XyzRgbi:
    addField(cloud, "rgba", 12, PointField::UINT32);
    addField(cloud, "intensity", 16, PointField::FLOAT32);
    cloud.point_step = 20;
    break;
  case Layout::Lidar:
    addField(cloud, "intensity", 15, PointField::UINT16);
    addField(cloud, "ring", 17, PointField::UINT16);
    addField(cloud, "time", 19, PointField::FLOAT64);
    cloud.point_step = 29;
    break;
  }
}

/** \brief The bytes of a field, of which those that no field has are random, too. */
void
writePoint(std::mt19937& random,
           const Cloud& cloud,
           const std::array<float, 3>& position,
           std::uint8_t* point)
{
  for (std::uint32_t i = 0; i < cloud.point_step; ++i)
    point[i] = static_cast<std::uint8_t>(random());
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::memcpy(point + cloud.fields[axis].offset, &position[axis], sizeof(float));
  for (const PointField& field : cloud.fields) {
    const auto whole = static_cast<std::uint16_t>(random() % 200);
    const auto number = static_cast<float>(whole);
    if (field.name == "intensity" && field.datatype == PointField::UINT16)
      std::memcpy(point + field.offset, &whole, sizeof(whole));
    else if (field.name == "intensity")
      std::memcpy(point + field.offset, &number, sizeof(number));
  }
}

std::array<float, 3>
makePoint(std::mt19937& random, std::uint32_t number, std::uint32_t index)
{
  const float ball_x = -0.8f + 0.05f * static_cast<float>(number % 32);
  std::array<float, 3> point{between(random, -1.0f, 1.0f),
                             between(random, -1.0f, 1.0f),
                             3.0f + between(random, -0.02f, 0.02f)};
  const float from_centre = std::hypot(point[0] - ball_x, point[1]);
  if (from_centre < 0.3f)
    point[2] = 2.0f - std::sqrt(0.09f - from_centre * from_centre);
  if (index % 50 == 49)
    point[2] = between(random, 0.5f, 4.0f); // noise
  if (index % 97 == 96)
    point[index % 3] = std::numeric_limits<float>::quiet_NaN();
  return point;
}

} // namespace

bool
hasIntensity(Layout layout)
{
  return layout == Layout::Xyzi || layout == Layout::XyziPacked ||
         layout == Layout::Lidar || layout == Layout::XyzRgbi ||
         layout == Layout::PaddedRows;
}

Stamp
stampOf(std::uint32_t number)
{
  Stamp stamp; // neither doubles nor microseconds can represent it
  stamp.sec = static_cast<std::int32_t>(1700000000 + number / 10);
  stamp.nanosec = 12345678 + 100000001 * (number % 9);
  stamp.nanosec += number % 10 == 9 ? 1 : 0;
  return stamp;
}

Cloud
makeCloud(std::uint32_t number, Layout layout)
{
  std::mt19937 random(number + 1);
  Cloud cloud;
  cloud.header.frame_id = "sensor_" + std::to_string(static_cast<int>(layout));
  cloud.header.stamp = stampOf(number);
  const bool is_image = layout == Layout::Organized || layout == Layout::PaddedRows;
  cloud.height = is_image ? 50 : 1;
  cloud.width = is_image ? 80 : 4000;
  describe(layout, cloud);
  cloud.row_step =
      cloud.width * cloud.point_step + (layout == Layout::PaddedRows ? 20u : 0u);
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height, 0xff);
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column)
      writePoint(random,
                 cloud,
                 makePoint(random, number, row * cloud.width + column),
                 &cloud.data[row * cloud.row_step + column * cloud.point_step]);
  return cloud;
}

Voxels
voxelsIn(const Cloud& message)
{
  const std::map<std::string, std::size_t> places = {
      {"x", 0}, {"y", 1}, {"z", 2}, {"intensity", 3}, {"rgb", 4}, {"rgba", 4}};
  Voxels voxels(std::size_t{message.width} * message.height);
  EXPECT_EQ(message.height, 1u);
  EXPECT_EQ(message.row_step, message.point_step * message.width);
  EXPECT_FALSE(message.is_bigendian);
  EXPECT_TRUE(message.is_dense);
  EXPECT_EQ(message.data.size(), message.row_step);
  if (message.data.size() != std::size_t{message.point_step} * voxels.size())
    return {};
  for (const PointField& field : message.fields) {
    EXPECT_EQ(places.count(field.name), 1u) << field.name;
    EXPECT_EQ(field.count, 1u);
    EXPECT_LE(field.offset + 4, message.point_step);
    if (places.count(field.name) == 0 || field.offset + 4 > message.point_step)
      continue;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const std::uint8_t* const bytes =
          &message.data[i * message.point_step + field.offset];
      float& number = voxels[i][places.at(field.name)];
      std::uint16_t whole = 0;
      std::memcpy(&whole, bytes, sizeof(whole));
      if (field.datatype == PointField::UINT16)
        number = whole;
      else
        std::memcpy(&number, bytes, sizeof(number));
    }
  }
  return voxels;
}

Voxels
voxelsIn(const io::VoxelFrame& frame)
{
  Voxels voxels;
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    voxels.push_back({x, y, z, intensity, 0.0f});
    if (frame.colour_bits == 0)
      return;
    const io::VoxelColour colour = frame.fullColour(voxels.size() - 1);
    const auto packed =
        static_cast<std::uint32_t>((colour.r * 256 + colour.g) * 256 + colour.b);
    std::memcpy(&voxels.back()[4], &packed, sizeof(packed));
  });
  return voxels;
}

pcl_ext::nodes::SensorNodeSettings
defaultSettings(Layout layout)
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.law = pcl_ext::automaticLaw(hasIntensity(layout));
  settings.carry_layout = true;
  settings.crop_box.emplace();
  settings.crop_box->min.fill(-box_edge);
  settings.crop_box->max.fill(box_edge);
  return settings;
}

DirectStream::DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings)
: sensor_node_(settings)
{
  EXPECT_TRUE(sensor_node_.settingsStatus().ok())
      << sensor_node_.settingsStatus().message();
}

pcl::PCLPointCloud2
toPcl(const Cloud& cloud)
{
  pcl::PCLPointCloud2 converted;
  converted.header.frame_id = cloud.header.frame_id;
  converted.width = cloud.width;
  converted.height = cloud.height;
  for (const PointField& field : cloud.fields) {
    converted.fields.emplace_back();
    converted.fields.back().name = field.name;
    converted.fields.back().offset = field.offset;
    converted.fields.back().datatype = field.datatype;
    converted.fields.back().count = field.count;
  }
  converted.point_step = cloud.point_step;
  converted.row_step = cloud.row_step;
  converted.data = cloud.data;
  return converted;
}

io::VoxelFrame
DirectStream::frameOf(const Cloud& cloud)
{
  std::vector<std::uint8_t> bytes;
  const pcl_ext::WorldPose pose(pcl_ext::WorldPose::Identity());
  const auto encoded = sensor_node_.encode(toPcl(cloud), pose, bytes);
  EXPECT_TRUE(encoded.ok()) << encoded.message();
  io::VoxelFrame frame;
  const auto decoded = decoder_.decode(bytes.data(), bytes.size(), frame);
  EXPECT_TRUE(decoded.ok()) << decoded.message();
  return frame;
}

Voxels
directVoxels(const Cloud& cloud, const pcl_ext::nodes::SensorNodeSettings& settings)
{
  return DirectStream(settings).voxelsOf(cloud);
}

} // namespace pcl_ext_point_cloud_transport::test
