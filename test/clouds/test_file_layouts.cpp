// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/bin_file.h"
#include "clouds/cloud_files.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {
namespace test {

namespace {

using Remarks = std::vector<std::string>;

/** \brief Files that other programs write in other ways than PCL. */
class FileLayouts : public ::testing::Test {
protected:
  /** \brief Reads a file of some bytes. */
  Remarks
  read(const std::string& name,
       const std::string& bytes,
       const std::string& bin_fields = "")
  {
    recording::test::writeBytes(folder_ / name, {bytes.begin(), bytes.end()});
    return readCloud(folder_ / name,
                     cloud_,
                     bin_fields.empty() ? std::vector<FileField>()
                                        : parseBinFields(bin_fields));
  }

  /** \brief Why it cannot be read. */
  std::string
  refusal(const std::string& name,
          const std::string& bytes,
          const std::string& bin_fields = "")
  {
    try {
      read(name, bytes, bin_fields);
    }
    catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  /** \brief Numbers of a field, which must have this datatype. */
  template <typename NumberT>
  std::vector<NumberT>
  numbers(const std::string& name, std::uint8_t datatype) const
  {
    std::vector<NumberT> found;
    for (const pcl::PCLPointField& field : cloud_.fields)
      if (field.name == name) {
        EXPECT_EQ(field.datatype, datatype) << name;
        for (std::size_t i = 0; i < std::size_t{cloud_.width} * cloud_.height; ++i) {
          NumberT number;
          std::memcpy(&number,
                      &cloud_.data[i * cloud_.point_step + field.offset],
                      sizeof(number));
          found.push_back(number);
        }
      }
    return found;
  }

  std::vector<float>
  floats(const std::string& name) const
  {
    return numbers<float>(name, pcl::PCLPointField::FLOAT32);
  }

  std::vector<double>
  doubles(const std::string& name) const
  {
    return numbers<double>(name, pcl::PCLPointField::FLOAT64);
  }

  /** \brief The low 24 bits of a packed colour. */
  std::vector<std::uint32_t>
  colours(const std::string& name, std::uint8_t datatype) const
  {
    std::vector<std::uint32_t> bits = numbers<std::uint32_t>(name, datatype);
    for (std::uint32_t& colour : bits)
      colour &= 0xffffff;
    return bits;
  }

  std::string
  fieldNames() const
  {
    std::string names;
    for (const pcl::PCLPointField& field : cloud_.fields)
      names += (names.empty() ? "" : " ") + field.name;
    return names;
  }

  recording::test::TestFolder folder_;
  pcl::PCLPointCloud2 cloud_;
};

template <typename NumberT>
void
append(NumberT number, std::string& bytes)
{
  std::array<char, sizeof(number)> of_number{};
  std::memcpy(of_number.data(), &number, sizeof(number));
  bytes.append(of_number.data(), of_number.size());
}

std::string
pcd(const std::string& fields,
    const std::string& sizes,
    const std::string& types,
    const std::string& counts,
    std::size_t points,
    const std::string& data)
{
  return "VERSION .7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types +
         "\nCOUNT " + counts + "\nWIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) +
         "\nDATA " + data;
}

std::string
ply(const std::string& format, const std::string& properties, const std::string& points)
{
  return "ply\nformat " + format + " 1.0\nelement vertex 2\n" + properties +
         "end_header\n" + points;
}

const std::string xyz = "property float x\nproperty float y\nproperty float z\n";

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

using F = pcl::PCLPointField;
using Floats = std::vector<float>;
using Doubles = std::vector<double>;
using Colours = std::vector<std::uint32_t>;

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

TEST_F(FileLayouts, PackedColoursAreTheSameBitsInEachType)
{
  for (const char* type : {"I", "U", "u", "i"}) {
    SCOPED_TRACE(type);
    const std::string types = std::string("F F F ") + type;
    EXPECT_EQ(read("a.pcd",
                   pcd("x y z rgb",
                       "4 4 4 4",
                       types,
                       "1 1 1 1",
                       4,
                       "ascii\n1 2 3 16711680\n4 5 6 255\n7 8 9 -16776961\n"
                       "1 1 1 4278255360\n")),
              Remarks());
    EXPECT_EQ(colours("rgb", F::UINT32), (Colours{0xff0000, 0xff, 0x0000ff, 0x00ff00}));
    std::string binary = "binary\n";
    for (int i = 0; i < 2; ++i) {
      append(1.0f, binary);
      append(2.0f, binary);
      append(3.0f, binary);
      append(std::int32_t(-16776961 + i), binary);
    }
    read("a.pcd", pcd("x y z rgba", "4 4 4 4", types, "1 1 1 1", 2, binary));
    EXPECT_EQ(numbers<std::uint32_t>("rgba", F::UINT32),
              (Colours{0xff0000ff, 0xff000100}));
  }
}

TEST_F(FileLayouts, FieldsOfCount0AreLeftOut)
{
  // As SUSTechPOINTS' example has them, with gaps of several bytes.
  std::string data = "binary\n";
  for (int i = 0; i < 64; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      append(static_cast<float>(i * (axis + 1)), data);
    data += std::string(4, '\x55');
    append(0.5f * static_cast<float>(i), data);
    append(1600000000.0 + 0.001 * i, data);
    data += std::string(6, '\x55');
    append(static_cast<std::uint16_t>(i % 32), data);
    data += std::string(12, '\x55');
  }
  EXPECT_EQ(read("a.pcd",
                 pcd("x y z _ intensity _ timestamp _ ring _",
                     "4 4 4 1 4 1 8 1 2 1",
                     "F F F U F U F U U U",
                     "1 1 1 4 1 0 1 6 1 12",
                     64,
                     data)),
            Remarks());
  ASSERT_EQ(cloud_.width, 64u);
  EXPECT_EQ(floats("z")[63], 189.0f);
  EXPECT_EQ(floats("intensity")[63], 31.5f);
  EXPECT_EQ(doubles("timestamp")[63], 1600000000.0 + 0.001 * 63);
  EXPECT_EQ(numbers<std::uint16_t>("ring", F::UINT16)[63], 31);
  // In text they have no words.
  read("a.pcd",
       pcd("x time y z", "4 8 4 4", "F F F F", "1 0 1 1", 1, "ascii\n1 2 3\n"));
  EXPECT_EQ(floats("z"), Floats{3.0f});
  EXPECT_NE(refusal("a.pcd", pcd("x y z", "4 4 4", "F F F", "0 0 0", 9, "ascii\n"))
                .find("no fields with numbers"),
            std::string::npos);
}

TEST_F(FileLayouts, NamesAndWordsOfHeadersMayHaveOtherLetters)
{
  const std::string small = "version .7\nfields X Y Z Intensity\nsize 4 4 4 4\n"
                            "type f f f f\ncount 1 1 1 1\nwidth 2\nheight 1\n"
                            "points 2\ndata ASCII\n1 2 3 4\n5 6 7 8\n";
  EXPECT_EQ(read("a.pcd", small), Remarks{"its fields X, Y, Z are taken as x, y, z"});
  EXPECT_EQ(fieldNames(), "x y z Intensity");
  EXPECT_EQ(floats("y"), (Floats{2.0f, 6.0f}));
  read("a.ply",
       ply("ascii",
           "property float X\nproperty float Y\nproperty float Z\n",
           "1 2 3\n4 5 6\n"));
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  EXPECT_EQ(
      read("a.pcd",
           pcd("x y z RGB", "4 4 4 4", "F F F U", "1 1 1 1", 1, "ascii\n1 2 3 255\n")),
      Remarks{"its fields RGB are taken as rgb"});
  // X is another field where there is an x.
  EXPECT_EQ(
      read("a.pcd",
           pcd("x y z X", "4 4 4 4", "F F F F", "1 1 1 1", 1, "ascii\n1 2 3 4\n")),
      Remarks());
  EXPECT_EQ(fieldNames(), "x y z X");
  EXPECT_EQ(floats("x"), Floats{1.0f});
}

TEST_F(FileLayouts, ALineThatPcdHasNotIsNamed)
{
  std::string text = pcd("x y z", "4 4 4", "F F F", "1 1 1", 1, "ascii\n1 2 3\n");
  text.insert(text.find("WIDTH"), "FRAME_ID lidar\n");
  EXPECT_EQ(read("a.pcd", text),
            Remarks{"its header has a line that PCD has not: 'FRAME_ID lidar'"});
  EXPECT_EQ(floats("z"), Floats{3.0f});
}

TEST_F(FileLayouts, NumbersThatPclHasNotAreLeftOut)
{
  std::string data = "binary\n";
  for (const float number : {1.0f, 2.0f, 3.0f})
    append(number, data);
  data += "\x12\x34";
  append(std::uint16_t(9), data);
  EXPECT_EQ(
      read("a.pcd",
           pcd("x y z half ring", "4 4 4 2 2", "F F F F U", "1 1 1 1 1", 1, data)),
      Remarks{"the field 'half' is left out: PCL has no numbers of its SIZE and "
              "TYPE"});
  EXPECT_EQ(numbers<std::uint16_t>("ring", F::UINT16), std::vector<std::uint16_t>{9});
  EXPECT_NE(
      refusal("a.pcd", pcd("x y z", "2 4 4", "F F F", "1 1 1", 1, data)).find("'x'"),
      std::string::npos);
}

TEST_F(FileLayouts, SeparateColoursOfPcdAreColours)
{
  EXPECT_EQ(read("a.pcd",
                 pcd("x y z r g b",
                     "4 4 4 1 1 1",
                     "F F F U U U",
                     "1 1 1 1 1 1",
                     2,
                     "ascii\n1 2 3 255 0 9\n4 5 6 1 2 3\n")),
            Remarks{"its fields r, g, b (uint8) are taken as its colour"});
  EXPECT_EQ(fieldNames(), "x y z rgb");
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff0009, 0x010203}));
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
  // With alpha, in another order, and with a field between them.
  read("a.pcd",
       pcd("A B x y z ring G R",
           "1 1 4 4 4 2 1 1",
           "U U F F F U U U",
           "1 1 1 1 1 1 1 1",
           1,
           "ascii\n128 9 1 2 3 7 0 255\n"));
  EXPECT_EQ(fieldNames(), "rgba x y z ring");
  EXPECT_EQ(numbers<std::uint32_t>("rgba", F::UINT32), Colours{0x80ff0009});
  // Floats: shares, or numbers up to 255; missing points are black.
  EXPECT_EQ(read("a.pcd",
                 pcd("x y z r g b",
                     "4 4 4 4 4 4",
                     "F F F F F F",
                     "1 1 1 1 1 1",
                     2,
                     "ascii\n1 2 3 1 0.5 0\nnan nan nan nan nan nan\n")),
            Remarks{"its fields r, g, b (float32) are taken as its colour, in 8 bits a "
                    "channel, of 0 to 1"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0}));
  read("a.pcd",
       pcd("x y z r g b",
           "4 4 4 4 4 4",
           "F F F F F F",
           "1 1 1 1 1 1",
           1,
           "ascii\n1 2 3 200.4 17 0\n"));
  EXPECT_EQ(colours("rgb", F::FLOAT32), Colours{0xc81100});
}

TEST_F(FileLayouts, OtherFieldsAreNoColours)
{
  const std::pair<const char*, const char*> points[] = {
      {"x y z r g", "1 2 3 4 5"},         // one is missing
      {"x y z r g b", "1 2 3 -4 5 6"},    // negative
      {"x y z r g b", "1 2 3 70000 5 6"}, // too large
      {"x y z r g b", "1 2 3 300.5 5 6"},
      {"x y z rgb r g b", "1 2 3 0 5 6 7"}}; // there is one
  for (const auto& [names, text] : points) {
    SCOPED_TRACE(text);
    const auto count =
        static_cast<std::size_t>(std::count(text, text + std::strlen(text), ' ')) + 1;
    std::string sizes;
    std::string types;
    std::string counts;
    for (std::size_t i = 0; i < count; ++i) {
      sizes += "4 ";
      types += "F ";
      counts += "1 ";
    }
    EXPECT_EQ(read("a.pcd",
                   pcd(names, sizes, types, counts, 1, std::string("ascii\n") + text)),
              Remarks());
    EXPECT_EQ(fieldNames(), names);
  }
}

TEST_F(FileLayouts, ColoursOfPlyMayHaveOtherTypes)
{
  const auto properties = [](const std::string& type) {
    std::string text = xyz;
    for (const char* name : {"red", "green", "blue"})
      text += "property " + type + " " + name + "\n";
    return text;
  };
  EXPECT_EQ(read("a.ply",
                 ply("ascii",
                     properties("uchar"),
                     "1 2 3 255 128 0\n"
                     "1 2 3 1 2 3\n")),
            Remarks());
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x010203}));
  EXPECT_EQ(
      read("a.ply",
           ply("ascii",
               properties("float"),
               "1 2 3 1 .5 0\n"
               "1 2 3 .2 .4 .6\n")),
      Remarks{"its fields red, green, blue (float32) are taken as its colour, in 8 "
              "bits a channel, of 0 to 1"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x336699}));
  EXPECT_EQ(
      read("a.ply",
           ply("ascii",
               properties("ushort"),
               "1 2 3 65535 32768 0\n"
               "1 2 3 257 514 771\n")),
      Remarks{"its fields red, green, blue (uint16) are taken as its colour, in 8 "
              "bits a channel, of 0 to 65535"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0x010203}));
  // 8 bits in wider numbers.
  read("a.ply", ply("ascii", properties("int"), "1 2 3 255 128 0\n1 2 3 1 2 3\n"));
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
  EXPECT_EQ(
      read("a.pcd",
           withCr(pcd("x y z", "4 4 4", "F F F", "1 1 1", 2, "ascii\n1 2 3\n4 5 6\n"))),
      Remarks());
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
    EXPECT_EQ(read("a.ply", ply(format, properties, points)), expected);
    EXPECT_EQ(fieldNames(), "x y z ring");
    EXPECT_EQ(floats("x"), (Floats{1.0f, 4.0f}));
    EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
    EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
    EXPECT_EQ(numbers<std::uint8_t>("ring", F::UINT8),
              (std::vector<std::uint8_t>{7, 8}));
  }
  EXPECT_NE(refusal("a.ply", ply("ascii", properties, "1 9 1 2 2 3 0 7\n4 0 5 6 0 8\n"))
                .find("fewer numbers than it promises"),
            std::string::npos);
  EXPECT_NE(
      refusal("a.ply", ply("binary_little_endian", properties, binary.substr(0, 40)))
          .find("cut off"),
      std::string::npos);
}

TEST_F(FileLayouts, OtherElementsMayHaveAnyProperties)
{
  const std::string header = ply("binary_little_endian", xyz, "");
  const std::string other = "element camera 1\nproperty string name\n";
  const std::string numbers_of_points(24, '\0');
  std::string after = header;
  after.insert(after.find("end_header"), other);
  EXPECT_EQ(read("a.ply", after + numbers_of_points + "\x03top"), Remarks());
  EXPECT_EQ(floats("z"), (Floats{0.0f, 0.0f}));
  std::string before = header;
  before.insert(before.find("element"), other);
  EXPECT_EQ(
      refusal("a.ply", before + "\x03top" + numbers_of_points),
      "before its vertices are elements 'camera' with a property that PLY has not");
  before = ply("ascii", xyz, "");
  before.insert(before.find("element"), other);
  read("a.ply", before + "top\n1 2 3\n4 5 6\n");
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
}

TEST_F(FileLayouts, CommasMayBeBetweenNumbers)
{
  for (const char* points : {"1.5,2,3\n4,5,6\n", "1.5, 2, 3\n4 5 6\n"}) {
    SCOPED_TRACE(points);
    read("a.ply", ply("ascii", xyz, points));
    EXPECT_EQ(floats("x"), (Floats{1.5f, 4.0f}));
    EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  }
  // But not where they may be points.
  EXPECT_NE(refusal("a.ply", ply("ascii", xyz, "1,5 2,5 3,5\n4 5 6\n")).find("'1,5'"),
            std::string::npos);
}

TEST_F(FileLayouts, WholeNumbersMayBeWrittenWithAPoint)
{
  const auto file = [](const std::string& number) {
    return pcd("x y z ring",
               "4 4 4 1",
               "F F F U",
               "1 1 1 1",
               1,
               "ascii\n1 2 3 " + number + "\n");
  };
  for (const char* number : {"7.0", "7", "+7", "7.", ".7e1"}) {
    SCOPED_TRACE(number);
    read("a.pcd", file(number));
    EXPECT_EQ(numbers<std::uint8_t>("ring", F::UINT8), std::vector<std::uint8_t>{7});
  }
  for (const char* number : {"7.5", "256.0", "-1.0", "nan", "1e300", "7.0x"})
    EXPECT_NE(refusal("a.pcd", file(number)).find("is no number of the field 'ring'"),
              std::string::npos)
        << number;
}

TEST_F(FileLayouts, CoordinatesMayBeWholeNumbers)
{
  const std::string properties = "property short x\nproperty short y\n"
                                 "property uchar z\nproperty bool is_edge\n";
  EXPECT_EQ(read("a.ply", ply("ascii", properties, "-300 2 3 1\n4 5 255 0\n")),
            Remarks{"its coordinates x, y and z (int16, int16, uint8) are taken as "
                    "float32, metres"});
  EXPECT_EQ(floats("x"), (Floats{-300.0f, 4.0f}));
  EXPECT_EQ(floats("z"), (Floats{3.0f, 255.0f}));
  EXPECT_EQ(numbers<std::uint8_t>("is_edge", F::UINT8),
            (std::vector<std::uint8_t>{1, 0}));
  // Floats have not all numbers of 32 bits.
  read("a.pcd",
       pcd("x y z", "4 4 4", "I U I", "1 1 1", 1, "ascii\n-16777217 16777219 0\n"));
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

TEST_F(FileLayouts, IntegersOf64BitsAreKeptAsNumbersThatFramesHave)
{
  const auto file = [](const std::string& times) {
    return pcd(
        "x y z stamp", "4 4 4 8", "F F F U", "1 1 1 1", 2, "ascii\n1 2 3 " + times);
  };
  EXPECT_EQ(read("a.pcd", file("1700000000000001\n4 5 6 9007199254740991\n")),
            Remarks{"its field stamp (uint64) is taken as float64, which has the same "
                    "values"});
  EXPECT_EQ(doubles("stamp"), (Doubles{1700000000000001.0, 9007199254740991.0}));
  // Nanoseconds since 1970.
  EXPECT_EQ(
      read("a.pcd", file("1532402927647951001\n4 5 6 7\n")),
      Remarks{"its field stamp (uint64) is taken as two uint32 with the same bits, "
              "as float64 has not all of its values"});
  ASSERT_EQ(cloud_.fields.back().count, 2u);
  EXPECT_EQ(numbers<std::uint64_t>("stamp", F::UINT32),
            (std::vector<std::uint64_t>{1532402927647951001u, 7u}));
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  std::string data = "binary\n";
  for (int i = 0; i < 2; ++i) {
    append(std::int64_t(-5 - i), data);
    append(std::int64_t(1) << 53, data);
    for (const float number : {1.0f, 2.0f, 3.0f})
      append(number, data);
  }
  read("a.pcd", pcd("pair x y z", "8 4 4 4", "I F F F", "2 1 1 1", 2, data));
  EXPECT_EQ(doubles("pair"), (Doubles{-5.0, -6.0}));
  double second = 0.0;
  std::memcpy(&second, &cloud_.data[cloud_.point_step + 8], sizeof(second));
  EXPECT_EQ(second, 9007199254740992.0);
}

TEST_F(FileLayouts, CompressedPointsHaveTheGapsOrNot)
{
  // LZF of literal bytes: runs of up to 32, each after its length less one.
  const auto packed = [](const std::string& bytes) {
    std::string literals;
    for (std::size_t at = 0; at < bytes.size(); at += 32) {
      const std::string run = bytes.substr(at, 32);
      literals += static_cast<char>(run.size() - 1) + run;
    }
    std::string data = "binary_compressed\n";
    append(static_cast<std::uint32_t>(literals.size()), data);
    append(static_cast<std::uint32_t>(bytes.size()), data);
    return data + literals;
  };
  for (const bool has_gap : {true, false}) {
    SCOPED_TRACE(has_gap);
    std::string columns;
    append(1.0f, columns);
    append(2.0f, columns);
    if (has_gap)
      columns += std::string(6, '\x55');
    for (const float number : {3.0f, 4.0f, 5.0f, 6.0f})
      append(number, columns);
    read("a.pcd", pcd("x _ y z", "4 1 4 4", "F U F F", "1 3 1 1", 2, packed(columns)));
    EXPECT_EQ(floats("x"), (Floats{1.0f, 2.0f}));
    EXPECT_EQ(floats("y"), (Floats{3.0f, 4.0f}));
    EXPECT_EQ(floats("z"), (Floats{5.0f, 6.0f}));
  }
}

TEST_F(FileLayouts, DamagedOnesAreRefusedOrReadWhole)
{
  std::string list = ply("binary_big_endian",
                         xyz + "property list uchar float w\nproperty ushort red\n"
                               "property ushort green\nproperty ushort blue\n",
                         "");
  list += std::string(12, '\x3f') + '\1' + std::string(10, '\x3f') +
          std::string(12, '\x3e') + '\0' + std::string(6, '\x3e');
  std::string data = "binary\n" + std::string(2 * 28, '\x11');
  const std::pair<std::string, std::string> files[] = {
      {"a.ply", list},
      {"b.ply",
       ply("ascii",
           "property short x\nproperty int y\nproperty bool z\n"
           "property list uchar int w\n",
           "1 2 0 2 3 4\n4 5 1 0\n")},
      {"c.pcd",
       pcd("X Y Z r g b stamp half _ gone",
           "2 4 4 1 1 1 8 2 1 4",
           "I F F U U U U F U F",
           "1 1 1 1 1 1 1 1 5 0",
           2,
           data)},
      {"d.pcd",
       pcd("x y z rgb stamp",
           "4 4 4 4 8",
           "F F F I U",
           "1 1 1 1 2",
           2,
           "ascii\r1 2 3 4 5 6\r7 8 9 -1 2 3\r")}};
  std::mt19937 random(11);
  std::size_t refused = 0;
  std::size_t read_whole = 0;
  for (const auto& [name, whole] : files)
    for (int i = 0; i < 1500; ++i) {
      std::string bytes = whole;
      for (std::size_t changes = random() % 4; changes > 0; --changes)
        bytes[random() % bytes.size()] =
            static_cast<char>(random() % 2 == 0 ? random() : '0' + random() % 10);
      if (random() % 4 == 0)
        bytes.resize(random() % bytes.size());
      const std::string message = refusal(name, bytes);
      (message.empty() ? read_whole : refused) += 1;
      if (message.empty()) {
        EXPECT_EQ(cloud_.data.size(),
                  std::size_t{cloud_.width} * cloud_.height * cloud_.point_step);
        EXPECT_LE(cloud_.data.size(), 176 * bytes.size());
      }
    }
  EXPECT_GT(refused, 1000u);
  EXPECT_GT(read_whole, 1000u);
}

} // namespace test
} // namespace clouds
} // namespace pcl_ext
