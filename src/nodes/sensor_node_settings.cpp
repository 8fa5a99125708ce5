// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/sensor_node_settings.h"

#include <pcl_ext/compression/impl/saturated_float.h>

#include "bytes/exact_text.h"
#include "outliers/unit_choice.h"
#include "stream/setting_checks.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Checks the values of a sensor, which may have changed since it was made. */
SensorNodeStatus
checkSensor(const RuntimeSensor& sensor)
{
  try {
    RuntimeSensor(sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows);
  }
  catch (const std::invalid_argument& error) {
    return {SensorNodeCode::InvalidSettings,
            SettingText{std::string("{sensor}: ") + error.what()}};
  }
  return {};
}

bool
isKnown(IntensityLaw law)
{
  return std::any_of(intensity_laws.begin(),
                     intensity_laws.end(),
                     [law](const auto& known) { return known.value == law; });
}

/** \brief What is wrong with the outlier removal, which has to be set; nothing if
 * nothing. */
std::optional<SettingText>
outlierRemovalFault(const SensorNodeSettings& settings)
{
  const VoxelOutlierRemovalSettings& removal = *settings.outlier_removal;
  const DensityUnit unit = densityUnitOf(removal.unit);
  if (const std::string fault = unitFault(unit, settings.law); !fault.empty())
    return SettingText{"{outlier_removal.unit} is " +
                       std::string(nameOf(density_units, unit)) + " and {law} is " +
                       fault + ", or {law} " +
                       nameOf(unit == DensityUnit::Faces ? IntensityLaw::Quadratic
                                                         : IntensityLaw::Count)};
  if (const OutlierRemovalStatus status = checkSettings(removal); !status.ok())
    return SettingText{"{outlier_removal}: " + status.text().marked};
  // With Automatic the clouds decide: the points of a lidar are judged at any edge.
  const double edge = settings.compression.resolution;
  if (!std::holds_alternative<AutomaticUnit>(removal.unit) &&
      !VoxelOutlierRemoval::isMadeFor(edge))
    return unjudgedEdge(edge);
  return std::nullopt;
}

/** \brief A box with the floats that are nearest to its ends, to which points of floats
 * are cropped, as by PCL's CropBox: 0.1 as a float is above 0.1. */
io::BoundingBox
withNearestFloats(io::BoundingBox box)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto nearest = [](double end) {
      return static_cast<double>(detail::saturatedFloat(end));
    };
    box.min[axis] = std::min(box.min[axis], nearest(box.min[axis]));
    box.max[axis] = std::max(box.max[axis], nearest(box.max[axis]));
  }
  return box;
}

} // namespace

io::EncoderSettings
codecSettings(const SensorNodeSettings& settings)
{
  io::EncoderSettings codec = settings.compression;
  // A grid that follows the points changes with them; each change costs an I-frame.
  if (!codec.bounding_box && settings.crop_box)
    codec.bounding_box = codec.format == io::StreamFormat::Published
                             ? *settings.crop_box // as it is in the stream
                             : withNearestFloats(*settings.crop_box);
  return codec;
}

bool
codesColours(const SensorNodeSettings& settings)
{
  return settings.compression.colour_bits > 0 &&
         settings.compression.format == io::StreamFormat::Version1;
}

SettingText
unjudgedEdge(double resolution)
{
  return io::invalidText("resolution",
                         exactText(resolution),
                         exactText(VoxelOutlierRemoval::min_resolution) + " to " +
                             exactText(VoxelOutlierRemoval::max_resolution) +
                             " m for outliers to be removed from voxels");
}

VoxelOutlierRemovalSettings
removalSettings(const SensorNodeSettings& settings)
{
  VoxelOutlierRemovalSettings removal = *settings.outlier_removal;
  // A frame alone may not say what its intensities are.
  if (const auto* const automatic = std::get_if<AutomaticUnit>(&removal.unit))
    removal.unit = densityUnitSettings(densityUnitOf(settings.law), *automatic);
  if (auto* const rays = std::get_if<RaysUnit>(&removal.unit))
    rays->intensities_are_counts |= settings.law == IntensityLaw::Count;
  return removal;
}

SensorNodeStatus
checkSettings(const SensorNodeSettings& settings)
{
  const auto invalid = [](const SettingText& text) {
    return SensorNodeStatus(SensorNodeCode::InvalidSettings, text);
  };
  if (!isKnown(settings.law))
    return invalid(io::invalidText(
        "law", static_cast<int>(settings.law), "one of " + namesOf(intensity_laws)));
  if (needsSensor(settings.law) && !settings.sensor)
    return invalid({"{sensor} is not set; the quadratic and the linear law need its "
                    "field of view and size"});
  if (needsSensor(settings.law))
    if (const SensorNodeStatus status = checkSensor(*settings.sensor); !status.ok())
      return status;
  if (const auto fault = io::lawFault(settings.compression, settings.law))
    return invalid(*fault);
  if (settings.outlier_removal)
    if (const auto fault = outlierRemovalFault(settings))
      return invalid(*fault);
  if (!settings.clock)
    return invalid({"{clock} is empty; it must be set"});
  if (settings.crop_box)
    if (const auto fault = io::boxFault("crop_box", *settings.crop_box))
      return invalid(*fault);
  if (settings.carry_header &&
      settings.compression.format == io::StreamFormat::Published)
    return invalid(
        io::invalidText("carry_header", "on", "off in the published layout"));
  if (settings.carry_header && settings.global_frame.size() > io::max_frame_id_size)
    return invalid(io::invalidText(
        "global_frame",
        std::to_string(settings.global_frame.size()) + " bytes long",
        std::to_string(io::max_frame_id_size) + " or less, for frames to carry it"));
  if (const io::CompressionStatus status = io::checkSettings(codecSettings(settings));
      !status.ok()) {
    // If the settings are valid without the crop box, it is the invalid bounding box.
    const bool is_crop_box = io::checkSettings(settings.compression).ok();
    return invalid({(is_crop_box ? "{crop_box} as " : "") + status.text().marked});
  }
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
