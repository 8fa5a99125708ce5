// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/rigid_pose.h>

#include "bytes/exact_text.h"
#include "stream/encoder_setting.h"
#include "stream/setting_checks.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

template <typename ValueT>
CompressionStatus
invalid(const char* id, const ValueT& value, const char* demand)
{
  return {CompressionCode::InvalidSettings, invalidText(id, value, demand)};
}

CompressionStatus
checkBox(const BoundingBox& box, double resolution)
{
  if (const auto fault = boxFault("bounding_box", box))
    return {CompressionCode::InvalidSettings, *fault};
  double width = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    width = std::max(width, box.max[axis] - box.min[axis]);
  const double most_voxels = std::exp2(max_grid_depth) - 1.0;
  if (width / resolution <= most_voxels)
    return {};
  const double sufficient = roundedUp(width / most_voxels);
  const std::string remedy =
      sufficient <= largest_resolution
          ? ", as with a {resolution} of " + exactText(sufficient)
          : std::string();
  return invalid("bounding_box",
                 exactText(width) + " m wide",
                 ("no wider than 2^21 - 1 voxels" + remedy).c_str());
}

/** \brief Checks that the box intersects the lattice of version 1. */
CompressionStatus
checkBoxOnLattice(const BoundingBox& box,
                  double resolution,
                  const std::array<double, 3>& origin)
{
  const double end = std::exp2(max_grid_depth - 1) * resolution;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (box.min[axis] >= origin[axis] + end || box.max[axis] < origin[axis] - end)
      return invalid("bounding_box",
                     std::to_string(box.min[axis]) + " to " +
                         std::to_string(box.max[axis]),
                     "within 2^20 voxels of the origin, at least in part");
  return {};
}

CompressionStatus
checkDepthLaw(const DepthLaw& law)
{
  if (law.exponent != 1 && law.exponent != 2)
    return invalid("depth_law.exponent", law.exponent, "1 or 2");
  if (!std::isfinite(law.cut_off_depth) || !(law.cut_off_depth > 0.0))
    return invalid(
        "depth_law.cut_off_depth", law.cut_off_depth, "a positive depth in metres");
  if (!std::isfinite(law.full_intensity) || !(law.full_intensity > 0.0))
    return invalid(
        "depth_law.full_intensity", law.full_intensity, "a positive intensity");
  return {};
}

/** \brief Refuses settings that would change what is decoded and have no field in the
 * layout. Effort and depth law change bytes and time only, and have no effect. */
CompressionStatus
checkPublished(const EncoderSettings& settings)
{
  if (settings.intensity_bits != 0 && settings.intensity_bits != 8)
    return invalid("intensity_bits",
                   settings.intensity_bits,
                   "8, or 0 for automatic, in the published layout");
  if (settings.intensity_range != 0.0f && settings.intensity_range != 255.0f)
    return invalid("intensity_range",
                   settings.intensity_range,
                   "255, or 0 for automatic, in the published layout");
  if (settings.intensity_curve != IntensityCurve::Linear)
    return invalid("intensity_curve", "companded", "linear in the published layout");
  if (settings.keep_points)
    return invalid("keep_points", "on", "off in the published layout");
  if (settings.keep_order)
    return invalid("keep_order", "on", "off in the published layout");
  if (settings.origin)
    return invalid("origin", "set", "automatic in the published layout");
  if (!settings.fields.empty())
    return invalid("fields", "set", "empty in the published layout");
  return {};
}

CompressionStatus
checkFields(const std::vector<FieldSetting>& fields)
{
  for (auto field = fields.begin(); field != fields.end(); ++field) {
    const auto invalid_step = [field](const std::string& demand) {
      return CompressionStatus(
          CompressionCode::InvalidSettings,
          SettingText{"{fields}: the step of '" + SettingText::of(field->name).marked +
                      "' is " + exactText(field->step) + "; it must be " + demand});
    };
    if (field->name.empty())
      return {CompressionCode::InvalidSettings,
              SettingText{"{fields}: a name is empty; it must be that of a field, or "
                          "all"}};
    if (!std::isfinite(field->step) || field->step < 0.0)
      return invalid_step("a positive step, or 0 for exact values");
    if (field->name == all_fields && field->step != 0.0)
      return invalid_step(
          "left out, as all means exact values; name the fields with a step");
    const auto is_same = [field](const FieldSetting& other) {
      return other.name == field->name;
    };
    if (std::any_of(fields.begin(), field, is_same))
      return {CompressionCode::InvalidSettings,
              SettingText{"{fields} has '" + SettingText::of(field->name).marked +
                          "' twice; it must have each name once"}};
  }
  return {};
}

/** \brief Refuses what has no points in order. */
CompressionStatus
checkOrder(const EncoderSettings& settings)
{
  if (settings.keep_order && settings.aggregation == Aggregation::Sum)
    return invalid("aggregation", "sum", "another one with {keep_order}");
  return {};
}

/** \brief Refuses what cannot be filtered over time. */
CompressionStatus
checkFilter(const EncoderSettings& settings)
{
  if (settings.temporal_filter == 0)
    return {};
  if (settings.keep_points)
    return invalid("keep_points", "on", "off with {temporal_filter}");
  if (settings.keep_order)
    return invalid("keep_order", "on", "off with {temporal_filter}");
  if (!settings.fields.empty())
    return invalid("fields", "set", "empty with {temporal_filter}");
  return {};
}

} // namespace

CompressionStatus
parseFields(const std::string& text, std::vector<FieldSetting>& fields)
{
  fields.clear();
  // A comma at the end has an empty name after it.
  std::istringstream parts(text.empty() ? text : text + ',');
  parts.imbue(std::locale::classic());
  for (std::string part; std::getline(parts, part, ',');) {
    FieldSetting& field = fields.emplace_back();
    part.erase(0, std::min(part.find_first_not_of(' '), part.size()));
    part.erase(part.find_last_not_of(' ') + 1);
    // The last colon, as names may have one.
    const std::size_t colon = part.rfind(':');
    field.name = part.substr(0, colon);
    std::istringstream step(colon == std::string::npos ? "" : part.substr(colon + 1));
    step.imbue(std::locale::classic());
    const bool has_step = colon != std::string::npos;
    if (field.name.empty() ||
        (has_step && (!(step >> field.step) || !step.eof() || !(field.step > 0.0)))) {
      fields.clear();
      return invalid(
          "fields",
          "'" + text + "'",
          "names with commas between them, each with :STEP above 0 if it has "
          "one, or all");
    }
  }
  CompressionStatus status = checkFields(fields);
  if (!status.ok())
    fields.clear();
  return status;
}

bool
isOneOfAllFields(const FieldDescription& field, bool codes_colours)
{
  return isField(field) &&
         !(codes_colours && (field.name == "rgb" || field.name == "rgba"));
}

CompressionStatus
checkLimits(const DecoderLimits& limits)
{
  if (limits.max_frame_bytes == 0)
    return invalid("decoder_limits.max_frame_bytes", 0, "above 0");
  if (limits.max_voxels == 0)
    return invalid("decoder_limits.max_voxels", 0, "above 0");
  if (limits.max_points == 0)
    return invalid("decoder_limits.max_points", 0, "above 0");
  if (limits.max_field_values == 0)
    return invalid("decoder_limits.max_field_values", 0, "above 0");
  if (limits.free_voxels == 0)
    return invalid("decoder_limits.free_voxels", 0, "above 0");
  return {};
}

CompressionStatus
checkSettings(const EncoderSettings& settings, const std::optional<DepthLaw>& depth_law)
{
  if (CompressionStatus status = checkEach(encoderSettingTable(), settings);
      !status.ok())
    return status;
  if (CompressionStatus status = checkOrder(settings); !status.ok())
    return status;
  if (CompressionStatus status = checkFilter(settings); !status.ok())
    return status;
  if (CompressionStatus status = checkFields(settings.fields); !status.ok())
    return status;
  if (settings.origin && !isOrigin(*settings.origin))
    return invalid("origin",
                   std::to_string((*settings.origin)[0]) + " " +
                       std::to_string((*settings.origin)[1]) + " " +
                       std::to_string((*settings.origin)[2]),
                   "within 2e12 m of the world's origin");
  if (CompressionStatus status = checkLimits(settings.decoder_limits); !status.ok())
    return status;
  if (depth_law)
    if (CompressionStatus status = checkDepthLaw(*depth_law); !status.ok())
      return status;
  if (settings.bounding_box)
    if (const CompressionStatus status =
            checkBox(*settings.bounding_box, settings.resolution);
        !status.ok())
      return status;
  if (settings.format == StreamFormat::Published)
    return checkPublished(settings);
  if (settings.bounding_box &&
      !isOrigin(originFor(settings.resolution, *settings.bounding_box)))
    return invalid("bounding_box", "too far", "within 2e12 m of the world's origin");
  return settings.bounding_box && settings.origin
             ? checkBoxOnLattice(
                   *settings.bounding_box, settings.resolution, *settings.origin)
             : CompressionStatus();
}

CompressionStatus
checkSettings(const IntensityCompressionSettings& settings)
{
  if (CompressionStatus status = checkSettings(settings, settings.depth_law);
      !status.ok())
    return status;
  if (settings.sensor_pose && !isRigid(*settings.sensor_pose))
    return invalid("sensor_pose", "not rigid", "a rotation and a translation");
  if (settings.carry_header && settings.format == StreamFormat::Published)
    return invalid("carry_header", "on", "off in the published layout");
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io
