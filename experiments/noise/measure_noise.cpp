/** \file
 * \brief Measures how well noise is distinguished from surfaces in the voxels of the
 * robot cell and of labelled scans: by the paper's laws, by the library's filter, by
 * PCL's and by published ones.
 */
#include "filter_times.h"
#include "measuring/command_line.h"
#include "measuring/result_file.h"
#include "method_results.h"
#include "methods.h"
#include "scan_program.h"
#include "shell_weights.h"
#include "simulator/labelled_lidar.h"
#include "stream_bytes.h"
#include "temporal_rates.h"
#include "temporal_results.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

struct NoiseOptions {
  std::string part = "all";
  /** \brief Up to 7 for parts laws and weights, 8 for temporal, else 6; empty: sensor 1,
   * of part temporal all. */
  std::vector<unsigned int> sensors;
  std::uint32_t frames = 300;
  std::uint32_t seed = 1;
  std::vector<double> given_resolutions; ///< voxel edges, metres; several: part scans
  double resolution = 0.04;              ///< the only one of them or its default
  std::string results_file;              ///< empty: standard output
  std::string samples_folder;            ///< for pictures of part temporal; empty: none
  ScanOptions scans;
  cell::LidarWeather weather; ///< of sensor 7
  RateOptions rates;

  /** \brief The one voxel edge that was given.
   * \throws std::invalid_argument if there are several
   */
  std::optional<double>
  givenResolution() const
  {
    if (given_resolutions.size() > 1)
      throw std::invalid_argument("--resolution: several are for part scans");
    return given_resolutions.empty() ? std::nullopt
                                     : std::optional<double>(given_resolutions[0]);
  }

  bool
  includes(const std::string& one) const
  {
    return part == "all" || part == one;
  }
};

void
addWeatherOptions(CLI::App& program, NoiseOptions& options)
{
  using cell::Weather;
  program
      .add_option_function<std::string>(
          "--weather",
          [&options](const std::string& name) {
            options.weather.kind = name == "snow"   ? Weather::Snow
                                   : name == "dust" ? Weather::Dust
                                                    : Weather::None;
            if (name != "none")
              options.scans.cell_sensor += " in " + name;
          },
          "of sensor 7 in parts laws and scans: none, snow or dust")
      ->check(CLI::IsMember({"none", "snow", "dust"}));
  program
      .add_option(
          "--snowfall", options.weather.snow.rate, "with snow, mm of water an hour")
      ->check(CLI::Range(0.01, 50.0));
  program
      .add_option("--extinction",
                  options.weather.dust.extinction,
                  "in the centre of the cloud of dust, 1/m")
      ->check(CLI::Range(0.0, 100.0));
}

void
addOptions(CLI::App& program, NoiseOptions& options)
{
  program.option_defaults()->always_capture_default();
  program
      .add_option(
          "--part",
          options.part,
          "laws (the paper's laws and the library's filter), peers (PCL's "
          "filters), time, bytes (of a stream whose noise is removed), weights "
          "(fit of the filter's), merged (all six cameras), temporal "
          "(TemporalVoxelFilter, not part of all), rates (the same at other rates "
          "of frames and with other noise, not part of all), scans (points and voxels "
          "of "
          "labelled scans, not part of all; implied by --labelled) or all")
      ->check(CLI::IsMember({"all",
                             "bytes",
                             "merged",
                             "laws",
                             "peers",
                             "rates",
                             "scans",
                             "temporal",
                             "time",
                             "weights"}));
  program
      .add_option("--sensor",
                  options.sensors,
                  "sensors, 1 to 6, and 7, the lidar, for parts laws, temporal and "
                  "weights, and 8, the camera on a hand, for parts temporal and rates; "
                  "without it sensor 1, of parts temporal and rates all")
      ->check(CLI::Range(1u, hand_camera));
  program.add_option("--frames,-n", options.frames, "number of frames")
      ->check(CLI::Range(1, std::numeric_limits<std::int32_t>::max()));
  program.add_option("--seed", options.seed, "of the noise");
  program
      .add_option(
          "--resolution,-r",
          options.given_resolutions,
          "voxel edge, metres; without it 0.04, and of part temporal the cameras "
          "1 to 6 also at 0.02 with counts; of part scans several, without it 0.05, "
          "0.1 and 0.2")
      ->check(CLI::Range(0.001, 1.0));
  program.add_option(
      "--results", options.results_file, "file; without it results are printed");
  program
      .add_option("--samples",
                  options.samples_folder,
                  "folder for samples of part temporal's first stream: its worst frame "
                  "and the bytes of each frame")
      ->check(CLI::ExistingDirectory);
  program
      .add_option("--step",
                  options.rates.step,
                  "of part rates: each n-th frame, so that the rate is an n-th")
      ->check(CLI::Range(1, 100));
  program
      .add_option("--depth-noise",
                  options.rates.depth_noise,
                  "of part rates and the cameras: a, b and c of the standard deviation "
                  "a + b d + c d^2, millimetres, of a depth d, metres; 0 0 0: the "
                  "simulator's")
      ->check(CLI::Range(0.0, 100.0));
  addScanOptions(program, options.scans);
  addWeatherOptions(program, options);
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
                  LabelledLidar(seed, resolution, options.weather),
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
measureTemporal(const NoiseOptions& options, measuring::ResultFile& results)
{
  const std::vector<unsigned int> sensors =
      options.sensors.empty() ? std::vector<unsigned int>{1, 2, 3, 4, 5, 6, 7, 8}
                              : options.sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (options.part == "rates") {
      RateOptions rates = options.rates;
      rates.seed = options.seed;
      rates.frames = options.frames;
      rates.resolution = options.givenResolution().value_or(rates.resolution);
      measureRates(sensors[i], rates, results);
    }
    else
      measureTemporalFilter(options.seed,
                            sensors[i],
                            options.frames,
                            options.givenResolution(),
                            i == 0 ? options.samples_folder : "",
                            results);
}

void
measure(NoiseOptions options)
{
  if (options.part == "temporal" || options.part == "rates") {
    measuring::ResultFile results(options.results_file);
    measureTemporal(options, results);
    results.close();
    return;
  }
  if (options.part == "scans" || !options.scans.folder.empty()) {
    measuring::ResultFile results(options.results_file);
    cell::RobotCell cell(options.seed);
    cell.setLidarWeather(options.weather);
    measureScans(
        options.scans, cell, options.frames, options.given_resolutions, results);
    results.close();
    return;
  }
  options.resolution = options.givenResolution().value_or(options.resolution);
  if (options.sensors.empty())
    options.sensors = {1};
  const bool has_lidar = options.part == "laws" || options.part == "weights";
  for (const unsigned int sensor : options.sensors)
    if (sensor == hand_camera || (sensor == cell::RobotCell::lidar && !has_lidar))
      throw std::invalid_argument(
          "sensor 7, the lidar, is for parts laws, temporal and "
          "weights, and 8 for part temporal");
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
  NoiseOptions options;
  CLI::App program(
      "Measures how well noise is distinguished from surfaces in the voxels "
      "of the robot cell, and writes the results as CSV.",
      "measure_noise");
  addOptions(program, options);
  return measuring::runProgram(program, argc, argv, [&options] { measure(options); });
}
