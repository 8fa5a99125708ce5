// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_layouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {
namespace test {

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

} // namespace

TEST_F(FileLayouts, NuScenesNameHasFiveNumbersAPoint)
{
  EXPECT_EQ(read("scan__LIDAR_TOP__1532402927647951.pcd.bin", scanBytes(64, 5)),
            Remarks());
  EXPECT_EQ(fieldNames(), "x y z intensity ring");
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
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(parseBinFields("x,y,z,_,_").size(), 5u);
}

TEST_F(FileLayouts, BinFilesThatDoNotFitAreRefusedWithTheOptionThatFits)
{
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const std::pair<std::size_t, const char*> layouts[] = {
      {3, "x,y,z,"},
      {5, "x,y,z,intensity,ring,"},
      {6, "x,y,z,r,g,b or x,y,z,intensity,elongation,time,"},
      {7, "x,y,z,_,_,_,_,"}};
  for (const auto& [numbers_of_point, fields] : layouts) {
    std::string bytes;
    for (std::size_t i = 0; i < 400; ++i)
      bytes += scanBytes(i + 1, std::max<std::size_t>(numbers_of_point, 4))
                   .substr(i * std::max<std::size_t>(numbers_of_point, 4) * 4,
                           numbers_of_point * 4);
    expect(refusal("a.bin", bytes), std::string("give --bin-fields ") + fields);
  }
  expect(refusal("a.bin", scanBytes(12, 5).substr(0, 60)),
         "60 bytes, which is no multiple of 16");
  expect(refusal("a.bin", scanBytes(12, 5).substr(0, 60)),
         "x y z intensity ring, as nuScenes'): --bin-fields x,y,z,intensity,ring");
  expect(refusal("a.bin", scanBytes(64, 5), "x,y,z,ring:uint8"),
         "1280 bytes, which is no multiple of 13: --bin-fields has 13 bytes a point");
  expect(refusal("a.bin", scanBytes(65, 4), "x:float64,y:float64,z:float64,_:float64"),
         "no multiple of 32");
  // What the user gives is read, and doubted.
  const Remarks doubts = read("a.bin", scanBytes(400, 5), "x,y,z,_");
  ASSERT_EQ(doubts.size(), 1u);
  expect(doubts[0],
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
  expect(refusal("a.bin", alternating),
         "give --bin-fields x,y,z,_,_,_,_,_,_,_, where _ leaves a number out, or "
         "--bin-fields x,y,z,intensity,ring");
  // Numbers of 16 bits.
  std::string small;
  for (std::uint16_t i = 0; i < 256; ++i)
    append(static_cast<std::uint16_t>(i % 50), small);
  expect(refusal("a.bin", small, "x,y,z,_"), "its coordinates are no lengths");
}

} // namespace test
} // namespace clouds
} // namespace pcl_ext
