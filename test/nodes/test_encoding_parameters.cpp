// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/merging_centre.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "nodes/codec_parameters.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace {

namespace encoding_parameters {

using pcl_ext::DensityUnit;
using pcl_ext::IntensityLaw;
using namespace pcl_ext::nodes;
namespace io = pcl_ext::io;

using List = std::vector<double>;

SensorNodeSettings
settingsOf(const ParameterValues& values, bool has_intensities = false)
{
  SensorNodeSettings settings;
  EXPECT_EQ(readEncodingParameters(values, has_intensities, settings), "");
  return settings;
}

ParameterValues
codecValues(const io::EncoderSettings& settings)
{
  ParameterValues values;
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    values[setting.id] = valueOf(setting, settings);
  return values;
}

ParameterValue
otherValue(const ParameterDescription& parameter)
{
  const ParameterValue& usual = parameter.default_value;
  if (const auto* const flag = std::get_if<bool>(&usual))
    return !*flag;
  if (std::holds_alternative<std::int64_t>(usual))
    return std::int64_t{std::llround(parameter.highest)};
  if (std::holds_alternative<double>(usual))
    return parameter.highest;
  if (std::holds_alternative<List>(usual)) {
    List list;
    while (list.size() < parameter.list_size)
      list.push_back(static_cast<double>(list.size()) - 1.5);
    return list;
  }
  return parameter.words.empty() ? "ring,time:1e-06" : parameter.words.back();
}

TEST(EncodingParameters, EachSettingOfTheCodecIsOneOrSaysWhyNot)
{
  const ParameterValues usual = codecValues(io::EncoderSettings());
  for (const io::EncoderSetting& setting : io::encoderSettingTable()) {
    SCOPED_TRACE(setting.id);
    if (!setting.not_offered.parameter.empty()) {
      EXPECT_THROW(descriptionOf(encodingParameters(), setting.id), std::out_of_range);
      continue;
    }
    const ParameterDescription& parameter =
        descriptionOf(encodingParameters(), setting.id);
    EXPECT_EQ(parameter.default_value, usual.at(setting.id));
    // It changes the setting of its name alone, and the default sets it back.
    const ParameterValue other = otherValue(parameter);
    ParameterValues values = usual;
    values[setting.id] = other;
    SensorNodeSettings settings;
    ASSERT_EQ(readEncodingParameters({{setting.id, other}}, false, settings), "");
    if (std::holds_alternative<float io::EncoderSettings::*>(setting.member))
      values[setting.id] = double{static_cast<float>(std::get<double>(other))};
    EXPECT_EQ(codecValues(settings.compression), values);
    settings.global_frame = "hall";
    EXPECT_EQ(readEncodingParameters({}, false, settings), "");
    EXPECT_EQ(codecValues(settings.compression), usual);
    EXPECT_EQ(settings.global_frame, "hall");
  }
}

TEST(EncodingParameters, OthersChangeTheSettingThatTheyName)
{
  using Settings = SensorNodeSettings;
  std::set<std::string> names;
  for (const auto& [values, isSet] :
       std::vector<std::pair<ParameterValues, std::function<bool(const Settings&)>>>{
           {{{"intensity", "count"}},
            [](const Settings& s) { return s.law == IntensityLaw::Count; }},
           {{{"intensity_field", "reflectivity"}},
            [](const Settings& s) { return s.intensity_field == "reflectivity"; }},
           {{{"intensity", "quadratic"}, {"sensor", "kinect_v1"}},
            [](const Settings& s) {
              return s.law == IntensityLaw::Quadratic && s.sensor->columns == 640 &&
                     s.sensor->fov_y_deg == 43.0;
            }},
           {{{"sensor", "azure_kinect_nfov"}}, // with any law
            [](const Settings& s) { return s.sensor->rows == 576; }},
           {{{"intensity", "linear"},
             {"sensor_fov_x_deg", 0.1},
             {"sensor_fov_y_deg", 179.9},
             {"sensor_columns", 1},
             {"sensor_rows", 65536}},
            [](const Settings& s) {
              return s.law == IntensityLaw::Linear && s.sensor->fov_x_deg == 0.1 &&
                     s.sensor->fov_y_deg == 179.9 && s.sensor->columns == 1 &&
                     s.sensor->rows == 65536;
            }},
           {{{"crop_box", List{-1, -2, -3, 0, 0.5, 4}}},
            [](const Settings& s) {
              return s.crop_box->min == std::array<double, 3>{-1, -2, -3} &&
                     s.crop_box->max == std::array<double, 3>{0, 0.5, 4};
            }},
           {{{"remove_outliers", true}, {"min_log_odds", -2.5}},
            [](const Settings& s) {
              return s.outlier_removal->min_log_odds == -2.5f &&
                     densityUnitOf(s.outlier_removal->unit) == DensityUnit::Automatic;
            }},
           {{{"min_log_odds", 2.0}},
            [](const Settings& s) { return !s.outlier_removal.has_value(); }},
           {{{"queue_size", 0}}, // of another table
            [](const Settings& s) { return s.law == Settings().law && !s.sensor; }}}) {
    EXPECT_TRUE(isSet(settingsOf(values))) << values.begin()->first;
    for (const auto& value : values)
      names.insert(value.first);
  }
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    names.insert(setting.id);
  for (const ParameterDescription& parameter : encodingParameters())
    EXPECT_EQ(names.count(parameter.name), 1u) << parameter.name;
  const SensorNodeSettings usual = settingsOf(defaultsOf(encodingParameters()));
  EXPECT_EQ(usual.law, SensorNodeSettings().law);
  EXPECT_EQ(usual.intensity_field, SensorNodeSettings().intensity_field);
  EXPECT_FALSE(usual.sensor || usual.crop_box || usual.outlier_removal);
}

TEST(EncodingParameters, AutomaticIsNativeWhereCloudsHaveIntensities)
{
  for (const ParameterValues& values :
       {ParameterValues{}, ParameterValues{{"intensity", "automatic"}}}) {
    EXPECT_EQ(settingsOf(values, false).law, IntensityLaw::None);
    EXPECT_EQ(settingsOf(values, true).law, IntensityLaw::Native);
  }
  EXPECT_EQ(settingsOf({{"intensity", "count"}}, true).law, IntensityLaw::Count);
  EXPECT_EQ(settingsOf({{"intensity", "native"}}, false).law, IntensityLaw::Native);
}

struct EncodingFault {
  ParameterValues values;
  std::string line;
};

TEST(EncodingParameters, FaultsAreNamedInOneLineAndChangeNothing)
{
  const std::string all_numbers =
      "sensor_fov_x_deg, sensor_fov_y_deg, sensor_columns and sensor_rows";
  for (const EncodingFault& fault : std::vector<EncodingFault>{
           {{{"effort", "quick"}},
            "effort is 'quick'; it must be one of: fast, balanced, small"},
           {{{"intensity", "quadratic"}},
            "sensor is not set; it must be set, by name or by numbers, for intensity: "
            "quadratic"},
           {{{"intensity", "linear"}},
            "sensor is not set; it must be set, by name or by numbers, for intensity: "
            "linear"},
           {{{"sensor_rows", 480}},
            "sensor is not set; it must be set, or else all of " + all_numbers},
           {{{"sensor", "kinect_v2"}, {"sensor_fov_x_deg", 60.0}},
            "sensor is 'kinect_v2'; it must be unset where one is set of " +
                all_numbers},
           {{{"crop_box", List{0, 0, 0, 1, 1, 0}}},
            "crop_box is [0, 0, 0, 1, 1, 0]; it must be [x0, y0, z0, x1, y1, z1], the "
            "first three below the others"},
           {{{"format", "published"}, {"intensity_bits", 4}},
            "intensity_bits is 4; it must be 8, or 0 for automatic, in the published "
            "layout"},
           {{{"fields", "ring:-1"}},
            "fields is 'ring:-1'; it must be names with commas between them, each with "
            ":STEP above 0 if it has one, or all"},
           {{{"temporal_filter", 8}, {"keep_points", true}},
            "keep_points is on; it must be off with temporal_filter"}}) {
    SensorNodeSettings settings;
    settings.compression.resolution = 0.125;
    const ParameterValues before = codecValues(settings.compression);
    EXPECT_EQ(readEncodingParameters(fault.values, false, settings), fault.line);
    EXPECT_EQ(codecValues(settings.compression), before);
    EXPECT_FALSE(settings.sensor || settings.crop_box || settings.outlier_removal);
    EXPECT_EQ(readEncodingParameters(fault.values, true, settings), fault.line);
    EXPECT_EQ(faultOfEncodingParameters(fault.values), fault.line);
  }
}

TEST(CentralNodeParameters, DefaultsGiveTheDefaultSettings)
{
  const MergingCentreSettings defaults;
  for (const ParameterValues& values :
       {ParameterValues{}, defaultsOf(centralNodeParameters())}) {
    const auto settings = readCentralNodeParameters(values, systemTime);
    EXPECT_EQ(settings.node.resolution, defaults.node.resolution);
    EXPECT_EQ(settings.node.threads, defaults.node.threads);
    EXPECT_EQ(settings.node.max_waiting_frames, defaults.node.max_waiting_frames);
    EXPECT_EQ(settings.node.max_merge_age, defaults.node.max_merge_age);
    EXPECT_EQ(settings.schedule.period, defaults.schedule.period);
    EXPECT_EQ(settings.schedule.max_wait, defaults.schedule.max_wait);
    EXPECT_EQ(settings.schedule.max_age, defaults.schedule.max_age);
    EXPECT_TRUE(settings.reports_resolution);
  }
}

TEST(CentralNodeParameters, EachChangesTheSettingThatItNames)
{
  const auto settings = readCentralNodeParameters({{"resolution", 0.5},
                                                   {"threads", 3},
                                                   {"max_waiting_frames", 7},
                                                   {"merge_rate", 20.0},
                                                   {"merge_wait", 0.125},
                                                   {"max_merge_age", 0.25}},
                                                  [] { return Time(5); });
  using std::chrono::milliseconds;
  EXPECT_EQ(settings.node.resolution, 0.5);
  EXPECT_EQ(settings.node.threads, 3u);
  EXPECT_EQ(settings.node.max_waiting_frames, 7u);
  EXPECT_EQ(settings.schedule.period, milliseconds(50));
  EXPECT_EQ(settings.schedule.max_wait, milliseconds(125));
  EXPECT_EQ(settings.schedule.max_age, milliseconds(250));
  EXPECT_EQ(settings.node.max_merge_age, milliseconds(250));
  EXPECT_EQ(settings.node.clock(), Time(5));
  // All that the tables allow can be scheduled.
  for (const double rate : {0.0, 1e-9, 1000.0})
    EXPECT_EQ(
        faultOf(readCentralNodeParameters({{"merge_rate", rate}}, systemTime).schedule),
        "");
  ParameterValues no_merging{{"merge_rate", 0.0}};
  EXPECT_FALSE(readCentralNodeParameters(no_merging, systemTime).reports_resolution);
  no_merging["map_path"] = std::string("map.ot");
  EXPECT_TRUE(readCentralNodeParameters(no_merging, systemTime).reports_resolution);
}

TEST(NoiseParameters, DefaultsKeepAllVoxels)
{
  for (const ParameterValues& values :
       {ParameterValues{}, defaultsOf(noiseParameters())}) {
    const NoiseSettings settings = readNoiseParameters(values);
    EXPECT_EQ(settings.min_intensity, 0.0f);
    EXPECT_EQ(settings.lowestIntensity(), CentralNode::lowest_intensity);
    EXPECT_FALSE(settings.outlier_removal);
    EXPECT_FALSE(settings.is_packed);
  }
}

TEST(NoiseParameters, EachChangesTheSettingThatItNames)
{
  EXPECT_EQ(readNoiseParameters({{"min_intensity", -1.5}}).lowestIntensity(), -1.5f);
  const auto removal = readNoiseParameters({{"remove_outliers", true}}).outlier_removal;
  ASSERT_TRUE(removal);
  EXPECT_TRUE(readNoiseParameters({{"packed", true}}).is_packed);
  EXPECT_EQ(removal->min_log_odds, 0.0f);
  EXPECT_EQ(densityUnitOf(removal->unit), DensityUnit::Automatic);
  for (const auto& [word, unit] : std::vector<std::pair<std::string, DensityUnit>>{
           {"automatic", DensityUnit::Automatic},
           {"faces", DensityUnit::Faces},
           {"points", DensityUnit::Points},
           {"voxels", DensityUnit::Voxels},
           {"rays", DensityUnit::Rays}}) {
    const NoiseSettings settings = readNoiseParameters(
        {{"remove_outliers", true}, {"min_log_odds", 2.5}, {"density_unit", word}});
    ASSERT_TRUE(settings.outlier_removal) << word;
    EXPECT_EQ(settings.outlier_removal->min_log_odds, 2.5f);
    EXPECT_EQ(densityUnitOf(settings.outlier_removal->unit), unit) << word;
  }
}

} // namespace encoding_parameters

} // namespace
