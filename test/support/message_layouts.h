// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pcl_ext::test {

using pcl::PCLPointCloud2;
using pcl::PCLPointField;
using pcl_ext::CountIntensity;
using pcl_ext::NativeIntensity;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatus;
using pcl_ext::SensorPreprocessor;

using Output = pcl::PointCloud<pcl::PointXYZI>;

inline PCLPointField
makeField(const std::string& name,
          std::uint32_t offset,
          std::uint8_t datatype,
          std::uint32_t count = 1)
{
  PCLPointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  return field;
}

/** \brief x, y and z as floats at the begin of a point, and another field. */
inline std::vector<PCLPointField>
xyzAnd(const PCLPointField& field)
{
  return {makeField("x", 0, PCLPointField::FLOAT32),
          makeField("y", 4, PCLPointField::FLOAT32),
          makeField("z", 8, PCLPointField::FLOAT32),
          field};
}

template <typename NumberT>
inline void
put(std::uint8_t* place, double value)
{
  const auto number = static_cast<NumberT>(value);
  std::memcpy(place, &number, sizeof(number));
}

inline void
writeNumber(std::uint8_t* place, std::uint8_t datatype, double value)
{
  switch (datatype) {
  case PCLPointField::INT8:
    return put<std::int8_t>(place, value);
  case PCLPointField::UINT8:
    return put<std::uint8_t>(place, value);
  case PCLPointField::INT16:
    return put<std::int16_t>(place, value);
  case PCLPointField::UINT16:
    return put<std::uint16_t>(place, value);
  case PCLPointField::INT32:
    return put<std::int32_t>(place, value);
  case PCLPointField::UINT32:
    return put<std::uint32_t>(place, value);
  case PCLPointField::FLOAT32:
    return put<float>(place, value);
  case PCLPointField::FLOAT64:
    return put<double>(place, value);
  case 9: // INT64, which PCL 1.12 does not name
    return put<std::int64_t>(place, value);
  case 10: // UINT64
    return put<std::uint64_t>(place, value);
  default:
    FAIL() << "no such datatype in this test";
  }
}

/** \brief Value of a field at a point, as the test filled it in. */
inline double
valueOf(const std::string& field, std::size_t point)
{
  const auto number = static_cast<double>(point);
  if (field == "x")
    return -4.0 + 0.25 * number;
  if (field == "y")
    return 2.0 - 0.5 * number;
  if (field == "z")
    return 0.125 * number;
  if (field == "intensity" || field == "reflectivity")
    return std::fmod(7.0 * number, 120.0);
  return -77.0;
}

/** \brief A cloud of a layout; bytes that belong to no field are 0xa5. */
inline PCLPointCloud2
makeMessage(const std::vector<PCLPointField>& fields,
            std::uint32_t point_step,
            std::uint32_t width,
            std::uint32_t height = 1,
            std::uint32_t row_padding = 0)
{
  PCLPointCloud2 message;
  message.header.frame_id = "sensor";
  message.header.stamp = 99;
  message.width = width;
  message.height = height;
  message.fields = fields;
  message.point_step = point_step;
  message.row_step = width * point_step + row_padding;
  message.is_bigendian = 0;
  message.data.assign(std::size_t{message.row_step} * height, 0xa5);
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column)
      for (const PCLPointField& field : fields)
        writeNumber(message.data.data() + row * message.row_step + column * point_step +
                        field.offset,
                    field.datatype,
                    valueOf(field.name, row * width + column));
  return message;
}

inline PCLPointCloud2
plainMessage(std::uint32_t width = 4, std::uint32_t height = 1)
{
  return makeMessage(
      xyzAnd(makeField("intensity", 12, PCLPointField::FLOAT32)), 16, width, height);
}

inline PCLPointField&
fieldOf(PCLPointCloud2& message, const std::string& name)
{
  for (PCLPointField& field : message.fields)
    if (field.name == name)
      return field;
  ADD_FAILURE() << "the test's message has no field " << name;
  return message.fields.front();
}

/** \brief Runs a native preprocessor over a copy of the message whose bytes end where
 * the allocation ends, so that a sanitizer sees the first byte too many. */
inline PreprocessingStatus
processNative(const PCLPointCloud2& message, Output& output)
{
  PCLPointCloud2 tight = message;
  tight.data.shrink_to_fit();
  output.resize(3); // of an earlier call
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(0.04)};
  const PreprocessingStatus status = preprocessor.process(tight, output);
  if (!status.ok()) {
    EXPECT_TRUE(output.empty());
    EXPECT_EQ(output.width, 0u);
    EXPECT_EQ(preprocessor.statistics().points, 0u);
    EXPECT_FALSE(status.message().empty());
  }
  return status;
}

inline void
expectAllRead(const PCLPointCloud2& message)
{
  Output output;
  const PreprocessingStatus status = processNative(message, output);
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(output.size(), std::size_t{message.width} * message.height);
  EXPECT_EQ(output.header.frame_id, "sensor");
  EXPECT_EQ(output.header.stamp, 99u);
  for (std::size_t i = 0; i < output.size(); ++i) {
    EXPECT_EQ(output[i].x, static_cast<float>(valueOf("x", i))) << i;
    EXPECT_EQ(output[i].y, static_cast<float>(valueOf("y", i))) << i;
    EXPECT_EQ(output[i].z, static_cast<float>(valueOf("z", i))) << i;
    EXPECT_EQ(output[i].intensity, static_cast<float>(valueOf("intensity", i))) << i;
  }
}

inline void
expectRefusal(const PCLPointCloud2& message,
              PreprocessingCode code,
              const std::vector<std::string>& culprits)
{
  Output output;
  const PreprocessingStatus status = processNative(message, output);
  EXPECT_EQ(static_cast<int>(status.code()), static_cast<int>(code))
      << status.message();
  for (const std::string& culprit : culprits)
    EXPECT_NE(status.message().find(culprit), std::string::npos)
        << "'" << culprit << "' is not in: " << status.message();
}

} // namespace pcl_ext::test
