#include "noise_options.h"

#include "measuring/command_line.h"
#include "simulator/robot_cell.h"

#include <boost/program_options.hpp>

#include <limits>
#include <map>
#include <stdexcept>

namespace pcl_ext {
namespace noise {

namespace {

namespace options = boost::program_options;

NoisePart
partNamed(const std::string& name)
{
  const std::map<std::string, NoisePart> parts = {{"all", NoisePart::All},
                                                  {"laws", NoisePart::Laws},
                                                  {"peers", NoisePart::Peers},
                                                  {"time", NoisePart::Time},
                                                  {"bytes", NoisePart::Bytes},
                                                  {"weights", NoisePart::Weights},
                                                  {"fused", NoisePart::Fused}};
  const auto part = parts.find(name);
  if (part == parts.end())
    throw std::invalid_argument("--part knows no '" + name +
                                "'; it knows: all bytes fused laws peers time weights");
  return part->second;
}

} // namespace

std::optional<NoiseOptions>
parseNoiseOptions(int argc, const char* const* argv)
{
  NoiseOptions result;
  std::vector<std::int64_t> sensors;
  std::int64_t frames = 0;
  std::int64_t seed = 0;
  std::string part;
  options::options_description description(
      "Measures how well noise is told from surfaces in the voxels of the robot cell, "
      "and prints Markdown.\nUsage: measure_noise [options]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and stop");
  option("sensor",
         options::value(&sensors)->multitoken()->default_value({1}, "1"),
         "sensors, 1 to 6, and 7, the lidar, of part laws");
  option("frames,n",
         options::value(&frames)->default_value(result.frames),
         "frames to measure on");
  option("seed", options::value(&seed)->default_value(result.seed), "of the noise");
  option("resolution,r",
         options::value(&result.resolution)->default_value(result.resolution),
         "voxel edge, metres, 0.005 to 1");
  option(
      "part",
      options::value(&part)->default_value("all"),
      "laws (the paper's laws and the library's filter), peers (PCL's filters), time, "
      "bytes (what a stream shrinks by), weights (a fit of the filter's), fused (all "
      "six cameras), or all");
  option(
      "results", options::value(&result.results_file), "file, for the results as CSV");
  options::variables_map values;
  if (!measuring::parseCommandLine(argc, argv, description, "", values))
    return std::nullopt;
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  result.part = partNamed(part);
  const unsigned int last_sensor = result.part == NoisePart::Laws
                                       ? cell::RobotCell::lidar
                                       : cell::RobotCell::sensor_count;
  for (const std::int64_t sensor : sensors)
    result.sensors.push_back(measuring::checkedCount("sensor", sensor, 1, last_sensor));
  result.frames = measuring::checkedCount("frames", frames, 1, most);
  result.seed = measuring::checkedCount("seed", seed, 0, most);
  if (!(result.resolution >= 0.005 && result.resolution <= 1.0))
    throw std::invalid_argument("--resolution must be 0.005 to 1, metres");
  return result;
}

} // namespace noise
} // namespace pcl_ext
