// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The settings that the parameters of encoding and of noise give.
 */
#include <pcl_ext/nodes/merging_centre.h>
#include <pcl_ext/nodes/node_parameters.h>

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace parameters_to_settings {

using pcl_ext::DensityUnit;
using pcl_ext::IntensityLaw;
using namespace pcl_ext::nodes;
namespace io = pcl_ext::io;

using List = std::vector<double>;

/** \brief The settings that values give, which must be allowed. */
SensorNodeSettings
settingsOf(const ParameterValues& values, bool has_intensities = false)
{
  SensorNodeSettings settings;
  EXPECT_EQ(readEncodingParameters(values, has_intensities, settings), "");
  return settings;
}

/** \brief All settings that the parameters of encoding set, in one text. */
std::string
textOfSettings(const SensorNodeSettings& settings)
{
  const io::EncoderSettings& codec = settings.compression;
  std::string all;
  const auto add = [&all](const char* name, double value) {
    all += std::string(name) + " " + textOf(value) + "\n";
  };
  add("resolution", codec.resolution);
  add("law", static_cast<int>(settings.law));
  all += "intensity_field " + settings.intensity_field + "\n";
  if (settings.sensor) {
    add("fov_x_deg", settings.sensor->fov_x_deg);
    add("fov_y_deg", settings.sensor->fov_y_deg);
    add("columns", settings.sensor->columns);
    add("rows", settings.sensor->rows);
  }
  add("effort", static_cast<int>(codec.effort));
  add("format", static_cast<int>(codec.format));
  add("i_frame_rate", codec.i_frame_rate);
  add("aggregation", static_cast<int>(codec.aggregation));
  add("intensity_bits", codec.intensity_bits);
  add("intensity_range", double{codec.intensity_range});
  add("intensity_curve", static_cast<int>(codec.intensity_curve));
  add("colour_bits", codec.colour_bits);
  add("keep_point_counts", codec.keep_point_counts);
  for (const io::FieldSetting& field : codec.fields)
    add(field.name.c_str(), field.step);
  add("coarsen_wide_clouds", codec.coarsen_wide_clouds);
  add("threads", codec.threads);
  add("temporal_filter", codec.temporal_filter);
  add("max_rate", codec.max_rate);
  add("rate_buffer", codec.rate_buffer);
  add("max_encode_ms", codec.max_encode_ms);
  add("rate_temporal_filter", codec.rate_temporal_filter);
  add("rate_doublings", codec.rate_doublings);
  add("rate_sent_share", codec.rate_sent_share);
  if (settings.crop_box)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add("min", settings.crop_box->min[axis]);
      add("max", settings.crop_box->max[axis]);
    }
  if (settings.outlier_removal) {
    add("min_log_odds", double{settings.outlier_removal->min_log_odds});
    add("unit", static_cast<int>(settings.outlier_removal->unit));
  }
  return all;
}

/** \brief Values, and how they change the settings. */
struct EncodingChange {
  ParameterValues values;
  std::function<void(SensorNodeSettings&)> change;
};

const std::vector<EncodingChange>&
encodingChanges()
{
  using Settings = SensorNodeSettings;
  static const std::vector<EncodingChange> changes = {
      {{{"resolution", 0.25}}, [](Settings& s) { s.compression.resolution = 0.25; }},
      {{{"resolution", 2}}, [](Settings& s) { s.compression.resolution = 2.0; }},
      {{{"intensity", "count"}}, [](Settings& s) { s.law = IntensityLaw::Count; }},
      {{{"intensity", "native"}}, [](Settings& s) { s.law = IntensityLaw::Native; }},
      {{{"intensity_field", "reflectivity"}},
       [](Settings& s) { s.intensity_field = "reflectivity"; }},
      {{{"intensity", "quadratic"}, {"sensor", "kinect_v1"}},
       [](Settings& s) {
         s.law = IntensityLaw::Quadratic;
         s.sensor.emplace(57.0, 43.0, 640u, 480u);
       }},
      {{{"intensity", "linear"},
        {"sensor_fov_x_deg", 0.1},
        {"sensor_fov_y_deg", 179.9},
        {"sensor_columns", 1},
        {"sensor_rows", 65536}},
       [](Settings& s) {
         s.law = IntensityLaw::Linear;
         s.sensor.emplace(0.1, 179.9, 1u, 65536u);
       }},
      {{{"effort", "small"}},
       [](Settings& s) { s.compression.effort = io::Effort::Small; }},
      {{{"effort", "fast"}},
       [](Settings& s) { s.compression.effort = io::Effort::Fast; }},
      {{{"format", "published"}},
       [](Settings& s) { s.compression.format = io::StreamFormat::Published; }},
      {{{"i_frame_rate", 2147483647}},
       [](Settings& s) { s.compression.i_frame_rate = 2147483647; }},
      {{{"aggregation", "mean"}},
       [](Settings& s) { s.compression.aggregation = io::Aggregation::Mean; }},
      {{{"aggregation", "sum"}},
       [](Settings& s) { s.compression.aggregation = io::Aggregation::Sum; }},
      {{{"intensity_bits", 16}},
       [](Settings& s) { s.compression.intensity_bits = 16; }},
      {{{"intensity_range", 0.5}},
       [](Settings& s) { s.compression.intensity_range = 0.5f; }},
      {{{"intensity_curve", "companded"}},
       [](Settings& s) {
         s.compression.intensity_curve = io::IntensityCurve::Companded;
       }},
      {{{"colour_bits", 0}}, [](Settings& s) { s.compression.colour_bits = 0; }},
      {{{"keep_point_counts", true}},
       [](Settings& s) { s.compression.keep_point_counts = true; }},
      {{{"fields", "ring,time:1e-6"}},
       [](Settings& s) {
         s.compression.fields = {{"ring"}, {"time", 1e-6}};
       }},
      {{{"coarsen_wide_clouds", true}},
       [](Settings& s) { s.compression.coarsen_wide_clouds = true; }},
      {{{"threads", 256}}, [](Settings& s) { s.compression.threads = 256; }},
      {{{"temporal_filter", 64}},
       [](Settings& s) { s.compression.temporal_filter = 64; }},
      {{{"max_rate", 1e12}, {"rate_buffer", 1}},
       [](Settings& s) {
         s.compression.max_rate = 1e12;
         s.compression.rate_buffer = 1.0;
       }},
      {{{"max_encode_ms", 0.1}},
       [](Settings& s) { s.compression.max_encode_ms = 0.1; }},
      {{{"rate_temporal_filter", 0}, {"rate_doublings", 8}, {"rate_sent_share", 0.5}},
       [](Settings& s) {
         s.compression.rate_temporal_filter = 0;
         s.compression.rate_doublings = 8;
         s.compression.rate_sent_share = 0.5;
       }},
      {{{"crop_box", List{-1, -2, -3, 0, 0.5, 4}}},
       [](Settings& s) {
         s.crop_box.emplace();
         s.crop_box->min = {-1, -2, -3};
         s.crop_box->max = {0, 0.5, 4};
       }},
      {{{"remove_outliers", true}}, [](Settings& s) { s.outlier_removal.emplace(); }},
      {{{"remove_outliers", true}, {"min_log_odds", -2.5}},
       [](Settings& s) { s.outlier_removal.emplace().min_log_odds = -2.5f; }}};
  return changes;
}

TEST(EncodingParameters, DefaultsGiveTheDefaultSettings)
{
  const std::string expected = textOfSettings(SensorNodeSettings());
  EXPECT_EQ(textOfSettings(settingsOf({})), expected);
  EXPECT_EQ(textOfSettings(settingsOf(defaultsOf(encodingParameters()))), expected);
}

TEST(EncodingParameters, DefaultsReplaceWhatTheSettingsWere)
{
  SensorNodeSettings settings;
  for (const EncodingChange& changed : encodingChanges())
    changed.change(settings);
  settings.global_frame = "hall";
  settings.carry_header = true;
  ASSERT_EQ(readEncodingParameters({}, false, settings), "");
  EXPECT_EQ(textOfSettings(settings), textOfSettings(SensorNodeSettings()));
  EXPECT_EQ(settings.global_frame, "hall");
  EXPECT_TRUE(settings.carry_header);
}

TEST(EncodingParameters, EachChangesTheSettingThatItNames)
{
  std::set<std::string> changed_names;
  for (const EncodingChange& changed : encodingChanges()) {
    SensorNodeSettings expected;
    changed.change(expected);
    EXPECT_EQ(textOfSettings(settingsOf(changed.values)), textOfSettings(expected));
    for (const auto& value : changed.values)
      changed_names.insert(value.first);
  }
  for (const ParameterDescription& parameter : encodingParameters())
    EXPECT_EQ(changed_names.count(parameter.name), 1u) << parameter.name;
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

TEST(EncodingParameters, SensorIsReadWithAnyLaw)
{
  ASSERT_TRUE(settingsOf({{"sensor", "azure_kinect_nfov"}}).sensor);
  EXPECT_EQ(settingsOf({{"sensor", "azure_kinect_nfov"}}).sensor->rows, 576u);
  EXPECT_EQ(settingsOf({{"sensor", "kinect_v2"}}).sensor->columns, 512u);
}

TEST(EncodingParameters, ValuesOfOtherParametersAreIgnored)
{
  EXPECT_EQ(textOfSettings(settingsOf({{"queue_size", 0}})),
            textOfSettings(SensorNodeSettings()));
}

struct EncodingFault {
  ParameterValues values;
  std::string line;
};

TEST(EncodingParameters, FaultsAreNamedInOneLineAndChangeNothing)
{
  const std::string all_numbers =
      "sensor_fov_x_deg, sensor_fov_y_deg, sensor_columns and sensor_rows";
  for (
      const EncodingFault& fault : std::vector<EncodingFault>{
          {{{"effort", "quick"}},
           "effort is 'quick'; it must be one of: fast, balanced, small"},
          {{{"threads", 4.0}}, "threads is 4; it must be a whole number from 1 to 256"},
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
          {{{"crop_box", List{-1, 0, 0, 1e6, 1, 1}}},
           "crop_box as bounding_box is 1000001.000000 m wide; it must be no wider "
           "than 2^21 - 1 voxels"},
          {{{"remove_outliers", true}, {"resolution", 0.25}},
           "resolution is 0.25; it must be a number from 0.001 to 0.2 for outliers to "
           "be removed"},
          {{{"format", "published"}, {"intensity_bits", 4}},
           "intensity_bits is 4; it must be 8, or 0 for automatic, in the published "
           "layout"},
          {{{"format", "published"}, {"intensity_range", 1}},
           "intensity_range is 1; it must be 255, or 0 for automatic, in the published "
           "layout"},
          {{{"format", "published"}, {"intensity_curve", "companded"}},
           "intensity_curve is companded; it must be linear in the published layout"},
          {{{"format", "published"}, {"keep_point_counts", true}},
           "keep_point_counts is on; it must be off in the published layout"},
          {{{"fields", "ring:-1"}},
           "fields is 'ring:-1'; it must be names with commas between them, each with "
           ":STEP above 0 if it has one, or all"},
          {{{"max_rate", 999}},
           "max_rate is 999; it must be a number from 1000 to 1e+12, or 0"},
          {{{"rate_temporal_filter", 1}},
           "rate_temporal_filter is 1; it must be 2 to 64 frames, or 0 for none"},
          {{{"temporal_filter", 8}, {"fields", "all"}},
           "fields is set; it must be empty with temporal_filter"},
          {{{"temporal_filter", 8}, {"keep_point_counts", true}},
           "keep_point_counts is on; it must be off with temporal_filter"}}) {
    SensorNodeSettings settings;
    settings.compression.resolution = 0.125;
    const std::string before = textOfSettings(settings);
    EXPECT_EQ(readEncodingParameters(fault.values, false, settings), fault.line);
    EXPECT_EQ(textOfSettings(settings), before);
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
  EXPECT_FALSE(
      readCentralNodeParameters({{"merge_rate", 0.0}}, systemTime).reports_resolution);
}

TEST(EncodingParameters, MinLogOddsWithoutOutlierRemovalHaveNoEffect)
{
  EXPECT_FALSE(settingsOf({{"min_log_odds", 2.0}}).outlier_removal);
}

TEST(NoiseParameters, DefaultsKeepAllVoxels)
{
  for (const ParameterValues& values :
       {ParameterValues{}, defaultsOf(noiseParameters())}) {
    const NoiseSettings settings = readNoiseParameters(values);
    EXPECT_EQ(settings.min_intensity, 0.0f);
    EXPECT_FALSE(settings.outlier_removal);
  }
}

TEST(NoiseParameters, EachChangesTheSettingThatItNames)
{
  EXPECT_EQ(readNoiseParameters({{"min_intensity", -1.5}}).min_intensity, -1.5f);
  const auto removal = readNoiseParameters({{"remove_outliers", true}}).outlier_removal;
  ASSERT_TRUE(removal);
  EXPECT_EQ(removal->min_log_odds, 0.0f);
  EXPECT_EQ(removal->unit, DensityUnit::Automatic);
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
    EXPECT_EQ(settings.outlier_removal->unit, unit) << word;
  }
}

} // namespace parameters_to_settings

} // namespace
