// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The parameters that the nodes of all ROS versions share: what they allow, and
 * what they say where a value is not allowed.
 */
#include <pcl_ext/nodes/node_parameters.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace parameter_values {

using namespace pcl_ext::nodes;

using List = std::vector<double>;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double most = std::numeric_limits<float>::max();
const std::int64_t beyond_int32 = std::int64_t{1} << 31;

/** \brief What an encoding parameter says about a value; empty if it is allowed. */
std::string
refusal(const std::string& name, const ParameterValue& value)
{
  const ParameterDescription& parameter = descriptionOf(encodingParameters(), name);
  return convertedValue(parameter, value) ? "" : refusalOf(parameter, value);
}

/** \brief Checks what a table says about itself. */
void
expectTable(const std::vector<ParameterDescription>& parameters)
{
  std::set<std::string> names;
  for (const ParameterDescription& parameter : parameters) {
    SCOPED_TRACE(parameter.name);
    EXPECT_TRUE(names.insert(parameter.name).second);
    EXPECT_EQ(convertedValue(parameter, parameter.default_value),
              parameter.default_value);
    EXPECT_EQ(parameter.description.back(), '.');
    EXPECT_EQ(parameter.description.find('\n'), std::string::npos);
    EXPECT_LE(parameter.lowest, parameter.highest);
    if (std::holds_alternative<std::int64_t>(parameter.default_value)) {
      EXPECT_GE(parameter.lowest, 0.0);
      EXPECT_LT(parameter.highest, static_cast<double>(beyond_int32));
    }
  }
}

TEST(NodeParameters, TablesHaveDifferentNamesAllowedDefaultsAndDescriptions)
{
  expectTable(encodingParameters());
  expectTable(noiseParameters());
  expectTable(sensorNodeParameters());
  expectTable(centralNodeParameters());
  expectTable(streamParameters());
}

TEST(NodeParameters, UnknownNamesHaveNoDescription)
{
  EXPECT_THROW(descriptionOf(encodingParameters(), "speed"), std::out_of_range);
  EXPECT_EQ(descriptionOf(encodingParameters(), "resolution").unit, "m");
}

TEST(NodeParameters, ValuesHaveATextOfOneLine)
{
  EXPECT_EQ(textOf(true), "true");
  EXPECT_EQ(textOf(false), "false");
  EXPECT_EQ(textOf(-4), "-4");
  EXPECT_EQ(textOf(0.04), "0.04");
  EXPECT_EQ(textOf(640.0), "640");
  EXPECT_EQ(textOf(1e-6), "1e-06");
  EXPECT_EQ(textOf(1e7), "1e+07");
  EXPECT_EQ(textOf(179.90000001), "179.90000001");
  EXPECT_EQ(textOf(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(textOf(not_a_number), "nan");
  EXPECT_EQ(textOf(-not_a_number), "nan");
  EXPECT_EQ(textOf(-infinite), "-inf");
  EXPECT_EQ(textOf("fast"), "'fast'");
  EXPECT_EQ(textOf(""), "''");
  EXPECT_EQ(textOf(List{0, 0.5, 1e6}), "[0, 0.5, 1e+06]");
  EXPECT_EQ(textOf(List{}), "[]");
}

TEST(NodeParameters, WholeNumbersAreNumbersButNotTheReverse)
{
  const ParameterDescription& number =
      descriptionOf(encodingParameters(), "resolution");
  const auto converted = convertedValue(number, 2);
  ASSERT_TRUE(converted);
  ASSERT_TRUE(std::holds_alternative<double>(*converted));
  EXPECT_EQ(std::get<double>(*converted), 2.0);
  EXPECT_EQ(refusal("i_frame_rate", 2.0),
            "i_frame_rate is 2; it must be a whole number from 0 to 2147483647");
}

TEST(NodeParameters, ValuesOfAnotherTypeAreRefused)
{
  const std::vector<std::pair<std::string, ParameterValue>> examples = {
      {"keep_point_counts", true},
      {"threads", 1},
      {"resolution", 1.0},
      {"effort", "fast"},
      {"intensity_field", "i"},
      {"crop_box", List{0, 0, 0, 1, 1, 1}}};
  for (const auto& [name, own] : examples) {
    EXPECT_EQ(refusal(name, own), "");
    for (const auto& [other_name, value] : examples) {
      const bool is_whole_for_number = name == "resolution" && other_name == "threads";
      if (value.index() == own.index() || is_whole_for_number)
        continue;
      const std::string line = name + " is " + textOf(value) + "; it must be ";
      EXPECT_EQ(refusal(name, value).substr(0, line.size()), line);
    }
  }
  EXPECT_EQ(refusal("resolution", "fine"),
            "resolution is 'fine'; it must be a number from 1e-06 to 1e+06");
  EXPECT_EQ(refusal("keep_point_counts", 1),
            "keep_point_counts is 1; it must be true or false");
  EXPECT_EQ(refusal("threads", true),
            "threads is true; it must be a whole number from 1 to 256");
}

TEST(NodeParameters, WholeNumbersEndAtTheirRange)
{
  struct Range {
    std::string name;
    std::int64_t lowest;
    std::int64_t highest;
    std::string allowed;
  };
  for (const Range& range : std::vector<Range>{
           {"sensor_columns", 1, 65536, "a whole number from 1 to 65536, or 0"},
           {"sensor_rows", 1, 65536, "a whole number from 1 to 65536, or 0"},
           {"i_frame_rate", 0, 2147483647, "a whole number from 0 to 2147483647"},
           {"intensity_bits", 0, 16, "a whole number from 0 to 16"},
           {"colour_bits", 0, 8, "a whole number from 0 to 8"},
           {"threads", 1, 256, "a whole number from 1 to 256"},
           {"temporal_filter", 2, 64, "a whole number from 2 to 64, or 0"}}) {
    EXPECT_EQ(refusal(range.name, range.lowest), "");
    EXPECT_EQ(refusal(range.name, range.highest), "");
    for (const std::int64_t outside : {std::int64_t{-1},
                                       range.highest + 1,
                                       beyond_int32,
                                       std::int64_t{1} << 32,
                                       std::numeric_limits<std::int64_t>::min(),
                                       std::numeric_limits<std::int64_t>::max()})
      EXPECT_EQ(refusal(range.name, outside),
                range.name + " is " + std::to_string(outside) + "; it must be " +
                    range.allowed);
  }
  EXPECT_EQ(refusal("sensor_columns", 0), "");
  EXPECT_EQ(refusal("threads", 0),
            "threads is 0; it must be a whole number from 1 to 256");
}

TEST(NodeParameters, NumbersEndAtTheirRange)
{
  struct Range {
    std::string name;
    double lowest;
    double highest;
    std::string allowed;
  };
  for (const Range& range : std::vector<Range>{
           {"resolution", 1e-6, 1e6, "a number from 1e-06 to 1e+06"},
           {"sensor_fov_x_deg", 0.1, 179.9, "a number from 0.1 to 179.9, or 0"},
           {"sensor_fov_y_deg", 0.1, 179.9, "a number from 0.1 to 179.9, or 0"},
           {"intensity_range", 0, 3.4e38, "a number from 0 to 3.4e+38"},
           {"min_log_odds", -most, most, "a finite number"}}) {
    SCOPED_TRACE(range.name);
    EXPECT_EQ(refusal(range.name, range.lowest), "");
    EXPECT_EQ(refusal(range.name, range.highest), "");
    for (const double outside : {std::nextafter(range.lowest, -infinite),
                                 std::nextafter(range.highest, infinite),
                                 infinite,
                                 -infinite,
                                 not_a_number})
      EXPECT_EQ(refusal(range.name, outside),
                range.name + " is " + textOf(outside) + "; it must be " +
                    range.allowed);
  }
  EXPECT_EQ(refusal("sensor_fov_x_deg", 0.0), "");
  EXPECT_EQ(refusal("sensor_fov_x_deg", not_a_number),
            "sensor_fov_x_deg is nan; it must be a number from 0.1 to 179.9, or 0");
}

TEST(NodeParameters, OtherWordsAreRefused)
{
  for (const auto& [name, words] : std::vector<std::pair<std::string, std::string>>{
           {"intensity", "automatic, count, quadratic, linear, native, none"},
           {"sensor", "kinect_v2, kinect_v1, azure_kinect_nfov, or ''"},
           {"effort", "fast, balanced, small"},
           {"format", "version1, published"},
           {"aggregation", "automatic, sum, mean"},
           {"intensity_curve", "linear, companded"}})
    EXPECT_EQ(refusal(name, "Fast"), name + " is 'Fast'; it must be one of: " + words);
  EXPECT_EQ(refusal("effort", ""),
            "effort is ''; it must be one of: fast, balanced, small");
  EXPECT_EQ(refusal("sensor", ""), "");
  EXPECT_EQ(refusal("intensity_field", ""),
            "intensity_field is ''; it must be a text that is not empty");
}

TEST(NodeParameters, ListsOfOtherLengthsOrNumbersAreRefused)
{
  const std::string allowed = "; it must be a list of 6 finite numbers, or []";
  EXPECT_EQ(refusal("crop_box", List{}), "");
  EXPECT_EQ(refusal("crop_box", List{0, 0, 0, 1, 1}),
            "crop_box is [0, 0, 0, 1, 1]" + allowed);
  EXPECT_EQ(refusal("crop_box", List{0, 0, 0, 1, 1, 1, 1}),
            "crop_box is [0, 0, 0, 1, 1, 1, 1]" + allowed);
  EXPECT_EQ(refusal("crop_box", List{0, 0, 0, 1, 1, infinite}),
            "crop_box is [0, 0, 0, 1, 1, inf]" + allowed);
  EXPECT_EQ(refusal("crop_box", List{not_a_number, 0, 0, 1, 1, 1}),
            "crop_box is [nan, 0, 0, 1, 1, 1]" + allowed);
}

TEST(NodeParameters, NumbersAreFiniteUnlessTheirRangeSaysOtherwise)
{
  ParameterDescription parameter;
  parameter.name = "gain";
  parameter.default_value = 0.0;
  EXPECT_EQ(allowedValues(parameter), "a finite number");
  EXPECT_FALSE(convertedValue(parameter, -infinite));
  parameter.lowest = -infinite;
  parameter.highest = 10;
  EXPECT_EQ(allowedValues(parameter), "a number from -inf to 10");
  EXPECT_TRUE(convertedValue(parameter, -infinite));
  EXPECT_FALSE(convertedValue(parameter, not_a_number));
}

TEST(NodeParameters, ListsMayHaveARangeAndAnyLength)
{
  ParameterDescription parameter;
  parameter.name = "levels";
  parameter.default_value = List{1};
  parameter.lowest = 0;
  parameter.highest = 2;
  EXPECT_EQ(allowedValues(parameter), "a list of numbers from 0 to 2");
  EXPECT_TRUE(convertedValue(parameter, List{}));
  EXPECT_TRUE(convertedValue(parameter, List{0, 1, 2}));
  EXPECT_FALSE(convertedValue(parameter, List{0, 1, 2.5}));
}

TEST(NoiseParameters, OtherValuesAreRefused)
{
  const auto refusal_of = [](const std::string& name, const ParameterValue& value) {
    const ParameterDescription& parameter = descriptionOf(noiseParameters(), name);
    return convertedValue(parameter, value) ? "" : refusalOf(parameter, value);
  };
  EXPECT_EQ(refusal_of("min_intensity", -3), "");
  EXPECT_EQ(refusal_of("min_intensity", not_a_number),
            "min_intensity is nan; it must be a finite number");
  EXPECT_EQ(refusal_of("min_log_odds", 1e39),
            "min_log_odds is 1e+39; it must be a finite number");
  EXPECT_EQ(refusal_of("remove_outliers", "yes"),
            "remove_outliers is 'yes'; it must be true or false");
  EXPECT_EQ(refusal_of("density_unit", "dots"),
            "density_unit is 'dots'; it must be one of: automatic, faces, points, "
            "voxels, rays");
}

TEST(NodeParameters, AListMayBeItsText)
{
  const ParameterDescription& box = descriptionOf(encodingParameters(), "crop_box");
  const auto converted = [&box](const std::string& text) {
    return convertedValue(box, text);
  };
  const ParameterValue six = std::vector<double>{0, -1, 0.1, 10, 10, 4e1};
  EXPECT_EQ(converted("[0, -1, 0.1,10, 10 , 4e1]"), six);
  EXPECT_EQ(converted("[]"), ParameterValue(std::vector<double>()));
  EXPECT_EQ(converted(" [ ] "), ParameterValue(std::vector<double>()));
  for (const char* text : {"",
                           "[",
                           "]",
                           "[0,0,0,1,1]",
                           "[0,0,0,1,1,]",
                           "[0,0,0,1,1,1] 2",
                           "0,0,0,1,1,1",
                           "[0,0,0,1,1,x]",
                           "[0;0;0;1;1;1]",
                           "[,]"})
    EXPECT_EQ(converted(text), std::nullopt) << text;
  EXPECT_EQ(refusalOf(box, std::string("[0]")),
            "crop_box is '[0]'; it must be a list of 6 finite numbers, or []");
}

} // namespace parameter_values

} // namespace
