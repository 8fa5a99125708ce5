// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_layouts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::clouds::test {

TEST_F(FileLayouts, PackedColoursAreTheSameBitsInEachType)
{
  for (const std::string type : {"I4", "U4", "u4", "i4"}) {
    SCOPED_TRACE(type);
    EXPECT_EQ(readPcd("x y z rgb:" + type,
                      4,
                      "ascii\n1 2 3 16711680\n4 5 6 255\n7 8 9 -16776961\n"
                      "1 1 1 4278255360\n"),
              Remarks());
    EXPECT_EQ(colours("rgb", F::UINT32), (Colours{0xff0000, 0xff, 0x0000ff, 0x00ff00}));
    std::string binary = "binary\n";
    for (int i = 0; i < 2; ++i) {
      for (const float number : {1.0f, 2.0f, 3.0f})
        append(number, binary);
      append(std::int32_t(-16776961 + i), binary);
    }
    readPcd("x y z rgba:" + type, 2, binary);
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
  EXPECT_EQ(readPcd("x y z _:U1x4 intensity _:U1x0 timestamp:F8 _:U1x6 ring:U2 _:U1x12",
                    64,
                    data),
            Remarks());
  ASSERT_EQ(cloud_.width, 64u);
  EXPECT_EQ(floats("z")[63], 189.0f);
  EXPECT_EQ(floats("intensity")[63], 31.5f);
  EXPECT_EQ(doubles("timestamp")[63], 1600000000.0 + 0.001 * 63);
  EXPECT_EQ(numbers<std::uint16_t>("ring", F::UINT16)[63], 31);
  // In text they have no words.
  readPcd("x time:F8x0 y z", 1, "ascii\n1 2 3\n");
  EXPECT_EQ(floats("z"), Floats{3.0f});
  expectPart(refusal("a.pcd", pcd("x:F4x0 y:F4x0 z:F4x0", 9, "ascii\n")),
             "no fields with numbers");
}

TEST_F(FileLayouts, NamesAndWordsOfHeadersMayHaveOtherLetters)
{
  const std::string small = "version .7\nfields X Y Z Intensity\nsize 4 4 4 4\n"
                            "type f f f f\ncount 1 1 1 1\nwidth 2\nheight 1\n"
                            "points 2\ndata ASCII\n1 2 3 4\n5 6 7 8\n";
  EXPECT_EQ(read("a.pcd", small), Remarks{"its fields X, Y, Z are taken as x, y, z"});
  EXPECT_EQ(fieldNames(), "x y z Intensity");
  EXPECT_EQ(floats("y"), (Floats{2.0f, 6.0f}));
  readPly("ascii",
          "property float X\nproperty float Y\nproperty float Z\n",
          "1 2 3\n4 5 6\n");
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  EXPECT_EQ(readPcd("x y z RGB:U4", 1, "ascii\n1 2 3 255\n"),
            Remarks{"its fields RGB are taken as rgb"});
  // X is another field where there is an x.
  EXPECT_EQ(readPcd("x y z X", 1, "ascii\n1 2 3 4\n"), Remarks());
  EXPECT_EQ(fieldNames(), "x y z X");
  EXPECT_EQ(floats("x"), Floats{1.0f});
}

TEST_F(FileLayouts, APcdFileMayHaveAByteOrderMark)
{
  EXPECT_EQ(read("a.pcd", "\xef\xbb\xbf# .PCD\n" + pcd("x y z", 1, "ascii\n1 2 3\n")),
            Remarks());
  EXPECT_EQ(floats("z"), Floats{3.0f});
}

TEST_F(FileLayouts, ALineThatPcdHasNotIsNamed)
{
  std::string text = pcd("x y z", 1, "ascii\n1 2 3\n");
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
  EXPECT_EQ(readPcd("x y z half:F2 ring:U2", 1, data),
            Remarks{"the field 'half' is left out: PCL has no numbers of its SIZE and "
                    "TYPE"});
  EXPECT_EQ(numbers<std::uint16_t>("ring", F::UINT16), std::vector<std::uint16_t>{9});
  expectPart(refusal("a.pcd", pcd("x:F2 y z", 1, data)), "'x'");
  EXPECT_EQ(
      readPcd("x y z valid:B1x2 ring:U2", 1, "ascii\n1 2 3 true - 9\n"),
      Remarks{
          "the field 'valid' is left out: PCL has no numbers of its SIZE and TYPE"});
  EXPECT_EQ(numbers<std::uint16_t>("ring", F::UINT16), std::vector<std::uint16_t>{9});
}

TEST_F(FileLayouts, OddLinesOfHeadersAreSaid)
{
  std::string text = pcd("x y z", 1, "ascii\n1 2 3\n");
  text.replace(text.find(" 1 0 0 0"), 8, "");
  EXPECT_EQ(read("a.pcd", text),
            Remarks{"its VIEWPOINT is left out: it has not 7 numbers"});
  // PCL reads it as one row.
  text = pcd("x y z", 2, "ascii\n1 2 3\n4 5 6\n");
  text.replace(text.find("HEIGHT 1"), 8, "HEIGHT 0");
  EXPECT_EQ(read("a.pcd", text), Remarks());
  EXPECT_EQ(cloud_.height, 1u);
  EXPECT_EQ(floats("z"), (Floats{3.0f, 6.0f}));
  EXPECT_EQ(
      readPcd("x y z t t", 1, "ascii\n1 2 3 4 5\n"),
      Remarks{"several of its fields are named 't'; files have 't_' for the second"});
}

TEST_F(FileLayouts, SeparateColoursOfPcdAreColours)
{
  EXPECT_EQ(readPcd("x y z r:U1 g:U1 b:U1", 2, "ascii\n1 2 3 255 0 9\n4 5 6 1 2 3\n"),
            Remarks{"its fields r, g, b (uint8) are taken as its colour"});
  EXPECT_EQ(fieldNames(), "x y z rgb");
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff0009, 0x010203}));
  EXPECT_EQ(floats("y"), (Floats{2.0f, 5.0f}));
  // With alpha, in another order, and with a field between them.
  readPcd("A:U1 B:U1 x y z ring:U2 G:U1 R:U1", 1, "ascii\n128 9 1 2 3 7 0 255\n");
  EXPECT_EQ(fieldNames(), "rgba x y z ring");
  EXPECT_EQ(numbers<std::uint32_t>("rgba", F::UINT32), Colours{0x80ff0009});
  // Floats: shares, or numbers up to 255; missing points are black.
  EXPECT_EQ(
      readPcd("x y z r g b", 2, "ascii\n1 2 3 1 0.5 0\nnan nan nan nan nan nan\n"),
      Remarks{"its fields r, g, b (float32) are taken as its colour, in 8 bits a "
              "channel, of 0 to 1"});
  EXPECT_EQ(colours("rgb", F::FLOAT32), (Colours{0xff8000, 0}));
  readPcd("x y z r g b", 1, "ascii\n1 2 3 200.4 17 0\n");
  EXPECT_EQ(colours("rgb", F::FLOAT32), Colours{0xc81100});
}

TEST_F(FileLayouts, ColoursOfAStreamHaveOneScale)
{
  UsualFields of_stream;
  const auto read_next = [&](const std::string& type, const std::string& values) {
    recording::test::writeText(folder_ / "a.pcd",
                               pcd("x y z r:" + type + " g:" + type + " b:" + type,
                                   1,
                                   "ascii\n1 2 3 " + values));
    return readCloud(folder_ / "a.pcd", cloud_, {}, &of_stream).size();
  };
  read_next("F4", "0 0 0\n"); // which tells nothing
  EXPECT_EQ(read_next("F4", "0.9 0.5 1.00001\n"), 1u);
  EXPECT_EQ(colours("rgb", F::FLOAT32), Colours{0xe580ff});
  EXPECT_EQ(read_next("F4", "1 0.5 1.5\n"), 2u); // which is said
  EXPECT_EQ(colours("rgb", F::FLOAT32), Colours{0xff80ff});
  of_stream = UsualFields();
  read_next("U2", "65535 0 257\n");
  read_next("U2", "255 0 129\n"); // dark
  EXPECT_EQ(colours("rgb", F::FLOAT32), Colours{0x010001});
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
    EXPECT_EQ(readPcd(names, 1, std::string("ascii\n") + text), Remarks());
    EXPECT_EQ(fieldNames(), names);
  }
}

TEST_F(FileLayouts, WholeNumbersMayBeWrittenWithAPoint)
{
  const auto file = [](const std::string& number) {
    return pcd("x y z ring:U1", 1, "ascii\n1 2 3 " + number + "\n");
  };
  for (const char* number : {"7.0", "7", "+7", "7.", ".7e1"}) {
    SCOPED_TRACE(number);
    read("a.pcd", file(number));
    EXPECT_EQ(numbers<std::uint8_t>("ring", F::UINT8), std::vector<std::uint8_t>{7});
  }
  for (const char* number : {"7.5", "256.0", "-1.0", "nan", "1e300", "7.0x"})
    expectPart(refusal("a.pcd", file(number)),
               "'" + std::string(number) + "' is no number of the field 'ring'");
}

TEST_F(FileLayouts, IntegersOf64BitsAreKeptAsNumbersThatFramesHave)
{
  const auto file = [](const std::string& times) {
    return pcd("x y z stamp:U8", 2, "ascii\n1 2 3 " + times);
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
  readPcd("pair:I8x2 x y z", 2, data);
  EXPECT_EQ(doubles("pair"), (Doubles{-5.0, -6.0}));
  double second = 0.0;
  std::memcpy(&second, &cloud_.data[cloud_.point_step + 8], sizeof(second));
  EXPECT_EQ(second, 9007199254740992.0);
}

TEST_F(FileLayouts, IntegersOf64BitsDependOnWhatBecomesOfThem)
{
  const auto read_next = [this](const std::string& values, UsualFields& of_stream) {
    recording::test::writeText(folder_ / "a.pcd",
                               pcd("x y z t:I8", 2, "ascii\n1 2 3 " + values));
    return readCloud(folder_ / "a.pcd", cloud_, {}, &of_stream);
  };
  const auto read_as = [&](const std::string& values, const LongIntegers& integers) {
    UsualFields of_stream(integers);
    return read_next(values, of_stream);
  };
  const auto kept = [](std::vector<std::string> with_step, bool one_of_several) {
    LongIntegers integers;
    integers.with_step = std::move(with_step);
    integers.one_of_several = one_of_several;
    return integers;
  };
  const std::string large = "1700000000000001\n4 5 6 -7\n";
  const std::string nanoseconds = "1700000000000000123\n4 5 6 7\n";
  // Where one of several values is kept, they are integers.
  EXPECT_EQ(
      read_as("1\n4 5 6 -7\n", kept({}, true)),
      Remarks{"its field t (int64) is taken as int32, which has the same values"});
  EXPECT_EQ(numbers<std::int32_t>("t", F::INT32), (std::vector<std::int32_t>{1, -7}));
  read_as("1\n4 5 6 4294967295\n", kept({}, true));
  EXPECT_EQ(numbers<std::uint32_t>("t", F::UINT32), (Colours{1, 4294967295}));
  EXPECT_EQ(read_as(large, kept({}, true)),
            Remarks{"its field t (int64) is taken as two uint32 with the same bits, as "
                    "uint32 has not all of its values"});
  EXPECT_EQ(numbers<std::int64_t>("t", F::UINT32),
            (std::vector<std::int64_t>{1700000000000001, -7}));
  // With a step they must be one number.
  for (const bool one_of_several : {false, true}) {
    read_as(large, kept({"t"}, one_of_several));
    EXPECT_EQ(doubles("t"), (Doubles{1700000000000001.0, -7.0}));
    EXPECT_THROW(read_as(nanoseconds, kept({"t"}, one_of_several)), FieldRefusal);
    read_as("1\n4 5 6 2\n", kept({"t"}, one_of_several));
    EXPECT_EQ(doubles("t"), (Doubles{1.0, 2.0}));
  }
  EXPECT_NO_THROW(read_as(nanoseconds, kept({"ring"}, false)));
  // Values that go back and forth change the type of a stream's field only once.
  UsualFields of_stream(kept({}, true));
  read_next("2147483647\n4 5 6 1\n", of_stream);
  EXPECT_EQ(cloud_.fields.back().datatype, F::INT32);
  for (const char* values : {"2147483648\n4 5 6 1\n", "2147483647\n4 5 6 1\n"}) {
    read_next(values, of_stream);
    EXPECT_EQ(cloud_.fields.back().datatype, F::UINT32);
    EXPECT_EQ(cloud_.fields.back().count, 1u);
  }
  for (const char* values : {"-1\n4 5 6 1\n", "3\n4 5 6 1\n"}) {
    read_next(values, of_stream);
    EXPECT_EQ(cloud_.fields.back().count, 2u);
  }
  EXPECT_EQ(numbers<std::int64_t>("t", F::UINT32), (std::vector<std::int64_t>{3, 1}));
  of_stream = UsualFields();
  read_next(nanoseconds, of_stream);
  read_next("1\n4 5 6 1\n", of_stream);
  EXPECT_EQ(cloud_.fields.back().count, 2u);
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
    readPcd("x _:U1x3 y z", 2, packed(columns));
    EXPECT_EQ(floats("x"), (Floats{1.0f, 2.0f}));
    EXPECT_EQ(floats("y"), (Floats{3.0f, 4.0f}));
    EXPECT_EQ(floats("z"), (Floats{5.0f, 6.0f}));
  }
}

} // namespace pcl_ext::clouds::test
