// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief SensorPreprocessor on PCLPointCloud2: which layouts are read, and why others are
 * refused. The fuzz target cloud_layouts has any layout, without the words of messages.
 */
#include "support/message_layouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::test;

using Change = std::function<void(PCLPointCloud2&)>;

/** \brief Fields by name, type and offset: "x f32 0 y f32 4". */
std::vector<PCLPointField>
fieldsOf(const std::string& text)
{
  const std::vector<std::string> types = {
      "", "i8", "u8", "i16", "u16", "i32", "u32", "f32", "f64", "i64", "u64"};
  std::vector<PCLPointField> fields;
  std::istringstream words(text);
  std::string type;
  for (PCLPointField field; words >> field.name >> type >> field.offset;) {
    const auto found = std::find(types.begin(), types.end(), type);
    field.datatype = static_cast<std::uint8_t>(found - types.begin());
    field.count = 1;
    fields.push_back(field);
  }
  return fields;
}

struct Layout {
  const char* what;
  const char* fields;
  std::uint32_t point_step;
  std::uint32_t width;
  std::uint32_t height = 1;
  std::uint32_t row_padding = 0;
};

TEST(CloudLayout, AllOfTheseAreRead)
{
  const char* const usual = "x f32 0 y f32 4 z f32 8 intensity f32 16";
  for (const Layout& layout : std::vector<Layout>{
           {"gaps", "intensity f32 0 z f32 9 ring u16 13 x f32 17 y f32 27", 37, 11},
           {"any order", "y f32 27 intensity u8 31 z f32 1 x f32 5", 32, 9},
           {"doubles", "z f64 3 x f64 11 y f64 20 intensity i16 28", 31, 13, 3, 5},
           {"rows", usual, 24, 6, 5},
           {"rows and a byte", usual, 24, 6, 5, 1},
           {"a point in a row", usual, 24, 1, 30, 1000},
           {"no points", usual, 24, 0}}) {
    SCOPED_TRACE(layout.what);
    expectAllRead(makeMessage(fieldsOf(layout.fields),
                              layout.point_step,
                              layout.width,
                              layout.height,
                              layout.row_padding));
  }
  // The padding of the last row may be missing.
  PCLPointCloud2 message =
      makeMessage(fieldsOf("x f32 0 y f32 4 z f32 8 intensity f32 12"), 16, 4, 3, 9);
  message.data.resize(message.data.size() - 9);
  expectAllRead(message);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows"});
  // Where rows follow each other their step does not matter.
  for (const std::uint32_t height : {1u, 3u})
    for (const std::uint32_t row_step : {0u, 1u, 63u, 65u, 640u * 16u, 4294967295u}) {
      message = plainMessage(4, height);
      message.row_step = row_step;
      expectAllRead(message);
      EXPECT_EQ(pcl_ext::rowStep(message), 64u);
    }
  // Nor does that of one row with more bytes behind it.
  message = plainMessage(4, 1);
  message.row_step = 0;
  message.data.push_back(0);
  expectAllRead(message);
}

struct Limits {
  std::uint8_t datatype;
  double lowest;
  double highest;
};

const Limits all_limits[] = {{PCLPointField::INT8, -128.0, 127.0},
                             {PCLPointField::UINT8, 0.0, 255.0},
                             {PCLPointField::INT16, -32768.0, 32767.0},
                             {PCLPointField::UINT16, 0.0, 65535.0},
                             {PCLPointField::INT32, -0x1p31, 2147483647.0},
                             {PCLPointField::UINT32, 0.0, 4294967295.0},
                             {9, -0x1p63, 0x1p53},
                             {10, 0.0, 0x1p53},
                             {PCLPointField::FLOAT32, -3e38, 3e38},
                             {PCLPointField::FLOAT64, -1.0 / 3.0, 3e38}};

TEST(CloudLayout, NumbersMayBeOfAnyDatatypesAndAtTheirEnds)
{
  for (const Limits& x : all_limits)
    for (const Limits& z : all_limits) {
      SCOPED_TRACE(std::to_string(x.datatype) + " and " + std::to_string(z.datatype));
      const auto is_long = [](std::uint8_t type) { return type >= 8; };
      // Where they fit as close to each other as floats that are read at once.
      const std::uint32_t gap = is_long(x.datatype) || is_long(z.datatype) ? 8 : 4;
      PCLPointCloud2 message = makeMessage({makeField("x", 0, x.datatype),
                                            makeField("y", gap, PCLPointField::FLOAT32),
                                            makeField("z", 2 * gap, z.datatype),
                                            makeField("intensity", 25, z.datatype)},
                                           33,
                                           4);
      for (std::size_t point = 0; point < 4; ++point) {
        std::uint8_t* const bytes = &message.data[33 * point];
        writeNumber(bytes, x.datatype, point % 2 == 0 ? x.lowest : x.highest);
        writeNumber(bytes + gap, PCLPointField::FLOAT32, 0.1);
        for (const std::uint32_t offset : {2 * gap, 25u})
          writeNumber(bytes + offset, z.datatype, point < 2 ? z.lowest : z.highest);
      }
      Output output;
      ASSERT_TRUE(processNative(message, output).ok());
      ASSERT_EQ(output.size(), 4u);
      for (std::size_t point = 0; point < 4; ++point) {
        const auto at_z = static_cast<float>(point < 2 ? z.lowest : z.highest);
        EXPECT_EQ(output[point].x,
                  static_cast<float>(point % 2 == 0 ? x.lowest : x.highest));
        EXPECT_EQ(output[point].y, 0.1f);
        EXPECT_EQ(output[point].z, at_z);
        EXPECT_EQ(output[point].intensity, at_z);
      }
    }
  PCLPointCloud2 message = plainMessage(2);
  fieldOf(message, "intensity").datatype = 11; // BOOL, which PCL 1.12 does not name
  message.data[12] = 0;
  message.data[28] = 1;
  Output output;
  ASSERT_TRUE(processNative(message, output).ok());
  EXPECT_EQ(output[0].intensity, 0.0f);
  EXPECT_EQ(output[1].intensity, 1.0f);
}

TEST(CloudLayout, WhatIsNotUsedIsNotChecked)
{
  PCLPointCloud2 message = plainMessage();
  message.data.resize(message.data.size() + 1000);
  for (PCLPointField& field : message.fields)
    field.count = 0; // is read as 1
  message.fields.push_back(makeField("junk", 4000000000u, 200, 70000));
  message.fields.push_back(makeField("", 0, 0, 0));
  expectAllRead(message);
  // An intensity where the model has none.
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  message = plainMessage();
  Output output;
  fieldOf(message, "intensity") = makeField("intensity", 4294967295u, 99, 3);
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  message.fields.pop_back();
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 4u);
  EXPECT_EQ(output[0].intensity, 1.0f);
}

TEST(CloudLayout, TheIntensityFieldCanBeNamed)
{
  const PCLPointCloud2 message =
      makeMessage(xyzAnd(makeField("reflectivity", 12, PCLPointField::UINT16)), 14, 6);
  Output output;
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  preprocessor.setIntensityField("reflectivity");
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 6u);
  EXPECT_EQ(output[5].intensity, static_cast<float>(valueOf("reflectivity", 5)));
  for (const std::string name : {"intensity", "ambient"}) {
    preprocessor.setIntensityField(name);
    const PreprocessingStatus status = preprocessor.process(message, output);
    EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
    EXPECT_NE(status.message().find("'" + name + "'"), std::string::npos);
  }
}

TEST(CloudLayout, PointsThatAreNotFiniteAreLeftOut)
{
  constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
  PCLPointCloud2 message = plainMessage(6, 2);
  for (const std::size_t point : {std::size_t{1}, std::size_t{7}})
    writeNumber(
        message.data.data() + point * 16 + 4, PCLPointField::FLOAT32, not_a_number);
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  preprocessor.setCropBox({-100.0, -100.0, 0.0}, {100.0, 100.0, 1.0});
  Output output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  EXPECT_EQ(preprocessor.statistics().points, 12u);
  EXPECT_EQ(preprocessor.statistics().points_not_finite, 2u);
  EXPECT_EQ(preprocessor.statistics().points_cropped, 3u); // z of points 9 to 11
  EXPECT_EQ(output.size(), 7u);
  EXPECT_EQ(output.height, 1u);
  // Doubles that are no floats, either.
  message = makeMessage(fieldsOf("x f64 0 y f64 8 z f64 16"), 24, 3);
  writeNumber(message.data.data(), PCLPointField::FLOAT64, 1e300);
  writeNumber(message.data.data() + 24 + 8, PCLPointField::FLOAT64, not_a_number);
  SensorPreprocessor<CountIntensity> counting{CountIntensity(0.04)};
  ASSERT_TRUE(counting.process(message, output).ok());
  EXPECT_EQ(output.size(), 1u);
  EXPECT_EQ(counting.statistics().points, 3u);
  EXPECT_EQ(counting.statistics().points_not_finite, 2u);
}

/** \brief A change of a valid message, the code that refuses it, and words of the
 * message. */
struct Refusal {
  Change change;
  PreprocessingCode code;
  std::vector<std::string> words;
};

TEST(InvalidCloudLayout, FieldsAreNamed)
{
  std::vector<Refusal> refusals;
  for (const std::string name : {"x", "y", "z", "intensity"}) {
    const auto add = [&](const std::function<void(PCLPointField&)>& change,
                         const std::string& value = "") {
      refusals.push_back({[=](auto& message) { change(fieldOf(message, name)); },
                          PreprocessingCode::InvalidField,
                          {"'" + name + "'", value}});
    };
    for (const auto datatype : std::vector<std::uint8_t>{0, 12, 255})
      add([=](auto& field) { field.datatype = datatype; }, std::to_string(datatype));
    for (const std::uint32_t count : {2u, 3u, 4294967295u})
      add([=](auto& field) { field.count = count; }, std::to_string(count));
    for (const std::uint32_t offset : // outside of the point
         {13u, 16u, 1000u, 2147483648u, 4294967292u, 4294967293u, 4294967295u})
      add([=](auto& field) { field.offset = offset; });
    if (name == "intensity")
      continue;
    add([](auto& field) { field.datatype = 11; }, "11"); // BOOL
    refusals.push_back({[=](auto& message) {
                          fieldOf(message, name).name = name == "z" ? "Z" : "a" + name;
                        },
                        PreprocessingCode::MissingField,
                        {"'" + name + "'"}});
  }
  refusals.push_back({[](auto& message) { message.fields.clear(); },
                      PreprocessingCode::MissingField,
                      {"'x'"}});
  refusals.push_back({[](auto& message) { // at 12 of 16
                        fieldOf(message, "intensity").datatype = PCLPointField::FLOAT64;
                      },
                      PreprocessingCode::InvalidField,
                      {"'intensity'", "20", "16"}});
  refusals.push_back({[](auto& message) { message.point_step = 11; },
                      PreprocessingCode::InvalidField,
                      {"'z'", "11"}});
  refusals.push_back({[](auto& message) { // also of a cloud without points
                        message = plainMessage(0, 1);
                        fieldOf(message, "y").name = "why";
                      },
                      PreprocessingCode::MissingField,
                      {"'y'"}});
  for (std::size_t i = 0; i < refusals.size(); ++i) {
    SCOPED_TRACE(i);
    PCLPointCloud2 message = plainMessage();
    refusals[i].change(message);
    expectRefusal(message, refusals[i].code, refusals[i].words);
  }
}

TEST(InvalidCloudLayout, BytesThatAreNotThereAreNoticed)
{
  const auto rows = [](std::uint32_t row_step) {
    return [=](PCLPointCloud2& message) {
      message = plainMessage(4, 2);
      message.data.push_back(0); // else row_step is not used
      message.row_step = row_step;
    };
  };
  const auto bytes = [](std::uint32_t width, std::uint32_t height, std::size_t size) {
    return [=](PCLPointCloud2& message) {
      message = plainMessage(width, height);
      message.data.resize(size);
    };
  };
  // Sizes whose products wrap.
  const auto sizes = [](std::uint32_t width,
                        std::uint32_t height,
                        std::uint32_t point_step,
                        std::uint32_t row_step) {
    return [=](PCLPointCloud2& message) {
      message.width = width;
      message.height = height;
      message.point_step = point_step;
      message.row_step = row_step;
    };
  };
  constexpr std::uint32_t most = 4294967295u;
  const std::vector<std::pair<Change, std::vector<std::string>>> refusals = {
      {rows(63), {"rows", "63"}},
      {rows(0), {"rows"}},
      {bytes(4, 3, 191), {"191"}},
      {bytes(1, 1, 15), {"15"}},
      {bytes(1, 1, 0), {"0 bytes"}},
      {[](auto& message) { message.height = 0; }, {"bytes of points", "height of 0"}},
      {[](auto& message) { message.width = 0; }, {"bytes of points", "width of 0"}},
      {[](auto& message) { message.point_step = 0; }, {"point"}},
      {[](auto& message) { message.is_bigendian = 1; }, {"byte order"}},
      {sizes(most, most, 16, 64), {}},
      {sizes(2147483648u, 2, 16, 0), {}},
      {sizes(268435456u, 1, 16, 0), {}},
      {sizes(268435457u, 1, 16, 16), {}},
      {sizes(1, most, 16, most), {}},
      {sizes(65536u, 65536u, 65536u, 0), {}},
      {sizes(4, most, 16, 64), {}},
      {sizes(most, 1, most, most), {}},
      {sizes(1, most, most, most), {}}};
  for (std::size_t i = 0; i < refusals.size(); ++i) {
    SCOPED_TRACE(i);
    PCLPointCloud2 message = plainMessage();
    refusals[i].first(message);
    expectRefusal(message, PreprocessingCode::InvalidLayout, refusals[i].second);
  }
}

} // namespace
