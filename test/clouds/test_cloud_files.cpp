// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_files.h"
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
#include <fstream>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace clouds {
namespace test {

using Points = pcl::PointCloud<pcl::PointXYZRGBNormal>;
using Bytes = std::vector<std::uint8_t>;

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

void
writeBytes(const std::string& path, const Bytes& bytes)
{
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/** \brief Why a file cannot be read; empty: it can. */
std::string
refusal(const std::string& path)
{
  pcl::PCLPointCloud2 cloud;
  try {
    readCloud(path, cloud);
  }
  catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
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

TEST(CloudFiles, PlyOfOtherProgramsIsReadAsTheyMeanIt)
{
  const recording::test::TestFolder folder;
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
    writeBytes(folder / "x.ply", Bytes(content.begin(), content.end()));
    pcl::PCLPointCloud2 cloud;
    readCloud(folder / "x.ply", cloud);
    ASSERT_EQ(cloud.fields.size(), 5u);
    EXPECT_EQ(cloud.fields[3].name, "rgba");
    EXPECT_EQ(cloud.fields[4].name, "ring");
    ASSERT_EQ(cloud.width, 2u);
    double x = 0.0;
    std::uint32_t colour = 0;
    std::int16_t ring = 0;
    std::memcpy(&x, cloud.data.data(), sizeof(x));
    std::memcpy(&colour, &cloud.data[cloud.fields[3].offset], sizeof(colour));
    std::memcpy(
        &ring, &cloud.data[cloud.point_step + cloud.fields[4].offset], sizeof(ring));
    EXPECT_EQ(x, 4500000.125);
    EXPECT_EQ(colour, 0x04010203u);
    EXPECT_EQ(ring, 6);
  }
}

TEST(CloudFiles, HeadersMayBeWrittenInOtherWays)
{
  const recording::test::TestFolder folder;
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
    writeBytes(folder / "x.pcd", Bytes(file.begin(), file.end()));
    pcl::PCLPointCloud2 cloud;
    ASSERT_NO_THROW(readCloud(folder / "x.pcd", cloud));
    EXPECT_EQ(cloud.width, 2u);
    EXPECT_EQ(cloud.height, 1u);
    std::array<float, 6> numbers{};
    ASSERT_EQ(cloud.data.size(), sizeof(numbers));
    std::memcpy(numbers.data(), cloud.data.data(), sizeof(numbers));
    EXPECT_EQ(numbers, (std::array<float, 6>{1, 2, 3, 4, 5, 6}));
  }
}

TEST(CloudFiles, WhatContradictsItselfIsRefused)
{
  const recording::test::TestFolder folder;
  const std::string vertices = "element vertex 2\nproperty float x\nproperty float y\n"
                               "property float z\n";
  const std::string points = "1 2 3\n4 5 6\n";
  const std::string image =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n" + vertices +
      "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n" +
      points;
  // Of 20 bytes a vertex, with which places become small again in numbers of 64 bits.
  const std::string wide_image =
      "ply\nformat ascii 1.0\nobj_info num_cols 1\nobj_info num_rows 1\n" + vertices +
      "property float a\nproperty float b\nelement range_grid 1\n"
      "property list uchar int vertex_indices\nend_header\n1 2 3 4 5\n6 7 8 9 10\n";
  const std::string sized_image =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n" + vertices;
  const std::string list =
      "\nproperty list uchar int vertex_indices\nend_header\n" + points;
  const std::string pcd = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\n";
  const std::pair<std::string, std::string> files[] = {
      {"ply\n" + vertices + "end_header\n" + points, "no line format"},
      {"ply\nformat ascii 1.0\nformat binary_little_endian 1.0\n" + vertices +
           "end_header\n" + points,
       "two lines format"},
      {"ply\nformat ascii 9.9\n" + vertices + "end_header\n" + points, "version 1.0"},
      {image + "1 0\n1 1\n0\n", "cut off in its image"},
      {image + "1 0\n2 1 1\n0\n0\n", "neither empty nor"},
      {image + "1 0\n1\n0\n0\n", "neither empty nor"},
      {image + "1 0\n1 2\n0\n0\n", "a vertex that is not there"},
      {wide_image + "1 922337203685477580\n", "a vertex that is not there"},
      {image + "1 0\n1 -1\n0\n0\n", "'-1' in place of a number"},
      {"ply\nformat ascii 1.0\ncomment " + std::string(1 << 20, '-') + '\n' + vertices +
           "end_header\n" + points,
       "no line end_header"},
      {"ply\nformat binary_little_endian 1.0\nelement strip 1\n"
       "property list char uchar parts\n" +
           vertices + "end_header\n\xff" + std::string(300, '\0'),
       "negative"},
      {"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F X\nWIDTH 2\nDATA ascii\n" +
           points,
       "unknown TYPE 'X'"},
      {pcd + "FIELDS z y x\nDATA ascii\n" + points, "two lines FIELDS"},
      {pcd + "COLUMNS z y x\nDATA ascii\n" + points, "two lines FIELDS"},
      {pcd + "SIZE 4 4 8\nDATA ascii\n" + points, "two lines SIZE"},
      {pcd + "WIDTH 1\nDATA ascii\n" + points, "two lines WIDTH"},
      {pcd + "VIEWPOINT 0 0 0 1 0 0 0\nVIEWPOINT 1 0 0 1 0 0 0\nDATA ascii\n" + points,
       "two lines VIEWPOINT"},
      {sized_image + "element range_grid 3" + list + "1 1\n1 0\n0\n",
       "number of elements range_grid"},
      {sized_image + "element range_grid 2\nproperty int vertex\nend_header\n" +
           points + "1\n0\n",
       "no lists of vertices"},
      {sized_image + "obj_info num_cols 1\nobj_info num_rows 2\nend_header\n" + points,
       "two lines num_cols"},
      {"VERSION .7\nFIELDS x y x\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\n" +
           points,
       "two fields 'x'"},
      {"ply\nformat ascii 1.0\n" + vertices +
           "property float z\nend_header\n1 2 3 4\n" + "5 6 7 8\n",
       "two fields 'z'"},
      {"ply\nformat ascii 1.0\n" + vertices + vertices + "end_header\n" + points,
       "two elements 'vertex'"}};
  for (const auto& [file, reason] : files) {
    SCOPED_TRACE(file);
    writeBytes(folder / "x.ply", Bytes(file.begin(), file.end()));
    const std::string message = refusal(folder / "x.ply");
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
}

/** \brief Points of a lidar as so many floats each: x, y, z and, as far as there is room,
 * an intensity up to 1, a row and a time in microseconds, or colours if they have 6. */
std::vector<std::vector<float>>
scanOf(std::size_t numbers, bool has_order)
{
  std::vector<std::vector<float>> points;
  std::mt19937 random(7);
  for (int row = 0; row < 16; ++row)
    for (int column = 0; column < 60; ++column) {
      const float azimuth = 0.1f * static_cast<float>(column);
      const float elevation = 0.03f * static_cast<float>(row - 12);
      const float range = 6.0f / std::max(std::abs(std::cos(azimuth)), 0.1f);
      const float intensity = static_cast<float>(random() % 100) / 99.0f;
      std::vector<float> point = {range * std::cos(azimuth),
                                  range * std::sin(azimuth),
                                  range * elevation,
                                  intensity,
                                  static_cast<float>(row),
                                  1.5e15f};
      if (numbers == 6)
        for (std::size_t i = 3; i < 6; ++i)
          point[i] = static_cast<float>(random() % 256);
      point.resize(numbers);
      points.push_back(point);
    }
  if (!has_order)
    std::shuffle(points.begin(), points.end(), random);
  return points;
}

Bytes
bytesOf(const std::vector<std::vector<float>>& points)
{
  Bytes bytes;
  for (const std::vector<float>& point : points) {
    const auto* const begin = reinterpret_cast<const std::uint8_t*>(point.data());
    bytes.insert(bytes.end(), begin, begin + point.size() * sizeof(float));
  }
  return bytes;
}

TEST(CloudFiles, BinFilesOfAnotherLayoutThanTheirNameTellsAreRefused)
{
  const recording::test::TestFolder folder;
  for (const std::string name : {"a.bin", "a.pcd.bin"})
    for (const bool has_order : {true, false})
      for (const std::size_t numbers : {3u, 4u, 5u, 6u, 7u}) {
        SCOPED_TRACE(name + ", " + std::to_string(numbers));
        const auto points = scanOf(numbers, has_order);
        writeBytes(folder / name, bytesOf(points));
        pcl::PCLPointCloud2 cloud;
        if (numbers == (name == "a.bin" ? 4u : 5u)) {
          ASSERT_NO_THROW(readCloud(folder / name, cloud));
          EXPECT_EQ(cloud.data, bytesOf(points));
          EXPECT_EQ(cloud.width, points.size());
          EXPECT_EQ(cloud.fields.size(), numbers);
          EXPECT_EQ(cloud.fields.back().name, numbers == 4 ? "intensity" : "ring");
          continue;
        }
        EXPECT_NE(refusal(folder / name)
                      .find("its numbers are those of " + std::to_string(numbers) +
                            " floats"),
                  std::string::npos)
            << refusal(folder / name);
      }
}

TEST(CloudFiles, BinFilesOfOtherNumbersAreRefused)
{
  const recording::test::TestFolder folder;
  const auto expectRefusal = [&folder](const Bytes& bytes, const std::string& reason) {
    writeBytes(folder / "a.bin", bytes);
    EXPECT_NE(refusal(folder / "a.bin").find(reason), std::string::npos)
        << refusal(folder / "a.bin");
  };
  const auto points = scanOf(4, true);
  Bytes doubles;
  Bytes labels;
  for (const std::vector<float>& point : points) {
    for (const double number : point) {
      const auto* const begin = reinterpret_cast<const std::uint8_t*>(&number);
      doubles.insert(doubles.end(), begin, begin + sizeof(number));
    }
    labels.insert(labels.end(), {std::uint8_t(labels.size() % 20), 0, 1, 0});
  }
  expectRefusal(doubles, "each a little-endian float32");
  expectRefusal(labels, "each a little-endian float32");
  Bytes cut = bytesOf(points);
  cut.pop_back();
  expectRefusal(cut, "which is no multiple of 16");
  expectRefusal(Bytes(60),
                "would fit 3 floats a point (x y z): --bin-fields x,y,z or 5 floats a "
                "point (x y z intensity ring, as nuScenes'): --bin-fields "
                "x,y,z,intensity,ring");
}

TEST(CloudFiles, OnlyCloudsWithoutLengthsAreTakenForDamaged)
{
  const recording::test::TestFolder folder;
  // A wall in the plane x = 0, with a number that is as good as 0.
  Points wall(100, 1);
  for (std::size_t i = 0; i < wall.size(); ++i)
    wall[i].y = static_cast<float>(i);
  wall[3].x = 1e-21f;
  Bytes bytes = writePcd(packed(wall), {}, PcdStorage::Binary);
  writeBytes(folder / "x.pcd", bytes);
  pcl::PCLPointCloud2 cloud;
  ASSERT_NO_THROW(readCloud(folder / "x.pcd", cloud));
  // The same with each float in the other order, as of a writer for other machines.
  const std::string begin = "DATA binary\n";
  const auto found =
      std::search(bytes.begin(), bytes.end(), begin.begin(), begin.end());
  ASSERT_NE(found, bytes.end());
  for (auto at = found + static_cast<std::ptrdiff_t>(begin.size());
       at + 4 <= bytes.end();
       at += 4)
    std::reverse(at, at + 4);
  writeBytes(folder / "x.pcd", bytes);
  EXPECT_THROW(readCloud(folder / "x.pcd", cloud), std::runtime_error);
}

TEST(CloudFiles, NormalsHaveTheNamesOfPlyThereAndOfPclHere)
{
  const recording::test::TestFolder folder;
  const Bytes bytes = writePly(packed(randomPoints(3, 1, false)));
  const std::string file(bytes.begin(), bytes.end());
  for (const std::string axis : {"x", "y", "z"})
    EXPECT_NE(file.find("property float n" + axis + "\n"), std::string::npos);
  writeBytes(folder / "x.ply", bytes);
  pcl::PCLPointCloud2 cloud;
  readCloud(folder / "x.ply", cloud);
  std::set<std::string> names;
  for (const pcl::PCLPointField& field : cloud.fields)
    names.insert(field.name);
  for (const std::string axis : {"x", "y", "z"})
    EXPECT_EQ(names.count("normal_" + axis), 1u);
}

TEST(CloudFiles, DamagedFilesAreRefusedOrReadWhole)
{
  const recording::test::TestFolder folder;
  const pcl::PCLPointCloud2 image = packed(randomPoints(6, 4, true));
  const std::pair<std::string, Bytes> files[] = {
      {"a.pcd", writePcd(image, {}, PcdStorage::Binary)},
      {"b.pcd", writePcd(image, {}, PcdStorage::Compressed)},
      {"c.pcd", writePcd(image, {}, PcdStorage::Ascii)},
      {"d.ply", writePly(image)}};
  std::mt19937 random(3);
  std::size_t refused = 0;
  for (const auto& [name, whole] : files)
    for (int i = 0; i < 1000; ++i) {
      Bytes bytes = whole;
      for (std::size_t changes = 1 + random() % 4; changes > 0; --changes) {
        // Half of them in the header.
        std::uint8_t& byte = bytes[random() % (random() % 2 == 0 ? 400 : bytes.size())];
        byte = random() % 2 == 0 ? static_cast<std::uint8_t>(random())
                                 : static_cast<std::uint8_t>('0' + random() % 10);
      }
      if (random() % 4 == 0)
        bytes.resize(random() % bytes.size());
      writeBytes(folder / name, bytes);
      pcl::PCLPointCloud2 cloud;
      try {
        readCloud(folder / name, cloud);
        EXPECT_EQ(cloud.data.size(),
                  std::size_t{cloud.width} * cloud.height * cloud.point_step);
        EXPECT_LE(cloud.data.size(), 176 * bytes.size());
      }
      catch (const std::runtime_error&) {
        ++refused;
      }
    }
  EXPECT_GT(refused, 1000u);
  // Nothing to read, and no end of it.
  const std::string endless[] = {
      "ply\nformat ascii 1.0\nobj_info num_cols 4000000000\n"
      "obj_info num_rows 4000000000\nend_header\n",
      "VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 0 0\nWIDTH 2000000000\n"
      "HEIGHT 1\nPOINTS 2000000000\nDATA binary_compressed\n" +
          std::string(8, '\0')};
  for (const std::string& text : endless) {
    writeBytes(folder / "e.pcd", Bytes(text.begin(), text.end()));
    pcl::PCLPointCloud2 cloud;
    EXPECT_THROW(readCloud(folder / "e.pcd", cloud), std::runtime_error) << text;
  }
}

} // namespace test
} // namespace clouds
} // namespace pcl_ext
