// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/status.h>

#include "bytes/exact_text.h"
#include "stream/encoder_setting.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cctype>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using pcl_ext::exactText;
using pcl_ext::SettingText;

using Settings = IntensityCompressionSettings;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr float float_infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_float = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t largest_size = std::numeric_limits<std::size_t>::max();

void
expectAccepted(const Settings& settings)
{
  const CompressionStatus status = checkSettings(settings);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status.message().empty()) << status.message();
}

void
expectRefused(const std::string& name, const Settings& settings)
{
  const CompressionStatus status = checkSettings(settings);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(static_cast<int>(status.code()),
            static_cast<int>(CompressionCode::InvalidSettings));
  EXPECT_NE(status.message().find(name), std::string::npos)
      << "'" << name << "' is not in: " << status.message();
}

Settings
publishedSettings()
{
  Settings settings;
  settings.format = StreamFormat::Published;
  return settings;
}

template <typename NumberT>
using Values = std::vector<NumberT>;

template <typename GroupT, typename NumberT>
void
expectAccepted(NumberT GroupT::*field,
               const Values<NumberT>& values,
               Settings settings = Settings())
{
  for (const NumberT value : values) {
    SCOPED_TRACE(testing::PrintToString(value));
    settings.*field = value;
    expectAccepted(settings);
  }
}

template <typename GroupT, typename NumberT>
void
expectRefused(const std::string& name,
              NumberT GroupT::*field,
              const Values<NumberT>& values,
              Settings settings = Settings())
{
  for (const NumberT value : values) {
    SCOPED_TRACE(testing::PrintToString(value));
    settings.*field = value;
    expectRefused(name, settings);
  }
}

Values<unsigned int>
bitsUpTo(unsigned int last)
{
  Values<unsigned int> values;
  for (unsigned int bits = 0; bits <= last; ++bits)
    values.push_back(bits);
  return values;
}

TEST(CompressionSettings, DefaultsAreTheDocumentedOnesAndValid)
{
  const Settings settings;
  EXPECT_EQ(settings.effort, Effort::Fast);
  EXPECT_EQ(settings.format, StreamFormat::Version1);
  EXPECT_EQ(settings.aggregation, Aggregation::Automatic);
  EXPECT_EQ(settings.intensity_curve, IntensityCurve::Linear);
  EXPECT_FALSE(settings.bounding_box.has_value());
  EXPECT_FALSE(settings.sensor_pose.has_value());
  EXPECT_FALSE(settings.carry_header);
  EXPECT_FALSE(settings.retain_octree);
  EXPECT_FALSE(settings.show_statistics);
  EXPECT_EQ(settings.decoder_limits.max_frame_bytes, std::size_t{1} << 28);
  EXPECT_EQ(settings.decoder_limits.max_voxels, std::size_t{1} << 26);
  EXPECT_EQ(settings.decoder_limits.free_voxels, std::size_t{1} << 23);
  EXPECT_TRUE(checkSettings(settings).ok());
  EXPECT_TRUE(checkSettings(publishedSettings()).ok());
}

Settings
withNumber(const EncoderSetting& setting, double number)
{
  Settings settings;
  std::visit(
      [&](const auto& member) {
        using MemberT = std::decay_t<decltype(member)>;
        if constexpr (!std::is_same_v<MemberT, SettingAccess>) {
          auto& value = static_cast<EncoderSettings&>(settings).*member;
          value = static_cast<std::decay_t<decltype(value)>>(number);
        }
      },
      setting.member);
  return settings;
}

/** \brief Expects the message that the row of a setting makes of its value. */
void
expectRefusedByRow(const EncoderSetting& setting,
                   const std::string& value,
                   const Settings& settings)
{
  const CompressionStatus status = checkSettings(settings);
  EXPECT_EQ(static_cast<int>(status.code()),
            static_cast<int>(CompressionCode::InvalidSettings));
  EXPECT_EQ(status.setting(), setting.id);
  EXPECT_EQ(status.message(),
            setting.id + " is " + value + "; it must be " + demandOf(setting));
}

/** \brief Name and default of a field of a struct, by its line in a header; without a
 * name if the line has none. */
std::pair<std::string, std::string>
fieldOf(const std::string& line)
{
  if (line.size() < 4 || line.compare(0, 2, "  ") != 0 ||
      std::isalpha(static_cast<unsigned char>(line[2])) == 0 || line.back() != ';')
    return {};
  const std::string declaration = line.substr(2, line.size() - 3);
  const std::size_t equals = declaration.find(" = ");
  const std::string type_and_name = declaration.substr(0, equals);
  return {type_and_name.substr(type_and_name.rfind(' ') + 1),
          equals == std::string::npos ? "" : declaration.substr(equals + 3)};
}

TEST(EncoderSettingTable, EachFieldOfTheHeaderHasARowWithItsDefault)
{
  std::ifstream header(PCL_EXT_TEST_DATA
                       "/../../include/pcl_ext/compression/compression_settings.h");
  std::map<std::string, std::string> defaults;
  std::string of;
  for (std::string line; std::getline(header, line);) {
    if (line.compare(0, 7, "struct ") == 0)
      of = line.substr(7, line.find(' ', 7) - 7);
    else if (const auto [name, value] = fieldOf(line);
             !name.empty() && (of == "GridSettings" || of == "IntensitySettings" ||
                               of == "StreamSettings" || of == "RateSettings" ||
                               of == "EncoderSettings"))
      defaults[name] = value;
  }
  EXPECT_EQ(defaults.erase("decoder_limits"), 1u); // see encoderSettingTable()
  EXPECT_EQ(defaults.size(), encoderSettingTable().size());
  for (const EncoderSetting& setting : encoderSettingTable()) {
    SCOPED_TRACE(setting.id);
    ASSERT_EQ(defaults.count(setting.id), 1u);
    std::istringstream text(defaults[setting.id]);
    const SettingValue value = valueOf(setting, EncoderSettings());
    double number = 0.0;
    if (const auto* const flag = std::get_if<bool>(&value)) {
      EXPECT_EQ(text.str(), *flag ? "true" : "false");
    }
    else if (const auto* const whole = std::get_if<std::int64_t>(&value)) {
      EXPECT_EQ(text.str(), std::to_string(*whole));
    }
    else if (const auto* const real = std::get_if<double>(&value);
             real && text >> number) {
      EXPECT_EQ(number, *real);
    }
  }
}

TEST(EncoderSettingTable, EachIsOfferedOrSaysWhyNot)
{
  for (const EncoderSetting& setting : encoderSettingTable()) {
    SCOPED_TRACE(setting.id);
    EXPECT_EQ(setting.option.names.empty(), !setting.not_offered.option.empty());
    EXPECT_EQ(setting.help.back(), '.');
    // Settings that a sentence names are rows.
    for (const std::string& text : {setting.help, setting.option.help})
      (void)SettingText{text}.with([](const std::string& id) {
        const auto& table = encoderSettingTable();
        EXPECT_TRUE(std::any_of(table.begin(), table.end(), [&id](const auto& row) {
          return row.id == id;
        })) << id;
        return id;
      });
  }
}

TEST(EncoderSettingTable, NumbersEndAtTheirRange)
{
  for (const EncoderSetting& setting : encoderSettingTable()) {
    SCOPED_TRACE(setting.id);
    const SettingValue value = valueOf(setting, EncoderSettings());
    const bool is_whole = std::holds_alternative<std::int64_t>(value);
    if (!is_whole && !std::holds_alternative<double>(value))
      continue;
    const auto& [lowest, highest, unit, zero] = setting.range;
    for (const double number : {lowest, 0.5 * (lowest + highest), highest})
      expectAccepted(withNumber(setting, number));
    if (!zero.empty() || lowest == 0.0)
      expectAccepted(withNumber(setting, 0.0));
    else
      expectRefusedByRow(setting, "0", withNumber(setting, 0.0));
    if (is_whole && lowest > 1.0)
      expectRefusedByRow(setting, "1", withNumber(setting, 1.0));
    if (is_whole && highest < 4294967295.0)
      for (const double number : {highest + 1.0, 4294967295.0})
        expectRefusedByRow(
            setting, std::to_string(std::llround(number)), withNumber(setting, number));
    if (is_whole)
      continue;
    const bool is_float =
        std::holds_alternative<float EncoderSettings::*>(setting.member);
    for (const double number :
         {is_float ? -1e-30 : std::nextafter(lowest, -infinity),
          is_float ? double{FLT_MAX} : std::nextafter(highest, infinity),
          -1.0,
          infinity,
          -infinity,
          not_a_number})
      expectRefusedByRow(setting,
                         is_float ? exactText(static_cast<float>(number))
                                  : exactText(number),
                         withNumber(setting, number));
  }
}

TEST(EncoderSettingTable, WordsAreTheEnumerators)
{
  for (const EncoderSetting& setting : encoderSettingTable())
    for (const std::string& word : wordsOf(setting)) {
      Settings settings;
      EXPECT_TRUE(setValue(setting, word, settings).ok());
      EXPECT_EQ(std::get<std::string>(valueOf(setting, settings)), word);
      expectAccepted(settings);
      const CompressionStatus status = setValue(setting, word + "er", settings);
      EXPECT_EQ(status.message(),
                setting.id + " is " + word + "er; it must be " + demandOf(setting));
      EXPECT_EQ(std::get<std::string>(valueOf(setting, settings)), word);
    }
  for (const int effort : {-1, 3, 7, 255})
    expectRefused("effort is unknown; it must be one of fast, balanced, small",
                  &Settings::effort,
                  {static_cast<Effort>(effort)});
}

TEST(EncoderSettingTable, DemandsNameUnitAndZero)
{
  const auto message = [](auto field, auto value) {
    Settings settings;
    settings.*field = value;
    return checkSettings(settings).message();
  };
  EXPECT_EQ(message(&Settings::resolution, 0.0),
            "resolution is 0; it must be 1e-06 to 1e+06 m");
  EXPECT_EQ(message(&Settings::max_rate, 500.0),
            "max_rate is 500; it must be 1000 to 1e+12 bit/s, or 0 for no limit");
  EXPECT_EQ(message(&Settings::intensity_range, -3.5f),
            "intensity_range is -3.5; it must be 0 to 3.4e+38 of the intensity, 0 for "
            "automatic");
  EXPECT_EQ(message(&Settings::rate_temporal_filter, 1u),
            "rate_temporal_filter is 1; it must be 2 to 64 frames, or 0 for none");
}

TEST(EncoderSettingTable, MessagesHaveTheNamesOfAFace)
{
  Settings settings;
  settings.temporal_filter = 8;
  settings.keep_points = true;
  const CompressionStatus status = checkSettings(settings);
  EXPECT_EQ(status.message(), "keep_points is on; it must be off with temporal_filter");
  EXPECT_EQ(status.setting(), "keep_points");
  const auto option = [](const std::string& id) { return "--" + id; };
  EXPECT_EQ(status.text().with(option),
            "--keep_points is on; it must be off with --temporal_filter");
  // Texts of users are left as they are.
  settings = Settings();
  settings.fields = {{"{origin}"}, {"{origin}"}};
  EXPECT_EQ(checkSettings(settings).text().with(option),
            "--fields has '{origin}' twice; it must have each name once");
  EXPECT_EQ(CompressionStatus(CompressionCode::Ok, "a {b").text().with(option), "a {b");
  EXPECT_EQ(SettingText{"a {b"}.with(option), "a b");
}

TEST(CompressionSettings, SwitchesAreFree)
{
  expectAccepted(&Settings::temporal_filter, {8u}, publishedSettings());
  expectAccepted(&Settings::aggregation,
                 {Aggregation::Automatic, Aggregation::Sum, Aggregation::Mean},
                 publishedSettings());
  Settings companded;
  companded.intensity_curve = IntensityCurve::Companded;
  expectAccepted(&Settings::intensity_bits, bitsUpTo(16), companded);
}

TEST(CompressionSettings, PublishedLayoutHasEightBitsALinearScaleAndNoHeader)
{
  const Settings published = publishedSettings();
  expectAccepted(&Settings::intensity_bits, {8u}, published);
  for (unsigned int bits = 1; bits <= 16; ++bits)
    if (bits != 8)
      expectRefused("intensity_bits", &Settings::intensity_bits, {bits}, published);
  expectAccepted(&Settings::intensity_range, {255.0f}, published);
  expectRefused(
      "intensity_range", &Settings::intensity_range, {1e-3f, 1.0f, 256.0f}, published);
  expectRefused("intensity_curve",
                &Settings::intensity_curve,
                {IntensityCurve::Companded},
                published);
  expectRefused("carry_header", &Settings::carry_header, {true}, published);
  expectRefused("keep_points", &Settings::keep_points, {true}, published);
}

TEST(CompressionSettings, BoundingBoxMustHaveAnExtentOnEachAxis)
{
  const BoundingBox good{{-1.0, -2.0, -3.0}, {1.0, 2.0, 3.0}};
  for (Settings settings : {Settings(), publishedSettings()}) {
    settings.bounding_box = good;
    expectAccepted(settings);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double min :
           {good.max[axis], good.max[axis] + 0.5, infinity, -infinity, not_a_number}) {
        settings.bounding_box = good;
        settings.bounding_box->min[axis] = min;
        expectRefused("bounding_box", settings);
      }
      for (const double max :
           {good.min[axis], good.min[axis] - 0.5, infinity, -infinity, not_a_number}) {
        settings.bounding_box = good;
        settings.bounding_box->max[axis] = max;
        expectRefused("bounding_box", settings);
      }
    }
  }
}

TEST(CompressionSettings, BoundingBoxMayBeUpToTheGridsWidth)
{
  const double most_voxels = 2097151.0; // 2^21 - 1
  Settings settings;
  settings.resolution = 0.5;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    settings.bounding_box = BoundingBox{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
    double& min = settings.bounding_box->min[axis];
    double& max = settings.bounding_box->max[axis];
    min = -1048576.0 * 0.5;
    max = min + most_voxels * 0.5;
    expectAccepted(settings);
    max += 0.5;
    expectRefused("bounding_box", settings);
    for (const double far : {1e300, DBL_MAX}) {
      min = -far;
      max = far;
      expectRefused("bounding_box", settings);
    }
  }
  settings.bounding_box = BoundingBox{{-50.0, -50.0, -50.0}, {50.0, 50.0, 50.0}};
  expectAccepted(&Settings::resolution, {0.001}, settings);
  expectRefused("bounding_box", &Settings::resolution, {0.00001}, settings);
  settings.resolution = 0.00001;
  EXPECT_EQ(checkSettings(settings).message(),
            "bounding_box is 100 m wide; it must be no wider than 2^21 - 1 "
            "voxels, as with a resolution of 4.8e-05");
  settings.resolution = 4.8e-5;
  expectAccepted(settings);
}

TEST(CompressionSettings, SensorPoseMustBeFiniteAndRigid)
{
  using Pose = Eigen::Isometry3f;
  Pose pose = Pose::Identity();
  pose.translate(Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  pose.rotate(Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()));
  Settings settings;
  settings.sensor_pose = pose;
  expectAccepted(settings);
  for (const float bad : {not_a_float, float_infinity}) {
    settings.sensor_pose = pose;
    settings.sensor_pose->linear()(2, 1) = bad;
    expectRefused("sensor_pose", settings);
    settings.sensor_pose = pose;
    settings.sensor_pose->translation().z() = bad;
    expectRefused("sensor_pose", settings);
  }
  // As SensorPreprocessor demands it: a stretched optical axis stretches the depth.
  for (const float stretch : {2.0f, 0.0f}) {
    settings.sensor_pose = Pose::Identity();
    settings.sensor_pose->linear() *= stretch;
    expectRefused("sensor_pose", settings);
  }
}

TEST(CompressionSettings, DecoderLimitsMustBeAboveZero)
{
  Settings settings;
  for (const std::size_t limit : {std::size_t{1}, largest_size}) {
    settings.decoder_limits.max_frame_bytes = limit;
    settings.decoder_limits.max_voxels = limit;
    expectAccepted(settings);
  }
  using Limit = std::size_t DecoderLimits::*;
  const std::pair<const char*, Limit> limits[] = {
      {"max_frame_bytes", &DecoderLimits::max_frame_bytes},
      {"max_voxels", &DecoderLimits::max_voxels},
      {"free_voxels", &DecoderLimits::free_voxels}};
  for (const auto& [name, limit] : limits) {
    settings = Settings();
    settings.decoder_limits.*limit = 0;
    expectRefused(name, settings);
  }
}

} // namespace
