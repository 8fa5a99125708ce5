// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/rigid_pose.h>

#include "stream/setting_checks.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>

namespace pcl_ext {
namespace io {

namespace {

constexpr unsigned int most_threads = 256;

template <typename ValueT>
CompressionStatus
invalid(const char* field, const ValueT& value, const char* demand)
{
  return {CompressionCode::InvalidSettings, invalidMessage(field, value, demand)};
}

CompressionStatus
checkBox(const BoundingBox& box, double resolution)
{
  if (const std::string fault = boxFault("bounding_box", box); !fault.empty())
    return {CompressionCode::InvalidSettings, fault};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if ((box.max[axis] - box.min[axis]) / resolution > std::exp2(max_grid_depth) - 1.0)
      return invalid("bounding_box",
                     std::to_string(box.max[axis] - box.min[axis]) + " m wide",
                     "no wider than 2^21 - 1 voxels");
  return {};
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
  if (settings.keep_point_counts)
    return invalid("keep_point_counts", "on", "off in the published layout");
  if (settings.origin)
    return invalid("origin", "set", "automatic in the published layout");
  if (!settings.fields.empty())
    return invalid("fields", "set", "empty in the published layout");
  return {};
}

CompressionStatus
checkFieldSettings(const std::vector<FieldSetting>& fields)
{
  for (auto field = fields.begin(); field != fields.end(); ++field) {
    const std::string step = "step of the field '" + field->name + "'";
    if (field->name.empty())
      return invalid("fields: a name", "empty", "that of a field, or all");
    if (!std::isfinite(field->step) || field->step < 0.0)
      return invalid(
          step.c_str(), field->step, "a positive step, or 0 for exact values");
    if (field->name == all_fields && field->step != 0.0)
      return invalid(step.c_str(),
                     field->step,
                     "0, as all means exact values; name the fields with a step");
    const auto is_same = [field](const FieldSetting& other) {
      return other.name == field->name;
    };
    if (std::any_of(fields.begin(), field, is_same))
      return {CompressionCode::InvalidSettings,
              "fields has '" + field->name + "' twice; it must have each name once"};
  }
  return {};
}

CompressionStatus
checkFields(const EncoderSettings& settings)
{
  if (settings.temporal_filter != 0 && !settings.fields.empty())
    return invalid("fields", "set", "empty with temporal_filter");
  return checkFieldSettings(settings.fields);
}

CompressionStatus
checkRate(const RateSettings& settings)
{
  const auto isIn = [](double value, double least, double most) {
    return value >= least && value <= most; // NaN is not
  };
  if (settings.max_rate != 0.0 &&
      !isIn(settings.max_rate, least_max_rate, most_max_rate))
    return invalid(
        "max_rate", settings.max_rate, "1e3 to 1e12 bits a second, or 0 for no limit");
  if (!isIn(settings.rate_buffer, 0.01, 1.0))
    return invalid("rate_buffer", settings.rate_buffer, "0.01 to 1 seconds");
  if (settings.max_encode_ms != 0.0 && !isIn(settings.max_encode_ms, 0.1, 1e4))
    return invalid("max_encode_ms",
                   settings.max_encode_ms,
                   "0.1 to 1e4 milliseconds, or 0 for no limit");
  if (settings.rate_temporal_filter != 0 &&
      (settings.rate_temporal_filter < TemporalVoxelFilter::least_frames ||
       settings.rate_temporal_filter > TemporalVoxelFilter::most_frames))
    return invalid("rate_temporal_filter",
                   settings.rate_temporal_filter,
                   "2 to 64 frames, or 0 for none");
  if (settings.rate_doublings > 8)
    return invalid("rate_doublings", settings.rate_doublings, "0 to 8");
  if (!isIn(settings.rate_sent_share, 0.1, 1.0))
    return invalid("rate_sent_share", settings.rate_sent_share, "0.1 to 1");
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
  CompressionStatus status = checkFieldSettings(fields);
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
  if (!(settings.resolution >= smallest_resolution &&
        settings.resolution <= largest_resolution))
    return invalid("resolution", settings.resolution, "1e-6 to 1e6 metres");
  if (settings.effort != Effort::Fast && settings.effort != Effort::Balanced &&
      settings.effort != Effort::Small)
    return invalid(
        "effort", static_cast<int>(settings.effort), "Fast, Balanced or Small");
  if (!std::isfinite(settings.intensity_range) || settings.intensity_range < 0.0f)
    return invalid(
        "intensity_range", settings.intensity_range, "0 or a positive intensity");
  if (settings.intensity_bits > 16)
    return invalid(
        "intensity_bits", settings.intensity_bits, "1 to 16, or 0 for automatic");
  if (settings.colour_bits > 8)
    return invalid("colour_bits", settings.colour_bits, "1 to 8, or 0 for no colour");
  if (settings.threads < 1 || settings.threads > most_threads)
    return invalid("threads", settings.threads, "1 to 256");
  if (settings.temporal_filter != 0 &&
      (settings.temporal_filter < TemporalVoxelFilter::least_frames ||
       settings.temporal_filter > TemporalVoxelFilter::most_frames))
    return invalid(
        "temporal_filter", settings.temporal_filter, "2 to 64 frames, or 0 for off");
  if (settings.temporal_filter != 0 && settings.keep_point_counts)
    return invalid("keep_point_counts", "on", "off with temporal_filter");
  if (CompressionStatus status = checkFields(settings); !status.ok())
    return status;
  if (CompressionStatus status = checkRate(settings); !status.ok())
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
  if (settings.sensor_pose && !isRigid(Eigen::Isometry3f(*settings.sensor_pose)))
    return invalid("sensor_pose", "not rigid", "a rotation and a translation");
  if (settings.carry_header && settings.format == StreamFormat::Published)
    return invalid("carry_header", "on", "off in the published layout");
  return {};
}

} // namespace io
} // namespace pcl_ext
