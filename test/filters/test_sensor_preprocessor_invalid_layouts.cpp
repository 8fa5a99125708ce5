// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief SensorPreprocessor on PCLPointCloud2: invalid layouts are refused, and the
 * message names the field.
 */
#include "support/message_layouts.h"

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext::test;

const std::vector<std::string> coordinates = {"x", "y", "z"};
const std::vector<std::string> all_fields = {"x", "y", "z", "intensity"};

/** \brief Expects a message whose field was changed to be refused for that field. */
template <typename ChangeT>
void
expectInvalidField(const std::string& name,
                   const ChangeT& change,
                   const std::string& value = "")
{
  PCLPointCloud2 message = plainMessage();
  change(fieldOf(message, name));
  expectRefusal(message, PreprocessingCode::InvalidField, {"'" + name + "'", value});
}

TEST(InvalidCloudLayout, EachCoordinateMustBeThere)
{
  for (const std::string& name : coordinates) {
    PCLPointCloud2 message = plainMessage();
    fieldOf(message, name).name = name == "z" ? "Z" : "not_" + name;
    expectRefusal(message, PreprocessingCode::MissingField, {"'" + name + "'"});
  }
  PCLPointCloud2 nameless = plainMessage();
  nameless.fields.clear();
  expectRefusal(nameless, PreprocessingCode::MissingField, {"'x'"});
}

TEST(InvalidCloudLayout, CoordinatesMustBeNumbers)
{
  for (const std::string& name : coordinates)
    expectInvalidField(
        name, [](PCLPointField& field) { field.datatype = 11; }, "11");
}

TEST(InvalidCloudLayout, InvalidFieldsAreNamed)
{
  for (const std::string& name : all_fields) {
    for (const int datatype : {0, 12, 255})
      expectInvalidField(
          name,
          [=](PCLPointField& field) {
            field.datatype = static_cast<std::uint8_t>(datatype);
          },
          std::to_string(datatype));
    for (const std::uint32_t count : {2u, 3u, 4294967295u})
      expectInvalidField(
          name,
          [=](PCLPointField& field) { field.count = count; },
          std::to_string(count));
    // Outside of the point.
    for (const std::uint32_t offset :
         {13u, 16u, 1000u, 2147483648u, 4294967292u, 4294967293u, 4294967295u})
      expectInvalidField(name, [=](PCLPointField& field) { field.offset = offset; });
  }
}

TEST(InvalidCloudLayout, LargeIntensityMustLieWithinThePoint)
{
  PCLPointCloud2 message = plainMessage();
  fieldOf(message, "intensity").datatype = PCLPointField::FLOAT64; // at 12 of 16
  expectRefusal(message, PreprocessingCode::InvalidField, {"'intensity'", "20", "16"});
}

TEST(InvalidCloudLayout, RowsMustHoldTheirPoints)
{
  PCLPointCloud2 message = plainMessage(4, 2);
  message.data.push_back(0); // else row_step is not used
  message.row_step = 4 * 16 - 1;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows", "63"});
  message.row_step = 0;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"rows"});
}

TEST(InvalidCloudLayout, RowsThatFollowEachOtherNeedNoRowStep)
{
  for (const std::uint32_t height : {1u, 3u})
    for (const std::uint32_t row_step : {0u, 1u, 63u, 65u, 640u * 16u, 4294967295u}) {
      PCLPointCloud2 message = plainMessage(4, height);
      message.row_step = row_step;
      expectAllRead(message);
      EXPECT_EQ(pcl_ext::rowStep(message), 64u);
    }
}

TEST(InvalidCloudLayout, AByteTooFewIsNoticed)
{
  PCLPointCloud2 message = plainMessage(4, 3);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"191"});
  message = plainMessage(1, 1);
  message.data.pop_back();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"15"});
  message.data.clear();
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"0 bytes"});
}

TEST(InvalidCloudLayout, SizesWhoseProductsWrapAreNoticed)
{
  struct Size {
    std::uint32_t width;
    std::uint32_t height;
    std::uint32_t point_step;
    std::uint32_t row_step;
  };
  for (const Size& size : {Size{4294967295u, 4294967295u, 16, 64},
                           Size{2147483648u, 2, 16, 0},
                           Size{268435456u, 1, 16, 0},
                           Size{268435457u, 1, 16, 16},
                           Size{1, 4294967295u, 16, 4294967295u},
                           Size{65536u, 65536u, 65536u, 0},
                           Size{4, 4294967295u, 16, 64},
                           Size{4294967295u, 1, 4294967295u, 4294967295u},
                           Size{1, 4294967295u, 4294967295u, 4294967295u}}) {
    PCLPointCloud2 message = plainMessage();
    message.width = size.width;
    message.height = size.height;
    message.point_step = size.point_step;
    message.row_step = size.row_step;
    SCOPED_TRACE(std::to_string(size.width) + " x " + std::to_string(size.height));
    expectRefusal(message, PreprocessingCode::InvalidLayout, {});
  }
}

TEST(InvalidCloudLayout, PointsNeedBytes)
{
  PCLPointCloud2 message = plainMessage();
  message.point_step = 0;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"point"});
}

TEST(InvalidCloudLayout, PointStepMustHoldTheFields)
{
  PCLPointCloud2 message = plainMessage();
  message.point_step = 11;
  expectRefusal(message, PreprocessingCode::InvalidField, {"'z'", "11"});
}

TEST(InvalidCloudLayout, ForeignByteOrderIsRefused)
{
  PCLPointCloud2 message = plainMessage();
  message.is_bigendian = 1;
  expectRefusal(message, PreprocessingCode::InvalidLayout, {"byte order"});
}

TEST(InvalidCloudLayout, EmptyCloudsStillNeedTheirFields)
{
  PCLPointCloud2 message = plainMessage(0, 1);
  expectAllRead(message);
  fieldOf(message, "y").name = "why";
  expectRefusal(message, PreprocessingCode::MissingField, {"'y'"});
}

} // namespace
