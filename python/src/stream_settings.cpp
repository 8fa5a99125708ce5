// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_settings.h"

#include "keywords.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace pcl_ext {
namespace python {

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

io::BoundingBox
readBox(const Keywords& values)
{
  const py::object box = values.at("bounding_box");
  if (!py::isinstance<py::sequence>(box) && !py::hasattr(box, "shape"))
    values.refuse("bounding_box", "two corners, (min, max)");
  if (py::len(box) != 2)
    values.refuse("bounding_box", "two corners, (min, max)");
  return {pointOf(numbersOf("the lower corner of bounding_box", box[py::int_(0)], 3)),
          pointOf(numbersOf("the upper corner of bounding_box", box[py::int_(1)], 3))};
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
    if (!(number >= 0.0 && number <= 1 << 16))
      values.refuse("sensor", "1 to 65536 columns and rows, after the field of view");
    return static_cast<unsigned int>(number);
  };
  try {
    return {figures[0], figures[1], pixels(figures[2]), pixels(figures[3])};
  }
  catch (const std::invalid_argument& error) {
    throw py::value_error(std::string("sensor: ") + error.what());
  }
}

void
readIntensityCoding(const Keywords& values, io::IntensitySettings& settings)
{
  settings.aggregation = values.choice("aggregation", io::aggregations);
  settings.intensity_range = static_cast<float>(values.number("intensity_range"));
  settings.intensity_bits = values.smallCount("intensity_bits");
  settings.intensity_curve = values.choice("intensity_curve", io::intensity_curves);
}

std::optional<io::DepthLaw>
readDepthLaw(const Keywords& values)
{
  if (!values.isSet("depth_law"))
    return std::nullopt;
  const std::vector<double> law = values.numbers("depth_law", 3);
  const bool is_exponent = law[0] == 1.0 || law[0] == 2.0;
  return io::DepthLaw{
      is_exponent ? static_cast<unsigned int>(law[0]) : 0, law[1], law[2]};
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
  if (!py::isinstance<py::str>(name))
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

io::EncoderSettings
readCodecSettings(const Keywords& values)
{
  io::EncoderSettings settings;
  settings.resolution = values.number("resolution");
  settings.i_frame_rate = values.smallCount("i_frame_rate");
  settings.effort = values.choice("effort", io::efforts);
  settings.format = values.choice("format", io::stream_formats);
  readIntensityCoding(values, settings);
  settings.colour_bits = values.smallCount("colour_bits");
  settings.keep_point_counts = values.flag("keep_point_counts");
  settings.fields = readFields(values);
  settings.coarsen_wide_clouds = values.flag("coarsen_wide_clouds");
  settings.threads = values.smallCount("threads");
  settings.temporal_filter = values.smallCount("temporal_filter");
  settings.max_rate = values.number("max_rate");
  settings.rate_buffer = values.number("rate_buffer");
  settings.max_encode_ms = values.number("max_encode_ms");
  settings.rate_temporal_filter = values.smallCount("rate_temporal_filter");
  settings.rate_doublings = values.smallCount("rate_doublings");
  settings.rate_sent_share = values.number("rate_sent_share");
  if (values.isSet("origin"))
    settings.origin = pointOf(values.numbers("origin", 3));
  if (values.isSet("bounding_box"))
    settings.bounding_box = readBox(values);
  return settings;
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
  return settings;
}

io::DecoderLimits
readLimits(const py::dict& values, const std::optional<io::DecoderLimits>& defaults)
{
  const Keywords keywords(values);
  io::DecoderLimits limits = defaults.value_or(io::DecoderLimits());
  const auto read = [&](const char* name, std::size_t& limit) {
    if (!defaults || keywords.isSet(name))
      limit = keywords.count(name, any_size);
  };
  read("max_frame_bytes", limits.max_frame_bytes);
  read("max_voxels", limits.max_voxels);
  read("max_points", limits.max_points);
  read("max_field_values", limits.max_field_values);
  throwUnlessOk(io::checkLimits(limits));
  return limits;
}

VoxelOutlierRemovalSettings
readRemovalSettings(const py::dict& values)
{
  const Keywords keywords(values);
  VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = static_cast<float>(keywords.number("min_log_odds"));
  settings.unit = keywords.choice("unit", density_units);
  settings.full_intensity = static_cast<float>(keywords.number("full_intensity"));
  if (keywords.isSet("sensor_position"))
    settings.sensor_position = pointOf(keywords.numbers("sensor_position", 3));
  settings.azimuth_step = keywords.number("azimuth_step");
  settings.elevation_step = keywords.number("elevation_step");
  settings.intensities_are_counts = keywords.flag("intensities_are_counts");
  settings.use_history = keywords.flag("use_history");
  settings.max_blocks = keywords.count("max_blocks", any_size);
  throwUnlessOk(checkSettings(settings));
  return settings;
}

PointOutlierRemovalSettings
readPointRemovalSettings(const py::dict& values)
{
  const Keywords keywords(values);
  PointOutlierRemovalSettings settings;
  settings.min_log_odds = static_cast<float>(keywords.number("min_log_odds"));
  settings.use_history = keywords.flag("use_history");
  throwUnlessOk(checkSettings(settings));
  return settings;
}

TemporalFilterSettings
readTemporalFilterSettings(const py::dict& values)
{
  const Keywords keywords(values);
  TemporalFilterSettings settings;
  settings.frames = keywords.smallCount("frames");
  if (settings.frames < TemporalVoxelFilter::least_frames ||
      settings.frames > TemporalVoxelFilter::most_frames)
    keywords.refuse("frames", "a whole number from 2 to 64");
  if (keywords.isSet("sensor_position"))
    settings.sensor_position = pointOf(keywords.numbers("sensor_position", 3));
  return settings;
}

py::dict
defaultSettings()
{
  using namespace py::literals;
  const io::EncoderSettings codec;
  const io::DecoderLimits limits;
  const VoxelOutlierRemovalSettings removal;
  return py::dict("i_frame_rate"_a = codec.i_frame_rate,
                  "intensity_range"_a = codec.intensity_range,
                  "intensity_bits"_a = codec.intensity_bits,
                  "colour_bits"_a = codec.colour_bits,
                  "keep_point_counts"_a = codec.keep_point_counts,
                  "fields"_a = py::tuple(),
                  "coarsen_wide_clouds"_a = codec.coarsen_wide_clouds,
                  "threads"_a = codec.threads,
                  "temporal_filter"_a = codec.temporal_filter,
                  "max_rate"_a = codec.max_rate,
                  "rate_buffer"_a = codec.rate_buffer,
                  "max_encode_ms"_a = codec.max_encode_ms,
                  "rate_temporal_filter"_a = codec.rate_temporal_filter,
                  "rate_doublings"_a = codec.rate_doublings,
                  "rate_sent_share"_a = codec.rate_sent_share,
                  "frames"_a = TemporalFilterSettings().frames,
                  "max_frame_bytes"_a = limits.max_frame_bytes,
                  "max_voxels"_a = limits.max_voxels,
                  "max_points"_a = limits.max_points,
                  "max_field_values"_a = limits.max_field_values,
                  "min_log_odds"_a = removal.min_log_odds,
                  "full_intensity"_a = removal.full_intensity,
                  "azimuth_step"_a = removal.azimuth_step,
                  "elevation_step"_a = removal.elevation_step,
                  "intensities_are_counts"_a = removal.intensities_are_counts,
                  "use_history"_a = removal.use_history,
                  "max_blocks"_a = removal.max_blocks);
}

} // namespace python
} // namespace pcl_ext
