#include "scale_options.h"

#include "measuring/command_line.h"

#include <boost/program_options.hpp>

#include <cmath>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

namespace options = boost::program_options;

void
check(const ScaleOptions& options)
{
  if (options.frames == 0 || options.sensor_frames == 0 || options.most_streams == 0)
    throw std::invalid_argument("numbers of frames and streams must be above 0");
  if (options.frames >= options.workload.i_frame_rate &&
      options.frames % options.workload.i_frame_rate != 0)
    throw std::invalid_argument("frames is " + std::to_string(options.frames) +
                                "; it must be a multiple of " +
                                std::to_string(options.workload.i_frame_rate) +
                                ", as streams are repeated from their first I-frame");
  for (const double seconds : {options.seconds, options.sensor_seconds})
    if (!std::isfinite(seconds) || !(seconds > 0.0))
      throw std::invalid_argument("seconds must be above 0");
}

} // namespace

std::optional<ScaleOptions>
parseScaleOptions(int argc, const char* const* argv)
{
  ScaleOptions result;
  std::vector<std::string> efforts;
  VoxelOutlierRemovalSettings outlier_removal;
  options::options_description description(
      "Finds how many 20 Hz streams one CentralNode decodes in time and how many a "
      "gigabit carries, runs six sensors at once, and prints Markdown.\n"
      "Usage: measure_scale [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and stop");
  option("recording",
         options::value(&result.recordings),
         "folders of PCD files whose streams are sent besides the robot cell's");
  option("efforts",
         options::value(&efforts)->multitoken(),
         "of the streams: fast balanced small published (default: all)");
  option("frames,n",
         options::value(&result.frames)->default_value(300),
         "of each sensor of the robot cell, a multiple of 30");
  option("seconds",
         options::value(&result.seconds)->default_value(5.0),
         "that each run is measured");
  option("most-streams",
         options::value(&result.most_streams)->default_value(800),
         "to try");
  option("sensor-seconds",
         options::value(&result.sensor_seconds)->default_value(15.0),
         "of the run of six sensors");
  option("sensor-frames",
         options::value(&result.sensor_frames)->default_value(60),
         "clouds of each of the six, 3.5 MB each, which are repeated");
  option(
      "outlier-removal",
      options::value(&outlier_removal.min_log_odds),
      "log-odds below which the sensors take a voxel for noise and do not send it, 0 "
      "being their default; without this option they send all voxels");
  options::variables_map values;
  if (!parseCommandLine(argc, argv, description, "recording", values))
    return std::nullopt;
  if (values.count("outlier-removal") != 0)
    result.workload.outlier_removal = outlier_removal;
  if (efforts.empty())
    result.variants = libraryVariants();
  for (const std::string& effort : efforts)
    result.variants.push_back(variantNamed(effort));
  check(result);
  return result;
}

} // namespace measuring
} // namespace pcl_ext
