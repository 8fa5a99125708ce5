// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_layouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::clouds::test {

namespace {

/** \brief Points of a sensor that turns, with numbers as a data set has them. */
std::string
scanBytes(std::size_t points, std::size_t numbers)
{
  std::string bytes;
  for (std::size_t i = 0; i < points; ++i) {
    const float angle = 0.1f * static_cast<float>(i);
    append(8.0f * std::cos(angle), bytes);
    append(8.0f * std::sin(angle), bytes);
    append(-1.7f + 0.01f * static_cast<float>(i % 7), bytes);
    append(static_cast<float>(i * 37 % 101), bytes);
    for (std::size_t j = 4; j < numbers; ++j)
      append(static_cast<float>(i % 32), bytes);
  }
  return bytes;
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

template <typename NumberT>
std::string
bytesAs(const std::vector<std::vector<float>>& points)
{
  std::string bytes;
  for (const std::vector<float>& point : points)
    for (const float number : point)
      append(static_cast<NumberT>(number), bytes);
  return bytes;
}

} // namespace

TEST_F(FileLayouts, NuScenesNameHasFiveNumbersAPoint)
{
  EXPECT_EQ(read("scan__LIDAR_TOP__1532402927647951.pcd.bin", scanBytes(64, 5)),
            Remarks());
  EXPECT_EQ(fieldNames(), "x y z intensity ring");
  EXPECT_EQ(read("SCAN.PCD.BIN", scanBytes(64, 5)), Remarks());
  EXPECT_EQ(cloud_.width, 64u);
  ASSERT_EQ(cloud_.width, 64u);
  EXPECT_EQ(floats("ring")[45], 45 % 32);
  EXPECT_EQ(floats("intensity")[45], 45 * 37 % 101);
  EXPECT_FLOAT_EQ(floats("z")[45], -1.7f + 0.01f * (45 % 7));
}

TEST_F(FileLayouts, FieldsOfBinFilesAreThoseThatAreNamed)
{
  std::string bytes;
  for (int i = 0; i < 3; ++i) {
    append(std::uint16_t(7), bytes);
    append(1.5 * i, bytes);
    append(-2.5f * static_cast<float>(i), bytes);
    append(std::int8_t(-100 + i), bytes);
    append(std::int32_t(70000 * i), bytes);
  }
  const Remarks remarks =
      read("a.bin", bytes, "_:uint16, x:float64,y,ring:int8,z:int32");
  ASSERT_EQ(cloud_.width, 3u);
  EXPECT_EQ(doubles("x"), (Doubles{0.0, 1.5, 3.0}));
  EXPECT_EQ(doubles("y"), (Doubles{0.0, -2.5, -5.0}));
  EXPECT_EQ(doubles("z"), (Doubles{0.0, 70000.0, 140000.0}));
  EXPECT_EQ(numbers<std::int8_t>("ring", F::INT8),
            (std::vector<std::int8_t>{-100, -99, -98}));
  EXPECT_EQ(
      remarks,
      (Remarks{"its coordinates x, y and z (float64, float32, int32) are taken as "
               "float64, metres"}));
  // Also of files of another name, and of nuScenes' one.
  for (const char* name : {"a.dat", "a.pcd.bin"}) {
    EXPECT_EQ(read(name, scanBytes(5, 4), "x,y,z,intensity"), Remarks());
    EXPECT_EQ(cloud_.width, 5u);
  }
}

TEST_F(FileLayouts, WrongFieldsOfBinFilesAreRefusedWithTheReason)
{
  const std::pair<const char*, const char*> faults[] = {
      {"x,y", "no field 'z'"},
      {"x,y,z,x", "two fields 'x'"},
      {"x,y,z,", "a field has no name"},
      {"x,y,z,ring:half",
       "'half' of the field 'ring' is no type: it is one of uint8, "},
      {"x,y,z:", "'' of the field 'z' is no type"},
      {"X,Y,Z", "no field 'x'"}};
  for (const auto& [text, reason] : faults) {
    SCOPED_TRACE(text);
    try {
      parseBinFields(text);
      ADD_FAILURE();
    }
    catch (const std::runtime_error& error) {
      expectPart(error.what(), reason);
    }
  }
  EXPECT_EQ(parseBinFields("x,y,z,_,_").size(), 5u);
}

TEST_F(FileLayouts, BinFilesOfAnotherLayoutThanTheirNameTellsAreRefused)
{
  const std::map<std::size_t, std::string> options = {
      {3, "x,y,z"},
      {4, "x,y,z,intensity"},
      {5, "x,y,z,intensity,ring"},
      {6, "x,y,z,r,g,b or x,y,z,intensity,elongation,time"},
      {7, "x,y,z,_,_,_,_,"}};
  for (const std::string name : {"a.bin", "a.pcd.bin"})
    for (const bool has_order : {true, false})
      for (const auto& [numbers_of_point, fields] : options) {
        SCOPED_TRACE(name + ", " + std::to_string(numbers_of_point));
        const auto points = scanOf(numbers_of_point, has_order);
        const std::string bytes = bytesAs<float>(points);
        const std::string message = refusal(name, bytes);
        if (numbers_of_point == (name == "a.bin" ? 4u : 5u)) {
          EXPECT_EQ(message, "");
          EXPECT_EQ(std::string(cloud_.data.begin(), cloud_.data.end()), bytes);
          EXPECT_EQ(cloud_.width, points.size());
          EXPECT_EQ(cloud_.fields.size(), numbers_of_point);
          EXPECT_EQ(cloud_.fields.back().name,
                    numbers_of_point == 4 ? "intensity" : "ring");
          continue;
        }
        expectPart(message,
                   "its numbers are those of " + std::to_string(numbers_of_point) +
                       " floats");
        expectPart(message, "give --bin-fields " + fields);
      }
}

TEST_F(FileLayouts, RowsThatAlternateAreNotTakenForOnePoint)
{
  // A lidar fires its lasers in the order 0, 8, 1, 9 ...
  std::mt19937 random(7);
  std::vector<std::vector<float>> points;
  for (int column = 0; column < 100; ++column)
    for (int shot = 0; shot < 16; ++shot) {
      const bool is_upper = shot % 2 != 0;
      const float azimuth = 0.06f * static_cast<float>(column);
      const float elevation =
          0.035f * static_cast<float>(shot / 2 + (is_upper ? 0 : -8));
      const float range = (is_upper ? 7.0f : 6.0f) + 0.1f * std::cos(azimuth);
      points.push_back({range * std::cos(azimuth),
                        range * std::sin(azimuth),
                        range * elevation,
                        static_cast<float>(random() % 20 + (is_upper ? 80 : 5)),
                        0.1f * azimuth});
    }
  for (const std::string& message :
       {refusal("a.bin", bytesAs<float>(points)),
        read("a.bin", bytesAs<float>(points), "x,y,z,_,_,_,_,_,_,_").at(0)}) {
    expectPart(message, "its numbers are those of 5 floats a point");
    EXPECT_EQ(message.substr(message.rfind("give")),
              "give --bin-fields x,y,z,intensity,ring");
  }
  // With normals and more, of which none is like x or y.
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].insert(points[i].end(), {0.6f, 0.0f, -0.8f, 3.0f});
    points[i].push_back(static_cast<float>(i));
  }
  EXPECT_EQ(read("a.bin", bytesAs<float>(points), "x,y,z,_,_,_,_,_,_,_"), Remarks());
  expectPart(refusal("a.bin", bytesAs<float>(points)), "or of 10 floats a point, not");
}

TEST_F(FileLayouts, LayoutsOfSmallBinFilesAreFoundOrDoubted)
{
  auto points = scanOf(4, true);
  points.resize(48);
  const Remarks doubts = read("a.bin", bytesAs<float>(points));
  ASSERT_EQ(doubts.size(), 1u);
  expectPart(doubts[0],
             "it is taken as 4 floats a point (x y z reflectance, as KITTI's); its "
             "numbers are too few to tell another layout");
  for (std::vector<float>& point : points)
    point.resize(3);
  expectPart(refusal("a.bin", bytesAs<float>(points)), "give --bin-fields x,y,z");
}

TEST_F(FileLayouts, BinFilesOfOtherNumbersAreRefused)
{
  const auto points = scanOf(4, true);
  std::string labels;
  std::string swapped = bytesAs<float>(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    labels += {static_cast<char>(labels.size() % 20), 0, 1, 0};
    for (std::size_t number = 4 * i; number < 4 * i + 4; ++number)
      std::reverse(&swapped[4 * number], &swapped[4 * number] + 4);
  }
  for (const std::string& bytes : {bytesAs<double>(points), labels})
    expectPart(refusal("a.bin", bytes), "each a little-endian float32");
  EXPECT_EQ(refusal("a.bin", swapped).rfind("its numbers are no lengths", 0), 0u);
  expectPart(refusal("a.bin", bytesAs<double>(points)),
             "as numbers of 64 bits they are: give --bin-fields x:float64,y:float64,"
             "z:float64,intensity:float64");
}

TEST_F(FileLayouts, BinFilesThatDoNotFitAreRefusedWithTheOptionThatFits)
{
  expectPart(refusal("a.bin", scanBytes(12, 5).substr(0, 60)),
             "60 bytes, which is no multiple of 16");
  expectPart(
      refusal("a.bin", scanBytes(12, 5).substr(0, 60)),
      "would fit 3 floats a point (x y z): --bin-fields x,y,z or 5 floats a point (x "
      "y z intensity ring, as nuScenes'): --bin-fields x,y,z,intensity,ring");
  expectPart(
      refusal("a.bin", scanBytes(64, 5), "x,y,z,ring:uint8"),
      "1280 bytes, which is no multiple of 13: --bin-fields has 13 bytes a point");
  expectPart(
      refusal("a.bin", scanBytes(65, 4), "x:float64,y:float64,z:float64,_:float64"),
      "no multiple of 32");
  // What the user gives is read, and doubted.
  const Remarks doubts = read("a.bin", scanBytes(400, 5), "x,y,z,_");
  ASSERT_EQ(doubts.size(), 1u);
  expectPart(doubts[0],
             "--bin-fields may be wrong: its numbers are those of 5 floats a point");
  EXPECT_EQ(read("a.bin", scanBytes(400, 5), "x,y,z,_,_"), Remarks());
  // Two points of a sensor whose rows alternate are alike as one.
  std::string alternating;
  for (std::size_t i = 0; i < 400; ++i)
    for (const float number : {i % 2 == 0 ? 5.0f : -9.0f,
                               0.01f * static_cast<float>(i),
                               i % 2 == 0 ? -30.0f : 30.0f,
                               i % 2 == 0 ? 4.0f : 200.0f,
                               static_cast<float>(i % 2)})
      append(number, alternating);
  expectPart(refusal("a.bin", alternating),
             "those of 5 floats a point (x y z intensity ring, as nuScenes'), or of 10 "
             "floats a point, not of 4 floats a point (x y z reflectance, as KITTI's): "
             "give --bin-fields x,y,z,intensity,ring, or --bin-fields "
             "x,y,z,_,_,_,_,_,_,_, where _ leaves a number out");
  // Numbers of 16 bits.
  std::string small;
  for (std::uint16_t i = 0; i < 256; ++i)
    append(static_cast<std::uint16_t>(i % 50), small);
  expectPart(refusal("a.bin", small, "x,y,z,_"), "its coordinates are no lengths");
}

} // namespace pcl_ext::clouds::test
