#include "stream/frame_warnings.h"

#include <cstddef>
#include <sstream>

namespace pcl_ext {
namespace io {

namespace {

std::string
numberOf(double value)
{
  std::ostringstream text;
  text << value;
  return text.str();
}

/** \brief Appends a warning, if it is about anything. */
void
warn(std::size_t number, std::size_t total, const std::string& what, std::string& text)
{
  if (number == 0)
    return;
  if (!text.empty())
    text += "; ";
  text += std::to_string(number) + " of " + std::to_string(total) + ' ' + what;
}

void
warnOfPoints(const VoxelizationStatistics& cloud, std::string& text)
{
  warn(cloud.points_outside_grid,
       cloud.points,
       "points are more than 2^20 voxels from the grid's origin and were left out: use "
       "a "
       "larger resolution, or set an origin amid the points",
       text);
  warn(cloud.points_outside_box,
       cloud.points,
       "points are outside the bounding box and were left out",
       text);
  warn(
      cloud.points_behind_sensor,
      cloud.points,
      "points are behind the sensor (negative depth) and have intensity 0: set "
      "sensor_pose, or the cloud's sensor_origin_ and sensor_orientation_, to the pose "
      "whose z axis is the optical axis",
      text);
  warn(cloud.intensities_not_finite,
       cloud.points,
       "points have an intensity that is not finite, which was taken as 0",
       text);
  warn(cloud.colours_left_out,
       cloud.points,
       "points have a colour, for which the published layout has no field",
       text);
}

/** \brief Mentions what a decoder with the default limits refuses. */
void
warnOfLimits(const FrameStatistics& statistics, bool keeps_points, std::string& text)
{
  const DecoderLimits limits;
  const auto exceed = [&](std::size_t number, std::size_t limit, const char* name) {
    if (number <= limit)
      return;
    if (!text.empty())
      text += "; ";
    text += "the frame needs a decoder with decoder_limits." + std::string(name) +
            " of at least " + std::to_string(number) + "; the default is " +
            std::to_string(limit);
  };
  exceed(statistics.coding.voxels, limits.max_voxels, "max_voxels");
  exceed(statistics.coding.bytes, limits.max_frame_bytes, "max_frame_bytes");
  if (keeps_points)
    exceed(statistics.voxelization.points_used, limits.max_points, "max_points");
}

} // namespace

std::string
frameWarning(const FrameStatistics& statistics,
             const IntensityCompressionSettings& settings,
             IntensityUnit unit)
{
  std::string text;
  if (statistics.voxelization.resolution > settings.resolution)
    text = "the cloud is wider than 2^21 voxels of " + numberOf(settings.resolution) +
           " m: voxels of " + numberOf(statistics.voxelization.resolution) +
           " m were used";
  warnOfPoints(statistics.voxelization, text);
  // A full face is the end of the scale of shares, and without intensities the published
  // layout has counts that nobody asked for.
  if (unit == IntensityUnit::Points || unit == IntensityUnit::Native)
    warn(statistics.voxelization.intensities_out_of_range,
         statistics.voxelization.voxels,
         unit == IntensityUnit::Native && settings.format == StreamFormat::Published
             ? "voxels have an intensity beyond the scale of 0 to 255 and were set to "
               "its "
               "end: use Aggregation::Mean"
             : "voxels have an intensity beyond the scale and were set to its end: use "
               "a "
               "larger intensity_range or more intensity_bits",
         text);
  warnOfLimits(statistics, settings.keep_points, text);
  return text;
}

} // namespace io
} // namespace pcl_ext
