/** \file
 * \brief Measures how well noise is distinguished from surfaces in the voxels of the
 * robot cell: by the paper's laws, by the library's filter and by PCL's.
 */
#include "filter_times.h"
#include "measuring/command_line.h"
#include "measuring/result_file.h"
#include "method_results.h"
#include "methods.h"
#include "shell_weights.h"
#include "simulator/labelled_lidar.h"
#include "stream_bytes.h"

#include <boost/program_options.hpp>

#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;
namespace options = boost::program_options;

struct NoiseOptions {
  std::string part;                  ///< one of the parts, or all
  std::vector<unsigned int> sensors; ///< 1 to 6, and 7 for part laws
  std::uint32_t frames = 0;
  std::uint32_t seed = 0;
  double resolution = 0.0;  ///< voxel edge, metres
  std::string results_file; ///< empty: standard output

  bool
  includes(const std::string& one) const
  {
    return part == "all" || part == one;
  }
};

bool
parse(int argc, const char* const* argv, NoiseOptions& result)
{
  std::vector<std::int64_t> sensors;
  measuring::Choices<std::string> parts;
  for (const char* const part :
       {"all", "bytes", "merged", "laws", "peers", "time", "weights"})
    parts.emplace_back(part, part);
  options::options_description description(
      "Measures how well noise is distinguished from surfaces in the voxels of the "
      "robot cell, and writes the results as CSV.\nUsage: measure_noise "
      "[options]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option(
      "part",
      measuring::choice("part", result.part, parts)->default_value("all"),
      "laws (the paper's laws and the library's filter), peers (PCL's filters), time, "
      "bytes (of a stream whose noise is removed), weights (fit of the filter's), "
      "merged (all six cameras) or all");
  option("sensor",
         options::value(&sensors)->multitoken()->default_value({1}, "1"),
         "sensors, 1 to 6, and 7, the lidar, for parts laws and weights");
  option("frames,n",
         measuring::count("frames", result.frames, 1)->default_value(300),
         "number of frames");
  option("seed",
         measuring::count("seed", result.seed, 0)->default_value(1),
         "of the noise");
  option("resolution,r",
         measuring::number("resolution", result.resolution, 0.001, 1.0)
             ->default_value(0.04, "0.04"),
         "voxel edge, metres, 0.001 to 1");
  option("results",
         options::value(&result.results_file),
         "file for the results; without it they are printed");
  options::variables_map values;
  if (!measuring::parseCommandLine(argc, argv, description, "", values))
    return false;
  const unsigned int last_sensor = result.part == "laws" || result.part == "weights"
                                       ? cell::RobotCell::lidar
                                       : cell::RobotCell::sensor_count;
  for (const std::int64_t sensor : sensors)
    result.sensors.push_back(measuring::checkedCount("sensor", sensor, 1, last_sensor));
  return true;
}

/** \brief Scores all frames of a stream with the methods, and adds the results. */
template <typename StreamT>
void
judgeStream(const std::string& experiment,
            const std::string& sensor,
            StreamT&& stream,
            std::vector<Method> methods,
            const NoiseOptions& options,
            measuring::ResultFile& results)
{
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    stream.read(i, frame);
    judge(frame, methods);
  }
  const bool has_depths = sensor != "merged";
  addResults({experiment, sensor, options.resolution, options.frames, has_depths},
             std::move(methods),
             results);
}

void
measureSensor(unsigned int sensor,
              const NoiseOptions& options,
              measuring::ResultFile& results)
{
  const std::string name = std::to_string(sensor);
  const auto [seed, frames, resolution] =
      std::tuple(options.seed, options.frames, options.resolution);
  if (options.includes("laws")) {
    if (sensor == cell::RobotCell::lidar)
      judgeStream("noise",
                  name,
                  LabelledLidar(seed, resolution),
                  lidarMethods(),
                  options,
                  results);
    else
      judgeStream("noise",
                  name,
                  LabelledStream(seed, sensor, resolution),
                  cameraMethods(),
                  options,
                  results);
  }
  if (options.includes("peers"))
    judgeStream("noise_peers",
                name,
                LabelledStream(seed, sensor, resolution),
                peerMethods(resolution),
                options,
                results);
  if (options.includes("time"))
    measureFilterTimes(seed, sensor, frames, resolution, results);
  if (options.includes("bytes"))
    measureStreamBytes(seed, sensor, frames, resolution, results);
  if (options.includes("weights") && sensor == cell::RobotCell::lidar)
    fitVoxelsOffset(seed, frames, resolution, results);
  else if (options.includes("weights"))
    fitShellWeights(seed, sensor, frames, resolution, results);
}

void
measure(const NoiseOptions& options)
{
  measuring::ResultFile results(options.results_file);
  for (const unsigned int sensor : options.sensors)
    if (options.part != "merged")
      measureSensor(sensor, options, results);
  if (options.includes("merged")) {
    MergedStream stream(options.seed, options.resolution);
    judgeStream("noise", "merged", stream, mergedMethods(stream), options, results);
  }
  results.close();
}

} // namespace

int
main(int argc, char** argv)
{
  return measuring::runProgram("measure_noise", [argc, argv] {
    NoiseOptions options;
    if (parse(argc, argv, options))
      measure(options);
    return 0;
  });
}
