// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_settings.h"

#include "keywords.h"
#include "outliers/outlier_setting_table.h"
#include "stream/encoder_setting.h"
#include "stream/setting_checks.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace pcl_ext::python {

namespace {

// Any, except for what does not fit into the type.
constexpr std::size_t any_size =
    static_cast<std::size_t>(std::numeric_limits<std::ptrdiff_t>::max()) - 1;

constexpr char field_demand[] =
    "'all', a name, a sequence of names and (name, step) pairs, or a dict of steps by "
    "name";

template <typename StatusT>
void
throwUnlessOk(const StatusT& status)
{
  if (!status.ok())
    throw py::value_error(status.message());
}

std::array<double, 3>
pointOf(const std::vector<double>& numbers)
{
  return {numbers[0], numbers[1], numbers[2]};
}

/** \brief The six numbers of two corners. */
std::vector<double>
readCorners(const Keywords& values, const char* name)
{
  const py::object box = values.at(name);
  const bool is_list = py::isinstance<py::sequence>(box) || py::hasattr(box, "shape");
  if (!is_list || PyObject_Size(box.ptr()) != 2) {
    PyErr_Clear(); // of an array without dimensions, which has no size
    values.refuse(name, "two corners, (min, max)");
  }
  std::vector<double> corners;
  for (const auto& [which, index] : {std::pair("lower", 0), std::pair("upper", 1)}) {
    const std::string corner = std::string("the ") + which + " corner of " + name;
    const auto numbers = numbersOf(corner.c_str(), box[py::int_(index)], 3);
    corners.insert(corners.end(), numbers.begin(), numbers.end());
  }
  return corners;
}

RuntimeSensor
readSensor(const Keywords& values)
{
  if (py::isinstance<py::str>(values.at("sensor"))) {
    const auto sensor = valueNamed(named_sensors, values.text("sensor"));
    if (!sensor)
      values.refuse("sensor",
                    "its name (" + namesOf(named_sensors) +
                        ") or (fov_x_deg, fov_y_deg, columns, rows)");
    return *sensor;
  }
  const std::vector<double> figures = values.numbers("sensor", 4);
  const auto pixels = [&](double number) {
    if (!(number >= 0.0 && number <= 1 << 16) || number != std::floor(number))
      values.refuse("sensor",
                    "1 to 65536 whole columns and rows, after the field of view");
    return static_cast<unsigned int>(number);
  };
  try {
    return {figures[0], figures[1], pixels(figures[2]), pixels(figures[3])};
  }
  catch (const std::invalid_argument& error) {
    throw py::value_error(std::string("sensor: ") + error.what());
  }
}

std::optional<io::DepthLaw>
readDepthLaw(const Keywords& values)
{
  if (!values.isSet("depth_law"))
    return std::nullopt;
  const std::vector<double> law = values.numbers("depth_law", 3);
  if (law[0] != 1.0 && law[0] != 2.0)
    values.refuse("depth_law", "an exponent of 1 or 2, a depth and an intensity");
  return io::DepthLaw{static_cast<unsigned int>(law[0]), law[1], law[2]};
}

/** \brief One field: its name, or a pair of name and step. */
io::FieldSetting
readField(const Keywords& values, py::object name)
{
  py::object step = py::none();
  if (py::isinstance<py::tuple>(name) && py::len(name) == 2) {
    step = name[py::int_(1)];
    name = name[py::int_(0)];
  }
  if (!py::isinstance<py::str>(name) || !hasBytes(name))
    values.refuse("fields", field_demand);
  io::FieldSetting field{name.cast<std::string>()};
  if (!step.is_none())
    field.step = numberOf("the step of '" + field.name + "' in fields", step);
  return field;
}

std::vector<io::FieldSetting>
readFields(const Keywords& values)
{
  py::object fields = values.at("fields");
  if (py::isinstance<py::str>(fields))
    return {readField(values, fields)};
  if (py::isinstance<py::dict>(fields))
    fields = py::list(fields.attr("items")());
  if (!py::isinstance<py::sequence>(fields))
    values.refuseType("fields", field_demand);
  std::vector<io::FieldSetting> settings;
  for (const py::handle& field : fields)
    settings.push_back(readField(values, py::reinterpret_borrow<py::object>(field)));
  return settings;
}

/** \brief The value of a keyword, of the type that its setting has. */
io::SettingValue
readValue(const Keywords& values, const io::EncoderSetting& setting)
{
  const char* const name = setting.id.c_str();
  const io::SettingValue usual = valueOf(setting, io::EncoderSettings());
  if (std::holds_alternative<bool>(usual))
    return values.flag(name);
  if (std::holds_alternative<std::int64_t>(usual))
    return static_cast<std::int64_t>(values.count(
        name,
        setting.range.zero.empty() ? static_cast<std::size_t>(setting.range.lowest) : 0,
        static_cast<std::size_t>(setting.range.highest)));
  if (std::holds_alternative<double>(usual))
    return values.number(name);
  if (std::holds_alternative<std::string>(usual))
    return values.text(name);
  if (!values.isSet(name))
    return std::vector<double>();
  const std::size_t size = listSizeOf(setting);
  return size == 6 ? readCorners(values, name) : values.numbers(name, size);
}

io::EncoderSettings
readCodecSettings(const Keywords& values)
{
  io::EncoderSettings settings;
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    if (setting.id == "fields")
      settings.fields = readFields(values);
    else if (setting.not_offered.keyword.empty() &&
             !setValue(setting, readValue(values, setting), settings).ok())
      values.refuse(setting.id.c_str(), demandOf(setting));
  return settings;
}

/** \brief Refuses settings that contradict each other, of which the codec itself would
 * tell with each cloud, or not at all. */
void
refuseContradictions(const Keywords& keywords, const ArrayEncoderSettings& settings)
{
  const io::EncoderSettings& codec = settings.codec;
  if (settings.law)
    if (const auto fault = io::lawFault(codec, *settings.law))
      throw py::value_error(fault->withIds());
  for (const io::EncoderSetting& setting : io::encoderSettingTable()) {
    if (valueOf(setting, codec) == valueOf(setting, io::EncoderSettings()))
      continue;
    if (const SettingText need = unmetNeedOf(setting, codec); !need.marked.empty())
      keywords.refuse(setting.id.c_str(), "left out without " + need.withIds());
    if (settings.law == IntensityLaw::None && needsIntensities(setting))
      keywords.refuse(setting.id.c_str(), "left out with the law 'none'");
  }
  if (settings.law && settings.law != IntensityLaw::Native && settings.depth_law)
    keywords.refuse("depth_law", "None with the law '" + nameOf(*settings.law) + '\'');
  if (codec.format == io::StreamFormat::Published && keywords.isSet("frame_id"))
    keywords.refuse("frame_id", "None in the published layout");
  if (!codec.use_coordinate_step)
    return;
  const auto refuse_with = [&](bool is_so, const char* what) {
    if (is_so)
      keywords.refuse("use_coordinate_step", std::string("False with ") + what);
  };
  refuse_with(settings.law && needsSensor(*settings.law),
              "the laws quadratic and linear");
  refuse_with(codec.origin.has_value(), "origin");
  refuse_with(codec.bounding_box.has_value(), "bounding_box");
  refuse_with(codec.keep_order, "keep_order");
  refuse_with(codec.format == io::StreamFormat::Published, "format='published'");
}

/** \brief A value as the default of a keyword. */
py::object
toPython(const io::SettingValue& value)
{
  if (std::holds_alternative<std::vector<double>>(value))
    return py::none();
  return std::visit([](const auto& content) { return py::cast(content); }, value);
}

/** \brief Reads a setting, by the type of its field. */
template <typename ValueT>
void
readValue(const Keywords& keywords, const char* name, ValueT& value)
{
  if constexpr (std::is_same_v<ValueT, bool>)
    value = keywords.flag(name);
  else if constexpr (std::is_integral_v<ValueT>)
    value = keywords.count(name, 0, any_size);
  else if constexpr (std::is_floating_point_v<ValueT>)
    value = static_cast<ValueT>(keywords.number(name));
  else
    value = pointOf(keywords.numbers(name, 3));
}

/** \brief Reads the settings of an outlier removal, whose unit is set. */
template <typename SettingsT>
void
readEach(const py::dict& values, SettingsT& settings)
{
  const Keywords keywords(values);
  std::set<std::string> names = {"unit"};
  visitSettings(settings, [&](const OutlierSetting& setting, auto& value) {
    names.insert(setting.name);
    if (values.contains(setting.name))
      readValue(keywords, setting.name, value);
  });
  for (const auto& [key, value] : values)
    if (const std::string name = py::str(key); names.count(name) == 0)
      keywords.refuse(name.c_str(),
                      "left out, as the unit " + keywords.text("unit") +
                          " does not have it");
  throwUnlessOk(checkSettings(settings));
}

} // namespace

WorldPose
readPose(const py::object& matrix)
{
  const auto numbers =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(matrix);
  if (!numbers || numbers.ndim() != 2 || numbers.shape(0) != 4 || numbers.shape(1) != 4)
    throw py::value_error("sensor_pose must be an array of 4 x 4 numbers");
  Eigen::Matrix4d values;
  for (Eigen::Index row = 0; row < 4; ++row)
    for (Eigen::Index column = 0; column < 4; ++column)
      values(row, column) = numbers.at(row, column);
  const Eigen::Isometry3d pose(values);
  if (values.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0) ||
      !isRigid(pose.cast<float>()))
    throw py::value_error("sensor_pose is not a rotation and a translation (sensor -> "
                          "cloud, metres, last row 0, 0, 0, 1)");
  return WorldPose(pose);
}

ArrayEncoderSettings
readArrayEncoderSettings(const py::dict& values)
{
  const Keywords keywords(values);
  ArrayEncoderSettings settings;
  settings.codec = readCodecSettings(keywords);
  settings.depth_law = readDepthLaw(keywords);
  throwUnlessOk(io::checkSettings(settings.codec, settings.depth_law));
  settings.law = keywords.choice("law", lawChoices());
  if (keywords.isSet("sensor"))
    settings.sensor = readSensor(keywords);
  if (keywords.isSet("sensor_pose"))
    settings.sensor_pose = readPose(keywords.at("sensor_pose"));
  if (settings.law && needsSensor(*settings.law) && !settings.sensor)
    throw py::value_error("the law '" + nameOf(*settings.law) +
                          "' needs a sensor: its name, as 'kinect_v2', or (fov_x_deg, "
                          "fov_y_deg, columns, rows)");
  refuseContradictions(keywords, settings);
  return settings;
}

io::DecoderLimits
readLimits(const py::dict& values, const std::optional<io::DecoderLimits>& defaults)
{
  const Keywords keywords(values);
  io::DecoderLimits limits = defaults.value_or(io::DecoderLimits());
  const auto read = [&](const char* name, std::size_t highest, std::size_t& limit) {
    if (!defaults || keywords.isSet(name))
      limit = keywords.count(name, 1, highest);
  };
  read("max_frame_bytes", any_size, limits.max_frame_bytes);
  read("max_voxels", io::DecoderLimits::most_voxels, limits.max_voxels);
  read("max_points", any_size, limits.max_points);
  read("max_field_values", any_size, limits.max_field_values);
  return limits;
}

VoxelOutlierRemovalSettings
readRemovalSettings(const py::dict& values)
{
  VoxelOutlierRemovalSettings settings{
      densityUnitSettings(Keywords(values).choice("unit", density_units))};
  readEach(values, settings);
  return settings;
}

PointOutlierRemovalSettings
readPointRemovalSettings(const py::dict& values)
{
  PointOutlierRemovalSettings settings;
  readEach(values, settings);
  return settings;
}

TemporalFilterSettings
readTemporalFilterSettings(const py::dict& values)
{
  const Keywords keywords(values);
  TemporalFilterSettings settings;
  settings.frames = static_cast<unsigned int>(keywords.count(
      "frames", TemporalVoxelFilter::least_frames, TemporalVoxelFilter::most_frames));
  if (keywords.isSet("sensor_position")) {
    const std::vector<double> numbers = keywords.numbers("sensor_position", 3);
    if (!std::all_of(numbers.begin(), numbers.end(), [](double number) {
          return std::isfinite(number);
        }))
      keywords.refuse("sensor_position", "three finite numbers");
    settings.sensor_position = pointOf(numbers);
  }
  return settings;
}

py::list
encoderSettings()
{
  using namespace py::literals;
  py::list rows;
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    rows.append(
        py::dict("name"_a = setting.id,
                 "default"_a = setting.id == "fields"
                                   ? py::tuple()
                                   : toPython(valueOf(setting, io::EncoderSettings())),
                 "lowest"_a = setting.range.lowest,
                 "highest"_a = setting.range.highest,
                 "zero"_a = setting.range.zero,
                 "words"_a = wordsOf(setting),
                 "not_offered"_a = setting.not_offered.keyword));
  return rows;
}

py::dict
defaultSettings()
{
  using namespace py::literals;
  const io::DecoderLimits limits;
  const VoxelOutlierRemovalSettings removal;
  return py::dict("frames"_a = TemporalFilterSettings().frames,
                  "max_frame_bytes"_a = limits.max_frame_bytes,
                  "max_voxels"_a = limits.max_voxels,
                  "max_points"_a = limits.max_points,
                  "max_field_values"_a = limits.max_field_values,
                  "min_log_odds"_a = removal.min_log_odds,
                  "max_blocks"_a = removal.max_blocks);
}

} // namespace pcl_ext::python
