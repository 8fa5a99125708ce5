// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/codec_parameters.h"
#include "nodes/sensor_node_settings.h"

#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

const char* const sensor_numbers =
    "sensor_fov_x_deg, sensor_fov_y_deg, sensor_columns and sensor_rows";

/** \brief The sensor by its name or by its four numbers, 0 of which are not set.
 * \param[out] sensor none if nothing is set
 * \return what is wrong; empty if nothing
 */
std::string
readSensor(const ParameterAccess& access, std::optional<RuntimeSensor>& sensor)
{
  const auto& name = access.get<std::string>("sensor");
  const double fov_x_deg = access.get<double>("sensor_fov_x_deg");
  const double fov_y_deg = access.get<double>("sensor_fov_y_deg");
  const std::uint32_t columns = access.count("sensor_columns");
  const std::uint32_t rows = access.count("sensor_rows");
  const int numbers = (fov_x_deg > 0) + (fov_y_deg > 0) + (columns > 0) + (rows > 0);
  sensor.reset();
  if (!name.empty() && numbers != 0)
    return "sensor is " + textOf(name) + "; it must be unset where one is set of " +
           sensor_numbers;
  if (numbers != 0 && numbers != 4)
    return std::string("sensor is not set; it must be set, or else all of ") +
           sensor_numbers;
  if (!name.empty())
    sensor = access.named("sensor", named_sensors);
  else if (numbers != 0)
    sensor.emplace(fov_x_deg, fov_y_deg, columns, rows);
  return {};
}

/** \brief The six numbers of the crop box; an empty list is none.
 * \return what is wrong; empty if nothing
 */
std::string
readCropBox(const ParameterAccess& access, std::optional<io::BoundingBox>& crop_box)
{
  crop_box.reset();
  const auto& corners = access.get<std::vector<double>>("crop_box");
  if (corners.empty())
    return {};
  io::BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = corners[axis];
    box.max[axis] = corners[axis + 3];
    if (!(box.min[axis] < box.max[axis]))
      return "crop_box is " + textOf(corners) +
             "; it must be [x0, y0, z0, x1, y1, z1], the first three below the others";
  }
  crop_box = box;
  return {};
}

void
readOutlierRemoval(const ParameterAccess& access,
                   std::optional<VoxelOutlierRemovalSettings>& removal)
{
  removal.reset();
  if (access.get<bool>("remove_outliers"))
    removal.emplace().min_log_odds = access.number("min_log_odds");
}

IntensityLaw
readLaw(const ParameterAccess& access, bool has_intensities)
{
  const LawChoice law = access.named("intensity", lawChoices());
  return law.value_or(automaticLaw(has_intensities));
}

/** \brief The first value that is not allowed; empty if all are.
 * \param[out] converted the others
 */
std::string
convertAll(const ParameterValues& values, ParameterValues& converted)
{
  for (const ParameterDescription& parameter : encodingParameters()) {
    const auto value = values.find(parameter.name);
    if (value == values.end())
      continue;
    const std::optional<ParameterValue> allowed =
        convertedValue(parameter, value->second);
    if (!allowed)
      return refusalOf(parameter, value->second);
    converted.emplace(parameter.name, *allowed);
  }
  return {};
}

std::string
parameterOf(const std::string& setting)
{
  if (setting == "law")
    return "intensity";
  return setting == "outlier_removal" ? "remove_outliers" : setting;
}

} // namespace

io::CompressionStatus
readCodec(const io::EncoderSettingTable& table,
          const ParameterAccess& access,
          io::EncoderSettings& settings)
{
  for (const io::EncoderSetting& setting : table)
    if (setting.not_offered.parameter.empty())
      if (io::CompressionStatus status =
              setValue(setting, access.value(setting.id), settings);
          !status.ok())
        return status;
  return {};
}

std::string
readEncodingParameters(const ParameterValues& values,
                       bool has_intensities,
                       SensorNodeSettings& settings)
{
  ParameterValues converted;
  if (const std::string fault = convertAll(values, converted); !fault.empty())
    return fault;
  const ParameterAccess access(encodingParameters(), converted);
  SensorNodeSettings read = settings;
  if (const io::CompressionStatus status =
          readCodec(io::encoderSettingTable(), access, read.compression);
      !status.ok())
    return status.message();
  read.law = readLaw(access, has_intensities);
  read.intensity_field = access.get<std::string>("intensity_field");
  if (const std::string fault = readSensor(access, read.sensor); !fault.empty())
    return fault;
  if (needsSensor(read.law) && !read.sensor)
    return "sensor is not set; it must be set, by name or by numbers, for intensity: " +
           nameOf(read.law);
  if (const std::string fault = readCropBox(access, read.crop_box); !fault.empty())
    return fault;
  readOutlierRemoval(access, read.outlier_removal);
  if (const SensorNodeStatus status = checkSettings(read); !status.ok())
    return status.text().with(parameterOf);
  settings = std::move(read);
  return {};
}

std::string
faultOfEncodingParameters(const ParameterValues& values)
{
  for (const bool has_intensities : {true, false}) {
    SensorNodeSettings settings;
    if (std::string fault = readEncodingParameters(values, has_intensities, settings);
        !fault.empty())
      return fault;
  }
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
