// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/message_layouts.h"
#include "support/node_tests.h"

#include <array>
#include <cstring>
#include <limits>

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::test::makeField;

/** \brief An organised cloud of 8 x 500 points with gaps between and after the fields;
 * points that are not finite, and others outside of a box. */
pcl::PCLPointCloud2
lidarMessage()
{
  using Field = pcl::PCLPointField;
  pcl::PCLPointCloud2 cloud;
  cloud.fields = {makeField("ring", 0, Field::UINT8),
                  makeField("x", 4, Field::FLOAT32),
                  makeField("y", 8, Field::FLOAT32),
                  makeField("z", 12, Field::FLOAT32),
                  makeField("_", 16, Field::FLOAT32),
                  makeField("t", 21, Field::UINT32, 0), // one value, not aligned
                  makeField("pair", 25, Field::INT16, 2),
                  makeField("beyond", 30, Field::FLOAT64)};
  cloud.point_step = 32;
  cloud.width = 500;
  cloud.height = 8;
  cloud.row_step = cloud.width * cloud.point_step + 12;
  cloud.data.resize(cloud.height * cloud.row_step);
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column) {
      std::uint8_t* const point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      const float place[3] = {column % 7 == 3 ? std::numeric_limits<float>::quiet_NaN()
                                              : 0.011f * static_cast<float>(column),
                              0.3f * static_cast<float>(row),
                              1.0f};
      const std::uint32_t t = column + 1000 * row;
      const std::int16_t pair[2] = {static_cast<std::int16_t>(column),
                                    static_cast<std::int16_t>(-column)};
      point[0] = static_cast<std::uint8_t>(row);
      std::memcpy(point + 4, place, sizeof(place));
      std::memcpy(point + 21, &t, sizeof(t));
      std::memcpy(point + 25, pair, sizeof(pair));
    }
  return cloud;
}

TEST(SensorNodeFields, OfThePointsInTheBoxComeBack)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::None);
  settings.compression.resolution = 0.25;
  settings.compression.keep_points = true;
  settings.compression.fields = {{pcl_ext::io::all_fields}};
  settings.compression.bounding_box.reset();
  settings.crop_box = pcl_ext::io::BoundingBox{{0.0, -9.0, -9.0}, {4.0, 9.0, 9.0}};
  SensorNode node(settings);
  const pcl::PCLPointCloud2 cloud = lidarMessage();
  EXPECT_EQ(describeLeftOut(cloud, settings),
            "fields that are left out: beyond; the rows and columns of the points are "
            "kept only where that takes hardly more bytes");
  SensorNodeSettings removing = settings;
  removing.outlier_removal.emplace().unit = pcl_ext::RaysUnit();
  EXPECT_EQ(describeLeftOut(cloud, removing),
            "fields that are left out: beyond; the rows and columns of the points are "
            "not kept, as outliers are removed from voxels");
  FrameDecoder decoder;
  const VoxelFrame frame =
      decodedWith(decoder, encoded(node, cloud, pcl_ext::WorldPose::Identity()));
  ASSERT_EQ(frame.fields.size(), 3u);
  EXPECT_EQ(frame.fields[0].name, "ring");
  EXPECT_EQ(frame.fields[1].name, "t");
  EXPECT_EQ(frame.fields[2].name, "pair");
  EXPECT_EQ(frame.fields[2].count, 2u);
  std::size_t expected = 0;
  for (std::uint32_t column = 0; column < 500; ++column)
    expected += column % 7 != 3 && 0.011f * static_cast<float>(column) <= 4.0f ? 8 : 0;
  ASSERT_EQ(frame.pointCount(), expected);
  std::map<std::uint64_t, std::size_t> seen;
  std::size_t point = 0;
  for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
    const double x =
        frame.grid.centre(0, pcl_ext::io::voxelPosition(frame.keys[voxel]).x);
    for (std::uint32_t i = 0; i < frame.point_counts[voxel]; ++i, ++point) {
      const std::uint64_t t = frame.fields[1].numbers[point];
      ++seen[t];
      EXPECT_EQ(frame.fields[0].numbers[point], t / 1000);
      EXPECT_EQ(frame.fields[2].numbers[2 * point], 32768 + t % 1000);
      EXPECT_EQ(frame.fields[2].numbers[2 * point + 1], 32768 - t % 1000);
      // Half an edge from the point to its place, and from there to the voxel's centre.
      const double place = frame.points.positions[point][0];
      EXPECT_NEAR(0.011 * static_cast<double>(t % 1000), place, 0.1251);
      EXPECT_NEAR(place, x, 0.1251);
    }
  }
  EXPECT_EQ(seen.size(), expected);
}
TEST(SensorNodeFields, OfCoordinatesMayBeWholeNumbersOrOfSeveralTypes)
{
  using Field = pcl::PCLPointField;
  struct Kind {
    std::array<std::uint8_t, 3> types; ///< of x, y, z
    std::uint8_t read_as;
    std::string remark;
  };
  const Kind kinds[] = {{{Field::INT8, Field::UINT8, Field::UINT16},
                         Field::FLOAT32,
                         "int8, uint8, uint16"},
                        {{Field::FLOAT32, Field::INT16, Field::FLOAT32},
                         Field::FLOAT32,
                         "float32, int16, float32"},
                        {{Field::INT32, Field::INT32, Field::UINT32},
                         Field::FLOAT64,
                         "int32, int32, uint32"},
                        {{Field::FLOAT32, Field::FLOAT64, Field::INT16},
                         Field::FLOAT64,
                         "float32, float64, int16"}};
  SensorNodeSettings settings = settingsOf(IntensityLaw::None);
  settings.compression.bounding_box.reset();
  settings.compression.keep_points = true;
  settings.compression.keep_order = true;
  const auto cloudOf = [](const std::array<std::uint8_t, 3>& types) {
    pcl::PCLPointCloud2 cloud;
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      cloud.fields.push_back(
          makeField(std::string(1, "xyz"[axis]), 8 * axis, types[axis]));
    cloud.width = 40;
    cloud.height = 3;
    cloud.point_step = 24;
    cloud.row_step = 24 * 40 + 5;
    cloud.data.resize(3 * cloud.row_step);
    for (std::size_t i = 0; i < 120; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        pcl_ext::test::writeNumber(
            &cloud.data[i / 40 * cloud.row_step + i % 40 * 24 + 8 * axis],
            types[axis],
            static_cast<double>((i + 1) * (axis + 1) % 41));
    return cloud;
  };
  const auto pose = pcl_ext::WorldPose::Identity();
  for (const Kind& kind : kinds) {
    SensorNode node(settings);
    SensorNode real(settings);
    const pcl::PCLPointCloud2 cloud = cloudOf(kind.types);
    EXPECT_EQ(encoded(node, cloud, pose),
              encoded(real, cloudOf({kind.read_as, kind.read_as, kind.read_as}), pose));
    EXPECT_EQ(describeLeftOut(cloud, settings),
              "coordinates x, y and z (" + kind.remark + ") are taken as " +
                  (kind.read_as == Field::FLOAT32 ? "float32" : "float64") +
                  ", metres");
  }
}

TEST(SensorNodeFields, AreInTheLayoutIfTheyMayComeBack)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::None);
  settings.compression.bounding_box.reset();
  settings.compression.fields = {{"t"}};
  settings.carry_layout = true;
  SensorNode node(settings);
  pcl::PCLPointCloud2 cloud = lidarMessage();
  const auto pose = pcl_ext::WorldPose::Identity();
  FrameDecoder decoder;
  const VoxelFrame first = decodedWith(decoder, encoded(node, cloud, pose));
  ASSERT_TRUE(first.layout);
  std::string names;
  for (const auto& field : first.layout->fields)
    names += field.name + " " + std::to_string(field.offset) + " ";
  EXPECT_EQ(names, "x 4 y 8 z 12 t 21 ");
  EXPECT_EQ(first.layout->point_step, 32u);
  EXPECT_EQ(first.layout->row_padding, 12u);
  // Of another width alone, it is the same; an empty cloud has none.
  cloud.height = 1;
  decodedWith(decoder, encoded(node, cloud, pose));
  EXPECT_FALSE(decoder.statistics().is_i_frame);
  pcl::PCLPointCloud2 empty = cloud;
  empty.width = empty.row_step = 0;
  empty.data.clear();
  EXPECT_TRUE(decodedWith(decoder, encoded(node, empty, pose)).layout);
  EXPECT_FALSE(decoder.statistics().is_i_frame);
  EXPECT_EQ(describeLeftOut(cloud, settings).find("layout"), std::string::npos);
  // Too large.
  cloud.point_step = 5000;
  cloud.width = 1;
  cloud.row_step = 5000;
  cloud.data.resize(5000);
  EXPECT_FALSE(decodedWith(decoder, encoded(node, cloud, pose)).layout);
  EXPECT_NE(describeLeftOut(cloud, settings)
                .find("; the layout of messages with 5000 bytes a point is not kept"),
            std::string::npos);
}
TEST(SensorNodeFields, ThatCannotBeKeptAreNamed)
{
  using Field = pcl::PCLPointField;
  SensorNodeSettings settings = settingsOf(IntensityLaw::None);
  settings.compression.bounding_box.reset();
  settings.compression.fields = {{pcl_ext::io::all_fields}};
  pcl::PCLPointCloud2 cloud = lidarMessage();
  cloud.fields.insert(cloud.fields.end(),
                      {makeField("stamp", 24, pcl_ext::detail::uint64_datatype),
                       makeField(std::string(65, 'n'), 21, Field::UINT8),
                       makeField("t", 25, Field::UINT8), // kept, as all names are
                       makeField("rgb", 16, Field::UINT32),
                       makeField("rgba", 20, Field::UINT32)});
  EXPECT_EQ(describeLeftOut(cloud, settings),
            "fields that are left out: beyond, stamp, " + std::string(64, 'n') +
                ", rgba; the rows and columns of the points are not kept");
  SensorNode all(settings);
  FrameDecoder decoder;
  const VoxelFrame frame =
      decodedWith(decoder, encoded(all, cloud, pcl_ext::WorldPose::Identity()));
  ASSERT_EQ(frame.fields.size(), 4u);
  EXPECT_EQ(frame.fields[3].name, "t");
  // Of a name that is there twice the first is kept.
  settings.compression.fields = {{"t"}, {"rgba"}};
  EXPECT_EQ(describeLeftOut(cloud, settings),
            "fields that are left out: ring, pair, beyond, stamp, " +
                std::string(64, 'n') +
                ", another t; the rows and columns of the points are not kept");
  for (const char* name : {"stamp", "beyond", "x"}) {
    settings.compression.fields = {{name}};
    SensorNode node(settings);
    std::vector<std::uint8_t> bytes;
    const SensorNodeStatus status =
        node.encode(cloud, pcl_ext::WorldPose::Identity(), bytes);
    EXPECT_EQ(status.code(), SensorNodeCode::InvalidCloud);
    EXPECT_EQ(
        status.message(),
        "field '" + std::string(name) +
            "' cannot be kept: it is a coordinate or a gap, its datatype is none "
            "of int8 to uint32, float32 and float64, or it is not within a point");
  }
}

} // namespace
