// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/node_parameters.h>

#include "nodes/codec_parameters.h"
#include "simulator/cell_parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace node_parameters {

using namespace pcl_ext::nodes;
namespace io = pcl_ext::io;

using List = std::vector<double>;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
const std::int64_t beyond_int32 = std::int64_t{1} << 31;

const std::vector<std::pair<std::string, std::vector<ParameterDescription>>>&
allTables()
{
  static const std::vector<std::pair<std::string, std::vector<ParameterDescription>>>
      tables = {{"encoding parameters", encodingParameters()},
                {"sensor node parameters", sensorNodeParameters()},
                {"noise parameters", noiseParameters()},
                {"central node parameters", centralNodeParameters()},
                {"stream parameters", streamParameters()},
                {"cell parameters", pcl_ext::cell::cellParameters()}};
  return tables;
}

/** \brief What a parameter says about a value; empty if it is allowed. */
std::string
refusal(const ParameterDescription& parameter, const ParameterValue& value)
{
  return convertedValue(parameter, value) ? "" : refusalOf(parameter, value);
}

std::string
refusal(const std::string& name, const ParameterValue& value)
{
  return refusal(descriptionOf(encodingParameters(), name), value);
}

void
expectRefused(const ParameterDescription& parameter, const ParameterValue& value)
{
  EXPECT_EQ(refusal(parameter, value),
            parameter.name + " is " + textOf(value) + "; it must be " +
                allowedValues(parameter));
}

std::string
tableOf(const std::vector<ParameterDescription>& parameters)
{
  std::string table =
      "| parameter | unit | default | allowed | |\n|---|---|---|---|---|\n";
  for (const ParameterDescription& parameter : parameters)
    table += "| `" + parameter.name + "` | " + parameter.unit + " | " +
             textOf(parameter.default_value) + " | " + allowedValues(parameter) +
             " | " + parameter.description + " |\n";
  return table;
}

/** \brief What is between two marks of a file; the file's end if there are none. */
std::string
section(const std::string& file, const std::string& name)
{
  std::ifstream stream(PCL_EXT_TEST_DATA "/../../" + file);
  const std::string content{std::istreambuf_iterator<char>(stream),
                            std::istreambuf_iterator<char>()};
  const std::string begin = "<!-- " + name + " -->\n";
  const std::size_t at = content.find(begin);
  const std::size_t end = content.find("<!-- end of " + name + " -->");
  if (at == std::string::npos || end == std::string::npos)
    return "no section " + name;
  return content.substr(at + begin.size(), end - at - begin.size());
}

TEST(NodeParameters, TablesOfTheDocumentsAreThoseOfTheLibrary)
{
  for (const auto& [name, parameters] : allTables())
    EXPECT_EQ(section("doc/nodes.md", name), "\n" + tableOf(parameters) + "\n");
}

TEST(NodeParameters, TablesHaveDifferentNamesAllowedDefaultsAndDescriptions)
{
  for (const auto& table : allTables()) {
    std::set<std::string> names;
    for (const ParameterDescription& parameter : table.second) {
      SCOPED_TRACE(parameter.name);
      EXPECT_TRUE(names.insert(parameter.name).second);
      EXPECT_EQ(refusal(parameter, parameter.default_value), "");
      EXPECT_EQ(parameter.description.back(), '.');
      EXPECT_EQ(parameter.description.find('\n'), std::string::npos);
      EXPECT_LE(parameter.lowest, parameter.highest);
    }
  }
  EXPECT_THROW(descriptionOf(encodingParameters(), "speed"), std::out_of_range);
}

TEST(NodeParameters, NumbersEndAtTheirRange)
{
  for (const auto& table : allTables())
    for (const ParameterDescription& parameter : table.second) {
      SCOPED_TRACE(parameter.name);
      const bool is_whole =
          std::holds_alternative<std::int64_t>(parameter.default_value);
      const double lowest = parameter.lowest;
      const double highest = parameter.highest;
      if (is_whole) {
        ASSERT_GE(lowest, 0.0);
        ASSERT_LT(highest, static_cast<double>(beyond_int32));
        for (const std::int64_t inside : {std::llround(lowest), std::llround(highest)})
          EXPECT_EQ(refusal(parameter, inside), "");
        for (const std::int64_t outside : {std::int64_t{-1},
                                           std::int64_t{std::llround(highest) + 1},
                                           beyond_int32,
                                           std::int64_t{1} << 32,
                                           std::numeric_limits<std::int64_t>::min(),
                                           std::numeric_limits<std::int64_t>::max()})
          expectRefused(parameter, outside);
        expectRefused(parameter, lowest);
      }
      else if (std::holds_alternative<double>(parameter.default_value)) {
        for (const double inside : {lowest, highest})
          EXPECT_EQ(refusal(parameter, inside), "");
        EXPECT_EQ(convertedValue(parameter, std::int64_t{1}).has_value(),
                  refusal(parameter, 1.0).empty());
        for (const double outside : {std::nextafter(lowest, -infinite),
                                     std::nextafter(highest, infinite),
                                     infinite,
                                     -infinite,
                                     not_a_number})
          expectRefused(parameter, outside);
      }
    }
}

TEST(NodeParameters, OtherWordsTypesAndListsAreRefused)
{
  const std::vector<ParameterValue> values = {
      true, 1, 1.5, "fast", List{0, 0, 0, 1, 1, 1}};
  for (const auto& table : allTables())
    for (const ParameterDescription& parameter : table.second) {
      SCOPED_TRACE(parameter.name);
      const ParameterValue& own = parameter.default_value;
      for (const ParameterValue& value : values)
        if (value.index() != own.index() &&
            !(std::holds_alternative<double>(own) && value == ParameterValue(1)))
          expectRefused(parameter, value);
      for (const std::string& word : parameter.words) {
        EXPECT_EQ(refusal(parameter, word), "");
        expectRefused(parameter, word + "er");
      }
      if (own == ParameterValue(List())) {
        const List list(parameter.list_size, 1.0);
        EXPECT_EQ(refusal(parameter, list), "");
        List other = list;
        other.back() = infinite;
        expectRefused(parameter, other);
        other.back() = not_a_number;
        expectRefused(parameter, other);
        other.pop_back();
        expectRefused(parameter, other);
      }
    }
  // An empty text is allowed only where it is one of the words.
  EXPECT_EQ(refusal("sensor", ""), "");
  EXPECT_EQ(refusal("effort", ""),
            "effort is ''; it must be one of: fast, balanced, small");
  EXPECT_EQ(refusal("intensity_field", ""),
            "intensity_field is ''; it must be a text that is not empty");
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

TEST(NodeParameters, ARowOfTheTableOfSettingsIsOne)
{
  const io::EncoderSettingTable table = {{"brightness",
                                          &io::EncoderSettings::i_frame_rate,
                                          {2.0, 64.0, "lux", "dark"},
                                          "How bright it is, beside {resolution}.",
                                          {},
                                          {}},
                                         {"secret",
                                          &io::EncoderSettings::keep_points,
                                          {},
                                          "Nothing.",
                                          {},
                                          {"nodes do not have it", "", ""}}};
  std::vector<ParameterDescription> parameters;
  describeCodec(table, parameters);
  ASSERT_EQ(parameters.size(), 1u);
  EXPECT_EQ(tableOf(parameters),
            tableOf({}) + "| `brightness` | lux | 30 | a whole number from 2 to 64, or "
                          "0 | How bright it is, beside resolution; 0: dark. |\n");
  EXPECT_FALSE(isInterval(parameters[0]));
  EXPECT_TRUE(isInterval(descriptionOf(encodingParameters(), "intensity_bits")));
  EXPECT_EQ(refusal(parameters[0], 0), "");
  EXPECT_EQ(refusal(parameters[0], 1),
            "brightness is 1; it must be a whole number from 2 to 64, or 0");
  const ParameterValues values = {{"brightness", 0}, {"secret", true}};
  io::EncoderSettings settings;
  ASSERT_TRUE(readCodec(table, ParameterAccess(parameters, values), settings).ok());
  EXPECT_EQ(settings.i_frame_rate, 0u);
  EXPECT_FALSE(settings.keep_points);
  EXPECT_TRUE(checkEach(table, settings).ok());
  settings.i_frame_rate = 65;
  EXPECT_EQ(checkEach(table, settings).message(),
            "brightness is 65; it must be 2 to 64 lux, or 0 for dark");
}

} // namespace node_parameters

} // namespace
