// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/encoding_options.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "console/exit_status.h"
#include "options/setting_options.h"
#include "simulator/crop_box.h"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <sstream>
#include <string>

namespace pcl_ext::tools {

namespace {

/** \brief The name of a stream before a pose, and the pose. */
std::pair<std::string, WorldPose>
parseNamedPose(const std::string& text)
{
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos)
    return {"", parsePose(text)};
  return {text.substr(0, equals), parsePose(text.substr(equals + 1))};
}

/** \brief True if the stream that a pose is given for is this one; the slash at its
 * beginning may be left out. */
bool
isPoseOf(const std::string& given, const std::string& stream)
{
  return given == stream || (!given.empty() && '/' + given == stream);
}

/** \brief Options for the intensities of voxels. */
std::vector<std::string>
scaleOptions()
{
  std::vector<std::string> options;
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    if (needsIntensities(setting))
      options.push_back(optionOf(setting.id));
  return options;
}

/** \brief Numbers with commas between them, which are read as the same numbers. */
std::string
textOf(std::initializer_list<double> numbers)
{
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  const char* separator = "";
  for (const double number : numbers) {
    text << separator << number;
    separator = ",";
  }
  return text.str();
}

} // namespace

void
addOutlierRemoval(CLI::App& app,
                  const std::string& description,
                  bool& removes_outliers,
                  const std::string& unit_description,
                  DensityUnit& unit)
{
  CLI::Option* const removal =
      app.add_flag("--remove-outliers", removes_outliers, description);
  addChoice(app, "--unit", density_units, unit, unit_description)->needs(removal);
}

void
EncodingOptions::addCodecOptions(CLI::App& app)
{
  app_ = &app;
  codec_.decoder_limits.max_voxels = io::DecoderLimits::most_voxels; // of readers
  addChoice(app,
            "-l,--law",
            lawChoices(),
            law_,
            "intensity of voxels: native: the clouds' own; count: points; quadratic, "
            "linear: share of a face, needs --sensor; automatic: native, else none, "
            "also if --fields has it");
  addParsed(app,
            "--sensor",
            "SENSOR",
            namesOf(named_sensors) + " or deg,deg,columns,rows",
            [this](const std::string& text) { sensor_ = parseSensor(text); });
  addSettingOptions(app, io::encoderSettingTable(), io::OptionGroup::Codec, codec_);
  app.add_flag_callback(
      "--no-header",
      [this] { carries_header_ = false; },
      "frames without stamp and frame_id");
}

void
EncodingOptions::addBudget(CLI::App& app)
{
  addSettingOptions(app, io::encoderSettingTable(), io::OptionGroup::Budget, codec_);
  has_budget_ = true;
}

void
EncodingOptions::addCropOption(CLI::App& app)
{
  addParsed(app,
            "--crop",
            "BOX",
            "keep only x0,y0,z0,x1,y1,z1 of the world, metres",
            [this](const std::string& text) { crop_box_ = parseBox("crop", text); });
}

void
EncodingOptions::addCloudOptions(CLI::App& app)
{
  app.add_option_function<std::vector<std::string>>(
         "--pose",
         [this](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) {
             poses_.push_back(parseNamedPose(text));
             const std::string& name = poses_.back().first;
             if (std::count_if(
                     poses_.begin(), poses_.end(), [&name](const auto& other) {
                       return other.first == name;
                     }) > 1)
               throw UsageError("--pose is given twice for " +
                                (name.empty() ? "all streams" : "'" + name + "'") +
                                "; STREAM=POSE is the pose of one");
           }
         },
         "sensor -> world: x,y,z,roll,pitch,yaw (degrees), x,y,z,qx,qy,qz,qw or a "
         "matrix; STREAM=POSE for one stream")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("POSE");
  addCropOption(app);
  addOutlierRemoval(app,
                    "leave out noise before encoding",
                    removes_outliers_,
                    "for --remove-outliers of voxels",
                    unit_);
  app.add_option("--intensity-field",
                 intensity_field_,
                 "field that --law native reads (intensity)")
      ->type_name("NAME");
  app.add_option(
         "--frame-id", frame_id_, "frame_id after --pose, as map (that of the clouds)")
      ->type_name("NAME");
  addSettingOptions(app, io::encoderSettingTable(), io::OptionGroup::Cloud, codec_);
}

void
EncodingOptions::completeForCell()
{
  if (!crop_box_)
    crop_box_ = cell::cropBox();
  if (!sensor_)
    sensor_ = runtimeSensor(KinectV2());
}

void
EncodingOptions::checkEffects() const
{
  if (!law_ || !needsSensor(*law_))
    refuseOptions(*app_,
                  {"--sensor"},
                  "has no effect on this law: add --law quadratic or --law linear");
  if (law_ && needsSensor(*law_))
    refuseOptions(*app_,
                  {"--coarsen", "--use-coordinate-step"},
                  "has no effect with this law, which is made for voxels of one size: "
                  "leave it out");
  if (law_ && *law_ != IntensityLaw::Native)
    refuseOptions(*app_,
                  {"--intensity-field"},
                  std::string("has no effect with --law ") + nameOf(*law_) +
                      ", which makes intensities of its own: leave one of them out");
  if (law_ == IntensityLaw::None)
    refuseOptions(
        *app_, scaleOptions(), "has no effect with --law none: leave one of them out");
  if (codec_.origin || codec_.bounding_box || crop_box_)
    refuseOptions(
        *app_,
        {"--use-coordinate-step"},
        "has no effect with --origin, --bounding-box or --crop, which fix the "
        "grid: leave one of them out");
  if (codec_.keep_order) {
    refuseOptions(*app_,
                  {"--coarsen"},
                  "has no effect with --keep-order, which has no voxels: leave one of "
                  "them out");
    refuseOptions(*app_,
                  {"--use-coordinate-step"},
                  "has no effect with --keep-order, which uses the step of coordinates "
                  "where they have one: leave it out");
  }
  if (codec_.format == io::StreamFormat::Published) {
    refuseOptions(*app_,
                  {"--effort", "--coarsen", "--use-coordinate-step"},
                  "has no effect with --format published: leave one of them out");
    if (codec_.colour_bits > 0)
      refuseOptions(
          *app_,
          {"--colour-bits"},
          "has no effect with --format published, which has no colours: leave "
          "one of them out");
  }
}

void
EncodingOptions::checkFrameId(bool has_messages) const
{
  const bool has_header =
      carries_header_ && codec_.format == io::StreamFormat::Version1;
  if (!has_messages && !has_header)
    refuseOptions(*app_,
                  {"--frame-id"},
                  "has no effect without headers of frames: leave out --no-header or "
                  "--format published, or name x.mcap");
}

void
EncodingOptions::checkBudget() const
{
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    if (const SettingText need = unmetNeedOf(setting, codec_); !need.marked.empty())
      refuseOptions(*app_,
                    {optionOf(setting.id)},
                    "has no effect without a limit: add " + need.with(optionOf));
}

void
EncodingOptions::check() const
{
  checkEffects();
  if (has_budget_)
    checkBudget();
  const auto fault_of = [this](IntensityLaw law) -> std::string {
    const nodes::SensorNode node(nodeSettings(law, {}));
    return node.settingsStatus().ok() ? "" : messageOf(node.settingsStatus());
  };
  // Without --law the first cloud decides between native and none; what native takes is
  // refused, if at all, when it is known.
  const IntensityLaw usual =
      codec_.keep_order ? IntensityLaw::Native : IntensityLaw::Count;
  const std::string fault = fault_of(law_.value_or(usual));
  if (!fault.empty() && (law_ || !fault_of(IntensityLaw::Native).empty()))
    throw UsageError(fault);
}

IntensityLaw
EncodingOptions::lawOf(const pcl::PCLPointCloud2& cloud) const
{
  if (law_ && *law_ != IntensityLaw::Native)
    return *law_;
  const bool has_intensity = hasReadableField(cloud, intensityField());
  if (!has_intensity && (law_ || !intensity_field_.empty()))
    throw UsageError(
        "the clouds have no field '" + intensityField() +
        "' that can be read, which --law native reads; name another one with "
        "--intensity-field, or another --law");
  if (!has_intensity)
    refuseOptions(
        *app_,
        scaleOptions(),
        "has no effect on clouds without intensities: leave it out, or add --law "
        "count");
  return automaticLaw(has_intensity && !keepsIntensityAsField(cloud));
}

clouds::LongIntegers
EncodingOptions::longIntegers() const
{
  clouds::LongIntegers long_integers;
  long_integers.one_of_several = !codec_.keepsPoints();
  for (const io::FieldSetting& field : codec_.fields)
    if (field.step > 0.0)
      long_integers.with_step.push_back(field.name);
  return long_integers;
}

bool
EncodingOptions::keepsField(const std::string& name) const
{
  return std::any_of(
      codec_.fields.begin(), codec_.fields.end(), [&name](const auto& setting) {
        return setting.name == name || setting.name == io::all_fields;
      });
}

bool
EncodingOptions::keepsIntensityAsField(const pcl::PCLPointCloud2& cloud) const
{
  std::vector<std::string> of_voxels = scaleOptions();
  of_voxels.insert(of_voxels.end(), {"--law", "--intensity-field"});
  if (std::any_of(of_voxels.begin(), of_voxels.end(), [this](const std::string& name) {
        return isGiven(*app_, name);
      }))
    return false;
  const std::vector<FoundField> offered = findFields(cloud);
  return keepsField("intensity") &&
         std::any_of(offered.begin(), offered.end(), [](const FoundField& field) {
           return field.description.name == "intensity" &&
                  io::isField(field.description);
         });
}

void
EncodingOptions::checkStreams(const std::vector<std::string>& streams) const
{
  for (const auto& [name, pose] : poses_)
    if (const std::string& given = name;
        !name.empty() &&
        std::none_of(streams.begin(), streams.end(), [&given](const auto& stream) {
          return isPoseOf(given, stream);
        })) {
      std::string known;
      for (const std::string& stream : streams)
        known += (known.empty() ? "" : ", ") + stream;
      throw UsageError("--pose: there is no stream '" + name + "'; there are " + known);
    }
}

nodes::SensorNodeSettings
EncodingOptions::nodeSettings(IntensityLaw law,
                              const std::optional<std::string>& frame_id) const
{
  nodes::SensorNodeSettings settings;
  settings.compression = codec_;
  // The published layout has no field for it.
  settings.carry_header =
      carries_header_ && codec_.format == io::StreamFormat::Version1;
  const bool keeps_colours = std::any_of(
      codec_.fields.begin(), codec_.fields.end(), [](const io::FieldSetting& field) {
        return field.name == "rgb" || field.name == "rgba";
      });
  if (codec_.format == io::StreamFormat::Published ||
      (keeps_colours && !isGiven(*app_, "--colour-bits")))
    settings.compression.colour_bits = 0;
  settings.law = law;
  settings.sensor = sensor_;
  settings.intensity_field = intensityField();
  settings.crop_box = crop_box_;
  settings.global_frame = frame_id_.empty() ? frame_id.value_or("world") : frame_id_;
  if (removes_outliers_) {
    settings.outlier_removal.emplace();
    settings.outlier_removal->unit = densityUnitSettings(unit_);
  }
  return settings;
}

WorldPose
EncodingOptions::poseOf(const std::string& stream) const
{
  WorldPose pose = WorldPose::Identity();
  for (const auto& [name, named_pose] : poses_)
    if (isPoseOf(name, stream))
      return named_pose;
    else if (name.empty())
      pose = named_pose;
  return pose;
}

bool
EncodingOptions::hasPose(const std::string& stream) const
{
  return std::any_of(poses_.begin(), poses_.end(), [&stream](const auto& pose) {
    return pose.first.empty() || isPoseOf(pose.first, stream);
  });
}

StreamMetadata
EncodingOptions::metadataOf(const std::string& stream,
                            IntensityLaw law,
                            bool is_of_lidar) const
{
  StreamMetadata metadata = {{law_metadata, nameOf(law)}};
  if (is_of_lidar)
    metadata[sensor_metadata] = lidar_sensor;
  if (crop_box_) {
    const auto& min = crop_box_->min;
    const auto& max = crop_box_->max;
    metadata[crop_box_metadata] =
        textOf({min[0], min[1], min[2], max[0], max[1], max[2]});
  }
  if (!hasPose(stream))
    return metadata;
  const WorldPose pose = poseOf(stream);
  const Eigen::Quaterniond rotation(pose.linear());
  metadata[pose_metadata] = textOf({pose.translation().x(),
                                    pose.translation().y(),
                                    pose.translation().z(),
                                    rotation.x(),
                                    rotation.y(),
                                    rotation.z(),
                                    rotation.w()});
  return metadata;
}

} // namespace pcl_ext::tools
