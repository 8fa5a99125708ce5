// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_warnings.h"

#include "bytes/exact_text.h"
#include "codec/frame_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <string_view>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

std::string
numberOf(double value)
{
  std::ostringstream text;
  text << value;
  return text.str();
}

/** \brief Appends a warning, if it is about anything. Else no memory is allocated.
 * \param[in] number, total what it is about
 * \param[in] what the points are, and what to do
 * \param[in,out] text where it is appended
 * \param[in] advice after `what`
 */
void
warn(std::size_t number,
     std::size_t total,
     std::string_view what,
     std::string& text,
     std::string_view advice = {})
{
  if (number == 0)
    return;
  if (!text.empty())
    text += "; ";
  text += std::to_string(number) + " of " + std::to_string(total) + ' ';
  text.append(what).append(advice);
}

/** \brief Which setting keeps points that are outside the grid. */
std::string
adviceFor(const WiderGrid& wider,
          double resolution,
          const EncoderSettings& settings,
          IntensityUnit unit)
{
  const double reach = (std::exp2(max_grid_depth) - 2.0) * resolution;
  if (wider.width <= reach)
    return settings.format == StreamFormat::Published
               ? "set {bounding_box} around the points"
               : "set {origin} amid the points";
  const std::string text = "the cloud is " + numberOf(wider.width) +
                           " m wide, a grid of voxels of " + numberOf(resolution) +
                           " m at most " + numberOf(reach) + " m: use ";
  const std::string box = "a {bounding_box} around the points to keep";
  const double sufficient = roundedUp(wider.resolution);
  if (sufficient > largest_resolution)
    return text + box;
  constexpr double most_coarsened = 16.0;
  const bool may_coarsen = unit != IntensityUnit::Share &&
                           settings.format == StreamFormat::Version1 &&
                           !settings.coarsen_wide_clouds &&
                           wider.resolution <= most_coarsened * settings.resolution;
  return text + (may_coarsen ? "{coarsen_wide_clouds}, " : "") + "a {resolution} of " +
         numberOf(sufficient) + " m or more, or " + box;
}

/** \brief Mentions points that were left out or changed. */
void
warnOfPoints(const VoxelizationStatistics& cloud,
             const EncoderSettings& settings,
             IntensityUnit unit,
             const VoxelFit& fit,
             std::string& text)
{
  if (cloud.points_not_finite == cloud.points)
    warn(cloud.points,
         cloud.points,
         "points are NaN or infinite: the frame is empty",
         text);
  warn(cloud.points_outside_grid,
       cloud.points,
       "points are more than 2^20 voxels from the grid's origin and were left out",
       text,
       fit.wider_grid
           ? ": " + adviceFor(*fit.wider_grid, cloud.resolution, settings, unit)
           : std::string());
  warn(cloud.points_outside_box,
       cloud.points,
       "points are outside the bounding box and were left out",
       text);
  warn(cloud.points_behind_sensor,
       cloud.points,
       "points are behind the sensor (negative depth) and have intensity 0: set "
       "{sensor_pose}, or the pose that the cloud itself has, to that whose z axis is "
       "the optical axis",
       text);
  warn(cloud.intensities_not_finite,
       cloud.points,
       "points have an intensity that is not finite as a float, which was taken as 0",
       text);
  warn(cloud.colours_left_out,
       cloud.points,
       "points have a colour, for which the published layout has no field; set "
       "{colour_bits} to 0 if none is wanted",
       text);
  warn(cloud.alphas_left_out,
       cloud.points,
       "points have a colour with an alpha, which a scan does not keep; set "
       "{colour_bits} to 0 to keep the field as it is",
       text);
}

/** \brief A number of a frame and the limit of its decoders. */
struct LimitedNumber {
  std::size_t number;
  std::size_t limit;
  std::string_view name; ///< member of DecoderLimits
};

std::array<LimitedNumber, 5>
limitedNumbers(const FrameStatistics& statistics,
               const EncoderSettings& settings,
               const LimitedCounts& counts)
{
  const bool is_published = settings.format == StreamFormat::Published;
  const FrameLimits limits = frameLimits(settings.decoder_limits,
                                         is_published ? 0 : counts.bytes_since_i_frame);
  const bool is_by_bytes = limits.max_voxels < settings.decoder_limits.max_voxels;
  return {{{statistics.coding.voxels,
            limits.max_voxels,
            is_by_bytes ? "free_voxels" : "max_voxels"},
           {is_published ? 0 : counts.blocks, limits.max_blocks, "free_voxels"},
           {statistics.coding.bytes,
            settings.decoder_limits.max_frame_bytes,
            "max_frame_bytes"},
           {settings.keepsPoints() ? statistics.voxelization.points_used : 0,
            limits.max_points,
            "max_points"},
           {counts.field_values, limits.max_field_values, "max_field_values"}}};
}

/** \brief Mentions what a decoder with the limits of the settings refuses. */
void
warnOfLimits(const std::array<LimitedNumber, 5>& numbers, std::string& text)
{
  for (const LimitedNumber& limited : numbers) {
    if (limited.number <= limited.limit)
      continue;
    if (!text.empty())
      text += "; ";
    text += "the frame needs a decoder with {decoder_limits.";
    text.append(limited.name) += "} of at least " + std::to_string(limited.number) +
                                 "; that of the settings is " +
                                 std::to_string(limited.limit);
  }
}

/** \brief What helps against intensities beyond the scale. */
std::string_view
remedyOfHighIntensities(const EncoderSettings& settings, bool is_native)
{
  if (settings.format == StreamFormat::Published)
    return is_native && settings.aggregation != Aggregation::Mean
               ? "the published layout has 0 to 255; set {aggregation} to the mean, or "
                 "scale them before"
               : "the published layout has 0 to 255; scale them before, or use "
                 "version 1";
  if (settings.intensity_range == 0.0f && (is_native || settings.intensity_bits == 0))
    return "they are few, and far from the others or above what their exact step "
           "holds; remove lost returns, or hold all with an {intensity_range} above 0 "
           "that none of them exceeds";
  return "use a larger {intensity_range} or more {intensity_bits}";
}

/** \brief What helps against intensities that became 0. */
std::string_view
remedyOfVanished(const EncoderSettings& settings, IntensityUnit unit)
{
  if (settings.format == StreamFormat::Published)
    return "the published layout has whole numbers of 0 to 255; scale them before, or "
           "use version 1";
  if (unit == IntensityUnit::Share && settings.intensity_range > 1.0f)
    return "set {intensity_range} to 1, which is a whole face, or less";
  if (settings.intensity_range > 0.0f)
    return "use a smaller {intensity_range} or more {intensity_bits}";
  if (unit == IntensityUnit::Native)
    return "set {intensity_range} to what the sensor has, without outliers";
  if (unit == IntensityUnit::Points && settings.intensity_bits == 0)
    return "set {intensity_range} to what most of them have";
  return "use more {intensity_bits}";
}

/** \brief Mentions intensities that the scale cannot hold.
 * \param[in] has_points they are those of points, else of voxels
 */
void
warnOfIntensities(const VoxelizationStatistics& cloud,
                  bool has_points,
                  const EncoderSettings& settings,
                  IntensityUnit unit,
                  std::string& text)
{
  // Without intensities the published layout has counts that nobody asked for.
  if (unit == IntensityUnit::None)
    return;
  const bool is_native = unit == IntensityUnit::Native;
  // A warning that is not given takes no memory. A full face is the end of the scale of
  // shares.
  if (is_native || unit == IntensityUnit::Points)
    warn(cloud.intensities_out_of_range,
         cloud.voxels,
         has_points
             ? "points have an intensity beyond the scale and were set to its end: "
             : "voxels have an intensity beyond the scale and were set to its end: ",
         text,
         remedyOfHighIntensities(settings, is_native));
  // On an automatic scale some are lost to rounding in any case.
  const std::size_t one_of = settings.intensity_range > 0.0f ? 16 : 2;
  if (one_of * cloud.intensities_vanished > cloud.voxels)
    warn(cloud.intensities_vanished,
         cloud.voxels,
         has_points ? "points have an intensity of less than half a step of the "
                      "scale, which became 0: "
                    : "voxels have an intensity of less than half a step of the "
                      "scale, which became 0: ",
         text,
         remedyOfVanished(settings, unit));
}

} // namespace

bool
exceedsLimits(const FrameStatistics& statistics,
              const EncoderSettings& settings,
              const LimitedCounts& counts)
{
  const auto numbers = limitedNumbers(statistics, settings, counts);
  return std::any_of(numbers.begin(), numbers.end(), [](const LimitedNumber& limited) {
    return limited.number > limited.limit;
  });
}

SettingText
frameWarning(const FrameStatistics& statistics,
             const EncoderSettings& settings,
             IntensityUnit unit,
             const VoxelFit& fit,
             const LimitedCounts& counts,
             const std::string& fields_left_out)
{
  std::string text;
  if (fit.is_coarsened)
    text = "the cloud is too wide for edges of " + numberOf(settings.resolution) +
           " m: edges of " + numberOf(statistics.voxelization.resolution) +
           " m were used";
  warnOfPoints(statistics.voxelization, settings, unit, fit, text);
  warnOfIntensities(
      statistics.voxelization, statistics.coding.has_points, settings, unit, text);
  warnOfLimits(limitedNumbers(statistics, settings, counts), text);
  if (!fields_left_out.empty())
    text += (text.empty() ? "" : "; ") + std::string("fields that cannot be kept: ") +
            SettingText::of(fields_left_out).marked;
  return {text};
}

} // namespace pcl_ext::PCL_EXT_ABI::io
