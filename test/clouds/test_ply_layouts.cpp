// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_layouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::clouds::test {

TEST_F(FileLayouts, ColoursOfPlyMayHaveOtherTypes)
{
  const auto properties = [](const std::string& type) {
    std::string text = xyz;
    for (const char* name : {"red", "green", "blue"})
      text += "property " + type + " " + name + "\n";
    return text;
  };
  EXPECT_EQ(readPly("ascii",
                    properties("uchar"),
                    "1 2 3 255 128 0\n"
                    "1 2 3 1 2 3\n"),
            Remarks());
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x010203}));
  EXPECT_EQ(
      readPly("ascii",
              properties("float"),
              "1 2 3 1 .5 0\n"
              "1 2 3 .2 .4 .6\n"),
      Remarks{"its fields red, green, blue (float32) are taken as its colour, in 8 "
              "bits a channel, of 0 to 1"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x336699}));
  EXPECT_EQ(
      readPly("ascii",
              properties("ushort"),
              "1 2 3 65535 32768 0\n"
              "1 2 3 257 514 771\n"),
      Remarks{"its fields red, green, blue (uint16) are taken as its colour, in 8 "
              "bits a channel, of 0 to 65535"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x010203}));
  // 8 bits in wider numbers.
  readPly("ascii", properties("int"), "1 2 3 255 128 0\n1 2 3 1 2 3\n");
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x010203}));
}

TEST_F(FileLayouts, LinesMayEndWithCrAlone)
{
  const auto withCr = [](std::string text) {
    std::replace(text.begin(), text.end(), '\n', '\r');
    return text;
  };
  EXPECT_EQ(read("a.ply", withCr(ply("ascii", xyz, "1 2 3\n4 5 6\n"))), Remarks());
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
  EXPECT_EQ(read("a.pcd", withCr(pcd("x y z", 2, "ascii\n1 2 3\n4 5 6\n"))), Remarks());
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
  // The first byte of the numbers is that of LF, or of CR.
  for (const char first : {'\n', '\r'}) {
    std::string numbers_of_points(24, '\0');
    float x = 3.0f;
    std::memcpy(numbers_of_points.data(), &x, sizeof(x));
    numbers_of_points[0] = first;
    std::memcpy(&x, numbers_of_points.data(), sizeof(x));
    for (const bool has_cr : {true, false}) {
      const std::string header = ply("binary_little_endian", xyz, "");
      read("a.ply", (has_cr ? withCr(header) : header) + numbers_of_points);
      EXPECT_EQ(floats("x"), (Floats{x, 0.0f}));
    }
  }
}

TEST_F(FileLayouts, ListsOfVerticesAreLeftOut)
{
  const std::string properties =
      "property float x\nproperty list uchar int seen_by\nproperty float y\n"
      "property float z\nproperty list ushort float weights\nproperty uchar ring\n";
  const Remarks expected = {
      "the property 'seen_by' of vertices is left out: it is a list",
      "the property 'weights' of vertices is left out: it is a list"};
  std::string binary;
  append(1.0f, binary);
  binary += std::string("\2\1\0\0\0\2\0\0\0", 9);
  append(2.0f, binary);
  append(3.0f, binary);
  binary += std::string("\0\0\7", 3);
  append(4.0f, binary);
  binary += '\0';
  append(5.0f, binary);
  append(6.0f, binary);
  binary += std::string("\1\0", 2);
  append(0.5f, binary);
  binary += '\x8';
  for (const auto& [format, points] :
       {std::pair<const char*, std::string>{"ascii",
                                            "1 2 1 2 2 3 0 7\n4 0 5 6 1 .5 8\n"},
        {"binary_little_endian", binary}}) {
    SCOPED_TRACE(format);
    EXPECT_EQ(readPly(format, properties, points), expected);
    EXPECT_EQ(fieldNames(), "x y z ring");
    EXPECT_EQ(floats("x"), (Floats{1.0f, 4.0f}));
    EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
    EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
    EXPECT_EQ(numbers<std::uint8_t>("ring", F::UINT8),
              (std::vector<std::uint8_t>{7, 8}));
  }
  expectPart(
      refusal("a.ply", ply("ascii", properties, "1 9 1 2 2 3 0 7\n4 0 5 6 0 8\n")),
      "fewer numbers than it promises");
  expectPart(
      refusal("a.ply", ply("binary_little_endian", properties, binary.substr(0, 40))),
      "cut off");
}

TEST_F(FileLayouts, OtherElementsMayHaveAnyProperties)
{
  const std::string header = ply("binary_little_endian", xyz, "");
  const std::string other = "element strip 1\nproperty string name\n";
  const std::string numbers_of_points(24, '\0');
  std::string after = header;
  after.insert(after.find("end_header"), other);
  EXPECT_EQ(read("a.ply", after + numbers_of_points + "\x03top"),
            Remarks{"its elements 'strip' (1) are left out"});
  EXPECT_EQ(floats("z"), (Floats{0.0f, 0.0f}));
  std::string before = header;
  before.insert(before.find("element"), other);
  EXPECT_EQ(
      refusal("a.ply", before + "\x03top" + numbers_of_points),
      "before its vertices are elements 'strip' with a property that PLY has not");
  before = ply("ascii", xyz, "");
  before.insert(before.find("element"), other);
  read("a.ply", before + "top\n1 2 3\n4 5 6\n");
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
}

TEST_F(FileLayouts, CommasMayBeBetweenNumbers)
{
  for (const char* points : {"1.5,2,3\n4,5,6\n", "1.5, 2, 3\n4 5 6\n"}) {
    SCOPED_TRACE(points);
    readPly("ascii", xyz, points);
    EXPECT_EQ(floats("x"), (Floats{1.5f, 4.0f}));
    EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  }
  // But not where they may be points.
  expectPart(refusal("a.ply", ply("ascii", xyz, "1,5 2,5 3,5\n4 5 6\n")), "'1,5'");
}

TEST_F(FileLayouts, CoordinatesMayBeWholeNumbers)
{
  const std::string properties = "property short x\nproperty short y\n"
                                 "property uchar z\nproperty bool is_edge\n";
  EXPECT_EQ(readPly("ascii", properties, "-300 2 3 1\n4 5 255 0\n"),
            Remarks{"its coordinates x, y and z (int16, int16, uint8) are taken as "
                    "float32, metres"});
  EXPECT_EQ(floats("x"), (Floats{-300.0f, 4.0f}));
  EXPECT_EQ(floats("z"), (Floats{3.0f, 255.0f}));
  EXPECT_EQ(numbers<std::uint8_t>("is_edge", F::UINT8),
            (std::vector<std::uint8_t>{1, 0}));
  // Floats have not all numbers of 32 bits.
  readPcd("x:I4 y:U4 z:I4", 1, "ascii\n-16777217 16777219 0\n");
  EXPECT_EQ(doubles("x"), Doubles{-16777217.0});
  EXPECT_EQ(doubles("y"), Doubles{16777219.0});
  // Whole numbers cannot tell a missing point of an image.
  const std::string image =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n"
      "element vertex 1\n" +
      properties +
      "element range_grid 2\nproperty list uchar int vertex_indices\nend_header\n"
      "7 8 9 1\n0\n1 0\n";
  EXPECT_EQ(read("a.ply", image).front().rfind("its rows and columns are left out", 0),
            0u);
  EXPECT_EQ(floats("x"), Floats{7.0f});
}

TEST_F(FileLayouts, LinesBetweenPointsMayBeBlank)
{
  const std::string points = "\n1 2 3\n \t\r\n\n4 5 6\n";
  EXPECT_EQ(readPly("ascii", xyz, points), Remarks());
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
  EXPECT_EQ(readPcd("x y z", 2, "ascii\n" + points), Remarks());
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
}

TEST_F(FileLayouts, NumbersAreReadInAllWaysOfWriting)
{
  const std::string odd = "+1 -.5 2e-1\r\n\nnan -nan inf\n\t1.  0 -0\n\n \n";
  readPcd("x y z", 3, "ascii\n" + odd);
  EXPECT_EQ(floats("x")[0], 1.0f);
  EXPECT_EQ(floats("x")[2], 1.0f);
  EXPECT_EQ(floats("y")[0], -0.5f);
  EXPECT_EQ(floats("z")[0], 0.2f);
  EXPECT_TRUE(std::isnan(floats("x")[1]) && std::isnan(floats("y")[1]));
  EXPECT_EQ(floats("z")[1], std::numeric_limits<float>::infinity());
}

} // namespace pcl_ext::clouds::test
