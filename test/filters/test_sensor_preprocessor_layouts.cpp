// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief SensorPreprocessor on PCLPointCloud2: all valid layouts are read.
 */
#include "support/message_layouts.h"

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext::test;

TEST(CloudLayout, FieldsMayHaveAnyOrderAndGaps)
{
  expectAllRead(makeMessage({makeField("intensity", 0, PCLPointField::FLOAT32),
                             makeField("z", 9, PCLPointField::FLOAT32),
                             makeField("ring", 13, PCLPointField::UINT16),
                             makeField("x", 17, PCLPointField::FLOAT32),
                             makeField("y", 27, PCLPointField::FLOAT32)},
                            37,
                            11));
  // In the list, too; the last field ends with the point.
  expectAllRead(makeMessage({makeField("y", 27, PCLPointField::FLOAT32),
                             makeField("intensity", 31, PCLPointField::UINT8),
                             makeField("z", 1, PCLPointField::FLOAT32),
                             makeField("x", 5, PCLPointField::FLOAT32)},
                            32,
                            9));
}

TEST(CloudLayout, IntensityOfEveryDatatypeIsRead)
{
  for (std::uint8_t datatype = PCLPointField::INT8; datatype <= 10; ++datatype) {
    SCOPED_TRACE("datatype " + std::to_string(datatype));
    expectAllRead(makeMessage(xyzAnd(makeField("intensity", 13, datatype)), 21, 20));
  }
}

struct Limits {
  std::uint8_t datatype;
  double lowest;
  double highest;
};

const Limits all_limits[] = {Limits{PCLPointField::INT8, -128.0, 127.0},
                             Limits{PCLPointField::UINT8, 0.0, 255.0},
                             Limits{PCLPointField::INT16, -32768.0, 32767.0},
                             Limits{PCLPointField::UINT16, 0.0, 65535.0},
                             Limits{PCLPointField::INT32, -2147483648.0, 2147483647.0},
                             Limits{PCLPointField::UINT32, 0.0, 4294967295.0},
                             Limits{9, -9223372036854775808.0, 9007199254740992.0},
                             Limits{10, 0.0, 9007199254740992.0},
                             Limits{PCLPointField::FLOAT32, -3e38, 3e38},
                             Limits{PCLPointField::FLOAT64, -1.0 / 3.0, 3e38}};

TEST(CloudLayout, EndsOfEveryDatatypeAreRead)
{
  for (const Limits& limits : all_limits) {
    PCLPointCloud2 message =
        makeMessage(xyzAnd(makeField("intensity", 12, limits.datatype)), 20, 2);
    writeNumber(message.data.data() + 12, limits.datatype, limits.lowest);
    writeNumber(message.data.data() + 32, limits.datatype, limits.highest);
    Output output;
    ASSERT_TRUE(processNative(message, output).ok());
    EXPECT_EQ(output[0].intensity, static_cast<float>(limits.lowest));
    EXPECT_EQ(output[1].intensity, static_cast<float>(limits.highest));
  }
}

TEST(CloudLayout, IntensityMayBeBool)
{
  PCLPointCloud2 message = plainMessage(2);
  fieldOf(message, "intensity").datatype = 11; // BOOL, which PCL 1.12 does not name
  message.data[12] = 0;
  message.data[28] = 1;
  Output output;
  ASSERT_TRUE(processNative(message, output).ok());
  EXPECT_EQ(output[0].intensity, 0.0f);
  EXPECT_EQ(output[1].intensity, 1.0f);
}

TEST(CloudLayout, CoordinatesMayBeDouble)
{
  expectAllRead(makeMessage({makeField("z", 3, PCLPointField::FLOAT64),
                             makeField("x", 11, PCLPointField::FLOAT64),
                             makeField("y", 20, PCLPointField::FLOAT64),
                             makeField("intensity", 28, PCLPointField::INT16)},
                            31,
                            13,
                            3,
                            5));
}

TEST(CloudLayout, CoordinatesMayBeOfAnyDatatypes)
{
  for (const Limits& x : all_limits)
    for (const Limits& z : all_limits) {
      SCOPED_TRACE(std::to_string(x.datatype) + " and " + std::to_string(z.datatype));
      const auto is_long = [](std::uint8_t type) { return type >= 8; };
      // Where they fit as close to each other as floats that are read at once.
      const std::uint32_t gap = is_long(x.datatype) || is_long(z.datatype) ? 8 : 4;
      PCLPointCloud2 message =
          makeMessage({makeField("x", 0, x.datatype),
                       makeField("y", gap, PCLPointField::FLOAT32),
                       makeField("z", 2 * gap, z.datatype),
                       makeField("intensity", 24, PCLPointField::FLOAT32)},
                      28,
                      4);
      for (std::size_t point = 0; point < 4; ++point) {
        std::uint8_t* const bytes = &message.data[28 * point];
        writeNumber(bytes, x.datatype, point % 2 == 0 ? x.lowest : x.highest);
        writeNumber(bytes + gap, PCLPointField::FLOAT32, 0.1);
        writeNumber(bytes + 2 * gap, z.datatype, point < 2 ? z.lowest : z.highest);
      }
      Output output;
      ASSERT_TRUE(processNative(message, output).ok());
      ASSERT_EQ(output.size(), 4u);
      for (std::size_t point = 0; point < 4; ++point) {
        EXPECT_EQ(output[point].x,
                  static_cast<float>(point % 2 == 0 ? x.lowest : x.highest));
        EXPECT_EQ(output[point].y, 0.1f);
        EXPECT_EQ(output[point].z,
                  static_cast<float>(point < 2 ? z.lowest : z.highest));
      }
    }
}

TEST(CloudLayout, DoubleCoordinatesBeyondFloatAreNotFinite)
{
  PCLPointCloud2 message = makeMessage({makeField("x", 0, PCLPointField::FLOAT64),
                                        makeField("y", 8, PCLPointField::FLOAT64),
                                        makeField("z", 16, PCLPointField::FLOAT64)},
                                       24,
                                       3);
  writeNumber(message.data.data(), PCLPointField::FLOAT64, 1e300);
  writeNumber(message.data.data() + 24 + 8,
              PCLPointField::FLOAT64,
              std::numeric_limits<double>::quiet_NaN());
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  Output output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  EXPECT_EQ(output.size(), 1u);
  EXPECT_EQ(preprocessor.statistics().points, 3u);
  EXPECT_EQ(preprocessor.statistics().points_not_finite, 2u);
}

TEST(CloudLayout, OrganisedCloudsMayHavePaddedRows)
{
  const std::vector<PCLPointField> fields =
      xyzAnd(makeField("intensity", 16, PCLPointField::FLOAT32));
  expectAllRead(makeMessage(fields, 24, 6, 5));
  expectAllRead(makeMessage(fields, 24, 6, 5, 1));
  expectAllRead(makeMessage(fields, 24, 1, 30, 1000));
}

TEST(CloudLayout, TheLastRowMayGoWithoutItsPadding)
{
  PCLPointCloud2 message = makeMessage(
      xyzAnd(makeField("intensity", 12, PCLPointField::FLOAT32)), 16, 4, 3, 9);
  message.data.resize(message.data.size() - 9);
  expectAllRead(message);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows"});
}

TEST(CloudLayout, UnusedBytesAndFieldsAreNotChecked)
{
  PCLPointCloud2 message = plainMessage();
  message.data.resize(message.data.size() + 1000);
  for (PCLPointField& field : message.fields)
    field.count = 0; // is read as 1
  message.fields.push_back(makeField("junk", 4000000000u, 200, 70000));
  message.fields.push_back(makeField("", 0, 0, 0));
  expectAllRead(message);
}

TEST(CloudLayout, TheIntensityFieldCanBeNamed)
{
  PCLPointCloud2 message =
      makeMessage(xyzAnd(makeField("reflectivity", 12, PCLPointField::UINT16)), 14, 6);
  Output output;
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  PreprocessingStatus status = preprocessor.process(message, output);
  EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
  EXPECT_NE(status.message().find("'intensity'"), std::string::npos);
  preprocessor.setIntensityField("reflectivity");
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 6u);
  EXPECT_EQ(output[5].intensity, static_cast<float>(valueOf("reflectivity", 5)));
  preprocessor.setIntensityField("ambient");
  status = preprocessor.process(message, output);
  EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
  EXPECT_NE(status.message().find("'ambient'"), std::string::npos);
}

TEST(CloudLayout, ModelsWithoutIntensityIgnoreAnInvalidField)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  PCLPointCloud2 message = plainMessage();
  Output output;
  fieldOf(message, "intensity") = makeField("intensity", 4294967295u, 99, 3);
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  message.fields.pop_back();
  EXPECT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 4u);
  EXPECT_EQ(output[0].intensity, 1.0f);
}

TEST(CloudLayout, HeaderOfTheMessageIsCarried)
{
  Output output;
  ASSERT_TRUE(processNative(plainMessage(), output).ok());
  EXPECT_EQ(output.header.frame_id, "sensor");
  EXPECT_EQ(output.header.stamp, 99u);
}

TEST(CloudLayout, MessagesOfPclsOwnTypesAreRead)
{
  pcl::PointCloud<pcl::PointXYZINormal> cloud;
  for (std::size_t i = 0; i < 12; ++i) {
    pcl::PointXYZINormal point;
    point.x = static_cast<float>(valueOf("x", i));
    point.y = static_cast<float>(valueOf("y", i));
    point.z = static_cast<float>(valueOf("z", i));
    point.intensity = static_cast<float>(valueOf("intensity", i));
    cloud.push_back(point);
  }
  cloud.width = 4;
  cloud.height = 3;
  PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  expectAllRead(message);
}

TEST(CloudLayout, PointsThatAreNotFiniteAreLeftOut)
{
  PCLPointCloud2 message = plainMessage(6, 2);
  for (const std::size_t point : {std::size_t{1}, std::size_t{7}})
    writeNumber(message.data.data() + point * 16 + 4,
                PCLPointField::FLOAT32,
                std::numeric_limits<double>::quiet_NaN());
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  preprocessor.setCropBox({-100.0, -100.0, 0.0}, {100.0, 100.0, 1.0});
  Output output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  const auto& statistics = preprocessor.statistics();
  EXPECT_EQ(statistics.points, 12u);
  EXPECT_EQ(statistics.points_not_finite, 2u);
  EXPECT_EQ(statistics.points_cropped, 3u); // z of points 9 to 11 is above 1
  EXPECT_EQ(output.size(), 7u);
  EXPECT_EQ(output.height, 1u);
}

} // namespace
