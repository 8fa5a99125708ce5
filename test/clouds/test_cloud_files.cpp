// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_files.h"
#include "clouds/file_layouts.h"
#include "clouds/pcd_file.h"
#include "clouds/ply_file.h"
#include "support/recorded_streams.h"

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

namespace pcl_ext::clouds::test {

using Points = pcl::PointCloud<pcl::PointXYZRGBNormal>;
using recording::test::Bytes;
using recording::test::writeBytes;

/** \brief Points of many digits, with some missing. */
Points
randomPoints(std::uint32_t width, std::uint32_t height, bool has_missing)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-1e3f, 1e3f);
  Points points(width, height);
  for (auto& point : points) {
    point.x = number(random);
    point.y = number(random);
    point.z = number(random);
    point.rgba = static_cast<std::uint32_t>(random()) | 0xff000000u;
    point.normal_x = number(random);
    point.normal_z = number(random);
    point.curvature = number(random);
    if (has_missing && random() % 4 == 0)
      point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
  }
  points.is_dense = !has_missing;
  return points;
}

/** \brief The same points without the gaps between PCL's fields. */
pcl::PCLPointCloud2
packed(const Points& points)
{
  pcl::PCLPointCloud2 from;
  pcl::toPCLPointCloud2(points, from);
  pcl::PCLPointCloud2 cloud = from;
  cloud.point_step = 0;
  for (auto& field : cloud.fields) {
    field.offset = cloud.point_step;
    cloud.point_step += 4;
  }
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.data.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const auto& field : from.fields) {
      const std::uint8_t* const begin = &from.data[i * from.point_step + field.offset];
      cloud.data.insert(cloud.data.end(), begin, begin + 4);
    }
  return cloud;
}

/** \brief Expects the same bits, but of missing points. */
void
expectSamePoints(const pcl::PCLPointCloud2& cloud, const Points& expected)
{
  Points points;
  pcl::fromPCLPointCloud2(cloud, points);
  ASSERT_EQ(points.width, expected.width);
  ASSERT_EQ(points.height, expected.height);
  for (std::size_t i = 0; i < points.size(); ++i) {
    SCOPED_TRACE(i);
    if (std::isnan(expected[i].x)) {
      EXPECT_TRUE(std::isnan(points[i].x));
      continue;
    }
    EXPECT_EQ(points[i].x, expected[i].x);
    EXPECT_EQ(points[i].y, expected[i].y);
    EXPECT_EQ(points[i].z, expected[i].z);
    EXPECT_EQ(points[i].rgba & 0xffffffu, expected[i].rgba & 0xffffffu);
    EXPECT_EQ(points[i].normal_x, expected[i].normal_x);
    EXPECT_EQ(points[i].normal_z, expected[i].normal_z);
    EXPECT_EQ(points[i].curvature, expected[i].curvature);
  }
}

TEST(CloudFiles, ReadWhatPclHasWritten)
{
  const recording::test::TestFolder folder;
  for (const std::uint32_t height : {1u, 7u}) {
    const Points points = randomPoints(31, height, height > 1);
    pcl::io::savePCDFileASCII(folder / "ascii.pcd", points);
    pcl::io::savePCDFileBinary(folder / "binary.pcd", points);
    pcl::io::savePCDFileBinaryCompressed(folder / "compressed.pcd", points);
    pcl::PCLPointCloud2 message;
    pcl::toPCLPointCloud2(points, message);
    pcl::PLYWriter().writeBinary(
        folder / "binary.ply", message, {}, {1, 0, 0, 0}, false);
    for (const std::string name : {"binary.pcd", "compressed.pcd", "binary.ply"}) {
      SCOPED_TRACE(name);
      pcl::PCLPointCloud2 cloud;
      readCloud(folder / name, cloud);
      expectSamePoints(cloud, points);
    }
    // PCL writes 8 digits.
    pcl::PCLPointCloud2 text;
    readCloud(folder / "ascii.pcd", text);
    Points rounded;
    pcl::fromPCLPointCloud2(text, rounded);
    ASSERT_EQ(rounded.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!std::isnan(points[i].x)) {
        EXPECT_NEAR(rounded[i].x, points[i].x, 1e-4f);
        EXPECT_EQ(rounded[i].rgba & 0xffffffu, points[i].rgba & 0xffffffu);
      }
  }
}

TEST(CloudFiles, WriteWhatPclReads)
{
  const recording::test::TestFolder folder;
  Viewpoint viewpoint;
  viewpoint.origin << 0.1f, -2.5f, 1e-3f, 0.0f;
  viewpoint.orientation = Eigen::Quaternionf(0.5f, 0.5f, -0.5f, 0.5f);
  for (const std::uint32_t height : {1u, 7u}) {
    const Points points = randomPoints(31, height, height > 1);
    const pcl::PCLPointCloud2 cloud = packed(points);
    for (const PcdStorage storage :
         {PcdStorage::Binary, PcdStorage::Compressed, PcdStorage::Ascii}) {
      SCOPED_TRACE(static_cast<int>(storage));
      writeBytes(folder / "x.pcd", writePcd(cloud, viewpoint, storage));
      pcl::PCLPointCloud2 read;
      Eigen::Vector4f origin;
      Eigen::Quaternionf orientation;
      int version = 0;
      ASSERT_EQ(
          pcl::PCDReader().read(folder / "x.pcd", read, origin, orientation, version),
          0);
      expectSamePoints(read, points);
      EXPECT_EQ(origin.head<3>(), viewpoint.origin.head<3>());
      EXPECT_EQ(orientation.coeffs(), viewpoint.orientation.coeffs());
    }
    writeBytes(folder / "x.ply", writePly(cloud));
    pcl::PCLPointCloud2 read;
    ASSERT_EQ(pcl::PLYReader().read(folder / "x.ply", read), 0);
    expectSamePoints(read, points);
  }
}

TEST_F(FileLayouts, PlyOfOtherProgramsIsReadAsTheyMeanIt)
{
  // Elements before and after, lists, alpha, numbers of 64 bits and the other order of
  // bytes.
  const std::string header =
      "element camera 1\nproperty float focus\n"
      "element strip 2\nproperty list uchar short parts\n"
      "element vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty uchar alpha\nproperty short ring\n"
      "element face 1\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  const std::string text =
      "ply\nformat ascii 1.0\ncomment made by hand\n" + header +
      "1.5\n0\n2 7 8\n4500000.125 -2 3 1 2 3 4 -5\n1 2 3 255 0 7 9 6\n3 0 1 1\n";
  std::string binary = "ply\nformat binary_big_endian 1.0\n" + header;
  const auto add = [&binary](auto number) {
    std::array<char, sizeof(number)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(number));
    binary.append(bytes.rbegin(), bytes.rend());
  };
  add(1.5f);
  binary += std::string("\0\2\0\7\0\10", 6);
  for (const double coordinate : {4500000.125, -2.0, 3.0})
    add(coordinate);
  binary += "\1\2\3\4";
  add(std::int16_t{-5});
  for (const double coordinate : {1.0, 2.0, 3.0})
    add(coordinate);
  binary += std::string("\xff\0\7\11", 4);
  add(std::int16_t{6});
  binary += std::string("\3\0\0\0\0\0\0\0\1\0\0\0\1", 13);
  for (const std::string& content : {text, binary}) {
    read("x.ply", content);
    EXPECT_EQ(fieldNames(), "x y z rgba ring");
    EXPECT_EQ(doubles("x"), (Doubles{4500000.125, 1.0}));
    EXPECT_EQ(numbers<std::uint32_t>("rgba", F::UINT32)[0], 0x04010203u);
    EXPECT_EQ(numbers<std::int16_t>("ring", F::INT16),
              (std::vector<std::int16_t>{-5, 6}));
  }
}

TEST_F(FileLayouts, HeadersMayBeWrittenInOtherWays)
{
  const std::string points = "1 2 3\n4 5 6\n";
  const std::string fields = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  const std::string vertices = "element vertex 2\nproperty float x\nproperty float y\n"
                               "property float z\nend_header\n" +
                               points;
  const std::string format = "format ascii 1.0\n";
  std::string comments;
  for (int i = 0; i < 150; ++i)
    comments += "# a remark\n";
  const std::string files[] = {
      "VERSION .7\n" + fields + "WIDTH 2 \nHEIGHT\t1\nPOINTS  2\nDATA  ascii \n" +
          points,
      "VERSION .7\r\n" + fields + "\t WIDTH 2\nDATA ascii\n" + points,
      "VERSION .7\n" + fields + "POINTS 2\nDATA ascii\n" + points,
      "# .PCD\n" + comments + fields + "WIDTH 2\nHEIGHT 1\nDATA ascii\n" + points,
      "# .PCD\n#" + std::string(70000, '-') + '\n' + fields +
          "WIDTH 2\nHEIGHT 1\nDATA ascii\n" + points,
      "ply \n" + format + vertices,
      "ply\n" + format + "comment " + std::string(70000, '-') + '\n' + vertices,
      "ply\n" + format + "obj_info num_cols = 2\nobj_info num_rows 1\n" + vertices,
      "ply\n" + format + "obj_info num_cols 7\n" + vertices};
  for (const std::string& file : files) {
    SCOPED_TRACE(file.substr(0, 200));
    ASSERT_NO_THROW(read("x.pcd", file));
    EXPECT_EQ(cloud_.height, 1u);
    EXPECT_EQ(floats("x"), (Floats{1.0f, 4.0f}));
    EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
    EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  }
}

TEST_F(FileLayouts, OnlyCloudsWithoutLengthsAreTakenForDamaged)
{
  // A wall in the plane x = 0, with a number that is as good as 0.
  std::string wall;
  for (int i = 0; i < 100; ++i)
    for (const float number : {i == 3 ? 1e-21f : 0.0f, static_cast<float>(i), 0.0f})
      append(number, wall);
  ASSERT_NO_THROW(readPcd("x y z", 100, "binary\n" + wall));
  // The same with each float in the other order, as of a writer for other machines.
  for (auto at = wall.begin(); at != wall.end(); at += 4)
    std::reverse(at, at + 4);
  EXPECT_THROW(readPcd("x y z", 100, "binary\n" + wall), std::runtime_error);
}

TEST_F(FileLayouts, NormalsHaveTheNamesOfPlyThereAndOfPclHere)
{
  const Bytes bytes = writePly(packed(randomPoints(3, 1, false)));
  const std::string file(bytes.begin(), bytes.end());
  read("x.ply", file);
  for (const std::string axis : {"x", "y", "z"}) {
    expectPart(file, "property float n" + axis + "\n");
    expectPart(fieldNames(), "normal_" + axis);
  }
}

TEST(CloudFiles, DamagedFilesAreRefusedOrReadWhole)
{
  const recording::test::TestFolder folder;
  const pcl::PCLPointCloud2 image = packed(randomPoints(6, 4, true));
  const std::string list =
      ply("binary_big_endian",
          xyz + "property list uchar float w\nproperty ushort red\n"
                "property ushort green\nproperty ushort blue\n",
          std::string(12, '\x3f') + '\1' + std::string(10, '\x3f') +
              std::string(12, '\x3e') + '\0' + std::string(6, '\x3e'));
  const std::string whole_numbers =
      ply("ascii",
          "property short x\nproperty int y\nproperty bool z\n"
          "property list uchar int w\n",
          "1 2 0 2 3 4\n4 5 1 0\n");
  const std::string other_fields =
      pcd("X:I2 Y Z r:U1 g:U1 b:U1 stamp:U8 half:F2 _:U1x5 gone:F4x0",
          2,
          "binary\n" + std::string(2 * 28, '\x11'));
  const std::string other_lines =
      pcd("x y z rgb:I4 stamp:U8x2", 2, "ascii\r1 2 3 4 5 6\r7 8 9 -1 2 3\r");
  std::vector<Bytes> files = {writePcd(image, {}, PcdStorage::Binary),
                              writePcd(image, {}, PcdStorage::Compressed),
                              writePcd(image, {}, PcdStorage::Ascii),
                              writePly(image)};
  for (const std::string& text : {list, whole_numbers, other_fields, other_lines})
    files.emplace_back(text.begin(), text.end());
  std::mt19937 random(3);
  std::size_t refused = 0;
  std::size_t read_whole = 0;
  for (const Bytes& whole : files)
    for (int i = 0; i < 1200; ++i) {
      Bytes bytes = whole;
      for (std::size_t changes = random() % 5; changes > 0; --changes) {
        // Half of them in the header.
        std::uint8_t& byte =
            bytes[random() % (random() % 2 == 0
                                  ? std::min<std::size_t>(400, bytes.size())
                                  : bytes.size())];
        byte = random() % 2 == 0 ? static_cast<std::uint8_t>(random())
                                 : static_cast<std::uint8_t>('0' + random() % 10);
      }
      if (random() % 4 == 0)
        bytes.resize(random() % bytes.size());
      writeBytes(folder / "a.pcd", bytes);
      pcl::PCLPointCloud2 cloud;
      try {
        readCloud(folder / "a.pcd", cloud);
        ++read_whole;
        EXPECT_EQ(cloud.data.size(),
                  std::size_t{cloud.width} * cloud.height * cloud.point_step);
        EXPECT_LE(cloud.data.size(), 176 * bytes.size());
      }
      catch (const std::runtime_error&) {
        ++refused;
      }
    }
  EXPECT_GT(refused, 2000u);
  EXPECT_GT(read_whole, 2000u);
}

} // namespace pcl_ext::clouds::test
