// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/frame_field.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace {

using namespace pcl_ext::io;

TEST(FieldNumbers, AscendWithTheValuesAndComeBack)
{
  const auto check = [](FieldType type, auto values) {
    FieldDescription field;
    field.type = type;
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::uint64_t number = fieldNumber(field, &values[i]);
      EXPECT_TRUE(i == 0 || number > last) << i;
      last = number;
      auto back = values[0];
      fieldValue(field, number, &back);
      EXPECT_EQ(std::memcmp(&back, &values[i], sizeof(back)), 0) << i;
    }
  };
  check(FieldType::Int8, std::vector<std::int8_t>{-128, -1, 0, 127});
  check(FieldType::UInt8, std::vector<std::uint8_t>{0, 1, 255});
  check(FieldType::Int16, std::vector<std::int16_t>{-32768, -1, 0, 32767});
  check(FieldType::UInt16, std::vector<std::uint16_t>{0, 65535});
  check(FieldType::Int32,
        std::vector<std::int32_t>{-2147483647 - 1, -1, 0, 2147483647});
  check(FieldType::UInt32, std::vector<std::uint32_t>{0, 4294967295});
  const float endless = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  check(FieldType::Float32,
        std::vector<float>{-nan, -endless, -1.5f, -0.0f, 0.0f, 1e-40f, endless, nan});
  check(FieldType::Float64,
        std::vector<double>{-1e300, -0.0, 0.0, 5e-324, 1e300, std::nan("7")});
}

TEST(FieldNumbers, WithAStepClampAndKeepWhatIsNotFinite)
{
  FieldDescription field;
  field.step = 0.5;
  const auto back = [&](float value) {
    float result = 0.0f;
    fieldValue(field, fieldNumber(field, &value), &result);
    return result;
  };
  EXPECT_EQ(back(1.3f), 1.5f);
  EXPECT_EQ(back(1.25f), 1.0f); // 2.5 steps, rounded to even
  EXPECT_EQ(back(-0.1f), 0.0f);
  EXPECT_EQ(back(1e30f), 0x1p51f);
  EXPECT_EQ(back(-1e30f), -0x1p51f);
  EXPECT_EQ(back(std::numeric_limits<float>::infinity()),
            std::numeric_limits<float>::infinity());
  EXPECT_EQ(back(-std::numeric_limits<float>::infinity()),
            -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(back(std::numeric_limits<float>::quiet_NaN())));
  // Of an integer the steps are rounded to its range.
  field.type = FieldType::UInt8;
  field.step = 100.0;
  std::uint8_t value = 255;
  fieldValue(field, fieldNumber(field, &value), &value);
  EXPECT_EQ(value, 255); // 300
}

} // namespace
