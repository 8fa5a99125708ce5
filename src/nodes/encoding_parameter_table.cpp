// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/codec_parameters.h"
#include "nodes/parameter_access.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

using Descriptions = std::vector<ParameterDescription>;

void
describeLaw(Descriptions& parameters)
{
  parameters.push_back(wordParameter(
      "intensity",
      nameOf(lawChoices(), LawChoice()),
      lawChoices(),
      "Intensity of a voxel: the number of its points; the covered share of a voxel "
      "face (255: all), by two laws, quadratic and linear; native, the sensor's own "
      "intensity; none, positions alone; automatic, native for clouds with the field "
      "of intensity_field, else none."));
  parameters.push_back(textParameter("intensity_field",
                                     SensorNodeSettings().intensity_field,
                                     "Field of the clouds that native reads."));
}

void
describeSensor(Descriptions& parameters)
{
  parameters.push_back(
      wordParameter("sensor",
                    "",
                    named_sensors,
                    "Sensor by its name, which quadratic and linear need, unless it is "
                    "described by the next four parameters."));
  constexpr double widest = 179.9; // degrees; the tangent of its half is finite
  constexpr double narrowest = 0.1;
  constexpr std::int32_t most_pixels = 65536;
  const char* const field_of_view = "field of view of the sensor; 0: not set.";
  const char* const image = "of the sensor's depth image; 0: not set.";
  parameters.push_back(numberParameter("sensor_fov_x_deg",
                                       "degrees",
                                       0.0,
                                       narrowest,
                                       widest,
                                       std::string("Horizontal ") + field_of_view));
  parameters.push_back(numberParameter("sensor_fov_y_deg",
                                       "degrees",
                                       0.0,
                                       narrowest,
                                       widest,
                                       std::string("Vertical ") + field_of_view));
  parameters.push_back(countParameter(
      "sensor_columns", "pixels", 0, 1, most_pixels, std::string("Width ") + image));
  parameters.push_back(countParameter(
      "sensor_rows", "pixels", 0, 1, most_pixels, std::string("Height ") + image));
}

void
describeFilters(Descriptions& parameters)
{
  ParameterDescription crop_box;
  crop_box.name = "crop_box";
  crop_box.unit = "m";
  crop_box.default_value = std::vector<double>();
  crop_box.list_size = 6;
  crop_box.description =
      "Box [x0, y0, z0, x1, y1, z1] in the global frame of a node, or "
      "in the frame of the clouds of a transport, outside of which "
      "points are left out; []: none.";
  parameters.push_back(crop_box);
  parameters.push_back(flagParameter("remove_outliers",
                                     SensorNodeSettings().outlier_removal.has_value(),
                                     "Remove noise before it is encoded: of lidars "
                                     "that turn points, judged by the rays "
                                     "around them, of other sensors voxels, judged by "
                                     "their surroundings in this frame "
                                     "and the last ones."));
  parameters.push_back(descriptionOf(noiseParameters(), "min_log_odds"));
}

Descriptions
describeEncodingParameters()
{
  Descriptions parameters;
  describeCodec(io::encoderSettingTable(), parameters);
  describeLaw(parameters);
  describeSensor(parameters);
  describeFilters(parameters);
  return parameters;
}

} // namespace

void
describeCodec(const io::EncoderSettingTable& table, Descriptions& parameters)
{
  for (const io::EncoderSetting& setting : table) {
    if (!setting.not_offered.parameter.empty())
      continue;
    ParameterDescription parameter;
    parameter.name = setting.id;
    parameter.unit = setting.range.unit;
    parameter.default_value = valueOf(setting, io::EncoderSettings());
    parameter.description = helpOf(setting).withIds();
    parameter.words = wordsOf(setting);
    parameter.list_size = listSizeOf(setting);
    parameter.may_be_zero = !setting.range.zero.empty();
    if (setting.range.lowest < setting.range.highest) {
      parameter.lowest = setting.range.lowest;
      parameter.highest = setting.range.highest;
    }
    if (std::holds_alternative<std::int64_t>(parameter.default_value)) {
      parameter.highest = std::min<double>(parameter.highest, largest_integer);
      if (parameter.may_be_zero && parameter.lowest == 1.0)
        parameter.lowest = 0.0;
    }
    parameters.push_back(parameter);
  }
}

const std::vector<ParameterDescription>&
encodingParameters()
{
  static const Descriptions parameters = describeEncodingParameters();
  return parameters;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
