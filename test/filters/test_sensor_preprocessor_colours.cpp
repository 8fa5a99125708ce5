// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/point_types.h>

#include "support/message_layouts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

namespace {

using namespace pcl_ext::test;
using pcl_ext::PointXYZRGBI;

using ColouredOutput = pcl::PointCloud<PointXYZRGBI>;
using ColouringPreprocessor = SensorPreprocessor<NativeIntensity, PointXYZRGBI>;

std::uint32_t
colourOf(std::size_t point)
{
  const auto number = static_cast<std::uint32_t>(point);
  return 0xff000000u | (number * 2654435761u & 0xffffffu);
}

PCLPointCloud2
colouredMessage(const std::string& name,
                std::uint8_t datatype,
                std::uint8_t coordinate = PCLPointField::FLOAT32,
                std::uint32_t width = 300,
                std::uint32_t height = 2)
{
  const std::uint32_t size = coordinate == PCLPointField::FLOAT64 ? 8 : 4;
  const std::uint32_t colour = 3 * size + 5;
  PCLPointCloud2 message = makeMessage({makeField(name, colour, datatype),
                                        makeField("x", 0, coordinate),
                                        makeField("y", size, coordinate),
                                        makeField("z", 2 * size, coordinate),
                                        makeField("intensity", 3 * size, 7)},
                                       colour + 4,
                                       width,
                                       height,
                                       /* row_padding */ 3);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    const std::uint32_t packed = colourOf(i);
    std::memcpy(message.data.data() + i / width * message.row_step +
                    i % width * message.point_step + colour,
                &packed,
                sizeof(packed));
  }
  return message;
}

TEST(ColouredClouds, ColoursOfAllLayoutsAreKept)
{
  for (const std::uint8_t coordinate : {PCLPointField::FLOAT32, PCLPointField::FLOAT64})
    for (const std::uint8_t datatype :
         {PCLPointField::FLOAT32, PCLPointField::UINT32, PCLPointField::INT32})
      for (const char* const name : {"rgb", "rgba"}) {
        PCLPointCloud2 message = colouredMessage(name, datatype, coordinate);
        message.data.shrink_to_fit();
        ColouringPreprocessor preprocessor{NativeIntensity(0.04)};
        // Leaves points out, so that the others move up.
        preprocessor.setCropBox({-1e9f, -100.0f, -1e9f}, {1e9f, 100.0f, 1e9f});
        ColouredOutput output;
        const PreprocessingStatus status = preprocessor.process(message, output);
        ASSERT_TRUE(status.ok()) << status.message();
        EXPECT_TRUE(preprocessor.statistics().has_colours);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < 600; ++i) {
          if (std::abs(valueOf("y", i)) > 100.0)
            continue;
          const PointXYZRGBI& point = output.at(kept++);
          EXPECT_EQ(point.rgba, colourOf(i));
          EXPECT_EQ(point.x, static_cast<float>(valueOf("x", i)));
          EXPECT_EQ(point.intensity, static_cast<float>(valueOf("intensity", i)));
        }
        EXPECT_EQ(kept, output.size());
        EXPECT_GT(preprocessor.statistics().points_cropped, 0u);
      }
}

TEST(ColouredClouds, WithoutAColourTheOutputIsBlack)
{
  ColouringPreprocessor preprocessor{NativeIntensity(0.04)};
  ColouredOutput output;
  ASSERT_TRUE(preprocessor.process(colouredMessage("rgb", 7), output).ok());
  ASSERT_TRUE(preprocessor.process(plainMessage(300), output).ok());
  EXPECT_FALSE(preprocessor.statistics().has_colours);
  ASSERT_EQ(output.size(), 300u);
  for (const PointXYZRGBI& point : output)
    EXPECT_EQ(point.r + point.g + point.b, 0);
}

TEST(ColouredClouds, AColourThatCannotBeReadIsLeftOut)
{
  const auto changes = {+[](PCLPointField& field) { field.datatype = 0; },
                        +[](PCLPointField& field) { field.datatype = 2; }, // UINT8
                        +[](PCLPointField& field) { field.datatype = 8; }, // FLOAT64
                        +[](PCLPointField& field) { field.count = 3; },
                        +[](PCLPointField& field) { field.offset += 1; }};
  for (const auto change : changes) {
    PCLPointCloud2 message = colouredMessage("rgb", PCLPointField::FLOAT32);
    change(fieldOf(message, "rgb"));
    ColouringPreprocessor preprocessor{NativeIntensity(0.04)};
    ColouredOutput output;
    EXPECT_TRUE(preprocessor.process(message, output).ok());
    EXPECT_FALSE(preprocessor.statistics().has_colours);
    ASSERT_EQ(output.size(), 600u);
    for (std::size_t i = 0; i < output.size(); ++i) {
      EXPECT_EQ(output[i].z, static_cast<float>(valueOf("z", i)));
      EXPECT_EQ(output[i].r + output[i].g + output[i].b, 0);
    }
    expectAllRead(message); // without a colour in the output type
  }
}

TEST(ColouredClouds, AnotherColourIsTakenInPlaceOfOneThatCannotBeRead)
{
  PCLPointCloud2 message = colouredMessage("rgba", PCLPointField::UINT32);
  message.fields.push_back(makeField("rgb", 0, PCLPointField::UINT8));
  ColouringPreprocessor preprocessor{NativeIntensity(0.04)};
  ColouredOutput output;
  ASSERT_TRUE(preprocessor.process(message, output).ok());
  ASSERT_EQ(output.size(), 600u);
  for (std::size_t i = 0; i < output.size(); ++i)
    EXPECT_EQ(output[i].rgba, colourOf(i));
}

template <typename PointT>
class ColouredTypes : public ::testing::Test {};

using TestedTypes =
    ::testing::Types<pcl::PointXYZRGB, pcl::PointXYZRGBA, pcl::PointXYZRGBNormal>;
TYPED_TEST_SUITE(ColouredTypes, TestedTypes, );

TYPED_TEST(ColouredTypes, KeepTheirColours)
{
  pcl::PointCloud<TypeParam> cloud;
  for (std::size_t i = 0; i < 700; ++i) {
    TypeParam point;
    point.x = static_cast<float>(i);
    point.rgba = colourOf(i);
    cloud.push_back(point);
  }
  cloud[5].z = std::numeric_limits<float>::quiet_NaN();
  SensorPreprocessor<CountIntensity, PointXYZRGBI> preprocessor{CountIntensity(0.04)};
  ColouredOutput output;
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  ASSERT_EQ(output.size(), 699u);
  for (std::size_t i = 0; i < output.size(); ++i) {
    EXPECT_EQ(output[i].rgba, colourOf(i + (i < 5 ? 0 : 1)));
    EXPECT_EQ(output[i].intensity, 1.0f);
  }
  // Of an output type without intensity, too; a cloud may be its own output.
  SensorPreprocessor<CountIntensity, pcl::PointXYZRGB> without{CountIntensity(0.04)};
  pcl::PointCloud<pcl::PointXYZRGB> in_place;
  ASSERT_TRUE(without.process(cloud, in_place).ok());
  ASSERT_TRUE(without.process(in_place, in_place).ok());
  ASSERT_EQ(in_place.size(), 699u);
  for (std::size_t i = 0; i < in_place.size(); ++i)
    EXPECT_EQ(in_place[i].rgba, output[i].rgba);
}

} // namespace
