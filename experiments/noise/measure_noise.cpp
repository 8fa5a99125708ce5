/** \file
 * \brief Prints how well noise is told from surfaces in the voxels of the robot cell: by
 * the paper's laws, by the library's filter and by PCL's.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "fused_stream.h"
#include "methods.h"
#include "point_filters.h"
#include "shell_weights.h"
#include "stream_bytes.h"

#include <boost/program_options.hpp>

#include <machine.h>
#include <markdown_table.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

struct Options {
  std::vector<unsigned int> sensors;
  std::uint32_t frames = 0;
  std::uint32_t seed = 0;
  double resolution = 0.0;
  std::string part;
};

std::vector<Method>
allMethods(bool are_merged)
{
  std::vector<Method> methods = lawMethods();
  for (Method& method : filterMethods(are_merged))
    methods.push_back(std::move(method));
  return methods;
}

void
measureSensor(unsigned int sensor, const Options& options)
{
  LabelledStream stream(options.seed, sensor, options.resolution);
  std::vector<Method> methods = allMethods(false);
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    stream.read(i, frame);
    judge(frame, methods);
  }
  std::cout << "## Sensor " << sensor << "\n\n";
  printFigures(methods, std::cout);
  printBands(methods, std::cout);
  printThresholds(methods, std::cout);
}

/** \brief Each sensor's voxels are judged by themselves; what one sensor takes for a
 * surface stays. */
Method
sensorsAloneMethod(const FusedStream& stream)
{
  const auto removals =
      std::make_shared<std::vector<VoxelOutlierRemoval>>(cell::RobotCell::sensor_count);
  Method method;
  method.name = "filter, quadratic, each sensor alone";
  method.thresholds = {0.0f, 2.5f};
  method.score = [removals, &stream](const LabelledFrame& merged,
                                     std::vector<float>& scores) {
    const auto& keys = merged.of(Law::Quadratic).keys;
    scores.assign(keys.size(), -1e9f);
    std::vector<float> of_sensor;
    for (std::size_t sensor = 0; sensor < removals->size(); ++sensor) {
      const io::VoxelFrame& voxels = stream.sensorFrames()[sensor].of(Law::Quadratic);
      (*removals)[sensor].score(voxels, of_sensor);
      std::size_t at = 0;
      for (std::size_t i = 0; i < of_sensor.size(); ++i) {
        while (keys[at] != voxels.keys[i])
          ++at;
        scores[at] = std::max(scores[at], of_sensor[i]);
      }
    }
  };
  return method;
}

void
measureFused(const Options& options)
{
  FusedStream stream(options.seed, options.resolution);
  std::vector<Method> methods = allMethods(true);
  methods.push_back(sensorsAloneMethod(stream));
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    stream.read(i, frame);
    judge(frame, methods);
  }
  std::cout << "## All six sensors, merged\n\n";
  printFigures(methods, std::cout);
  printThresholds(methods, std::cout);
}

std::vector<Method>
peerMethods(double resolution)
{
  std::vector<Method> methods;
  for (const int neighbours : {4, 8, 16, 26, 50})
    methods.push_back(
        {"StatisticalOutlierRemoval, " + std::to_string(neighbours) + " neighbours",
         [neighbours](const LabelledFrame& frame, std::vector<float>& scores) {
           statisticalScores(centresOf(frame.of(Law::Count)), neighbours, scores);
         },
         {},
         {}});
  // Between the distances to which voxels' centres can be apart.
  for (const double voxels : {1.2, 1.5, 1.8, 2.1, 2.5, 3.1, 4.1})
    methods.push_back(
        {"RadiusOutlierRemoval, " + benchmarks::formatted(voxels, 1) + " voxels",
         [voxels, resolution](const LabelledFrame& frame, std::vector<float>& scores) {
           radiusScores(centresOf(frame.of(Law::Count)), voxels * resolution, scores);
         },
         {},
         {}});
  methods.push_back(std::move(filterMethods(false).front()));
  return methods;
}

void
measurePeers(unsigned int sensor, const Options& options)
{
  LabelledStream stream(options.seed, sensor, options.resolution);
  std::vector<Method> methods = peerMethods(options.resolution);
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    stream.read(i, frame);
    judge(frame, methods);
  }
  std::cout << "## PCL's filters, sensor " << sensor << "\n\n";
  printFigures(methods, std::cout);
}

double
median(std::vector<double>& values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void
measureTimes(unsigned int sensor, const Options& options)
{
  LabelledStream stream(options.seed, sensor, options.resolution);
  VoxelOutlierRemoval on_quadratic;
  VoxelOutlierRemoval on_count;
  std::vector<std::vector<double>> milliseconds(6);
  double voxels = 0.0;
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    stream.read(i, frame);
    voxels += static_cast<double>(frame.truth.size()) / options.frames;
    for (const auto& [removal, law, column] :
         {std::tuple(&on_quadratic, Law::Quadratic, 0),
          std::tuple(&on_count, Law::Count, 1)}) {
      io::VoxelFrame filtered = frame.of(law);
      const double start = benchmarks::processCpuSeconds();
      removal->filter(filtered);
      milliseconds[static_cast<std::size_t>(column)].push_back(
          1e3 * (benchmarks::processCpuSeconds() - start));
    }
    const Centres::ConstPtr centres = centresOf(frame.of(Law::Count));
    milliseconds[2].push_back(1e3 * statisticalSeconds(centres, 8));
    milliseconds[3].push_back(1e3 * statisticalSeconds(centres, 26));
    milliseconds[4].push_back(1e3 * radiusSeconds(centres, 1.8 * options.resolution));
    milliseconds[5].push_back(1e3 * radiusSeconds(centres, 2.5 * options.resolution));
  }
  std::cout << "## Time, sensor " << sensor << ", " << benchmarks::formatted(voxels, 0)
            << " voxels, CPU milliseconds a frame\n\n";
  benchmarks::MarkdownTable table({"filter", "median", "longest"});
  const std::vector<std::string> names = {"VoxelOutlierRemoval, quadratic",
                                          "VoxelOutlierRemoval, count",
                                          "StatisticalOutlierRemoval, 8 neighbours",
                                          "StatisticalOutlierRemoval, 26 neighbours",
                                          "RadiusOutlierRemoval, 1.8 voxels",
                                          "RadiusOutlierRemoval, 2.5 voxels"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double middle = median(milliseconds[i]);
    table.addRow({names[i],
                  benchmarks::formatted(middle, 2),
                  benchmarks::formatted(milliseconds[i].back(), 2)});
  }
  table.print(std::cout);
}

void
measure(const Options& options)
{
  const auto wants = [&](const char* part) {
    return options.part == "all" || options.part == part;
  };
  std::cout << options.frames << " frames, seed " << options.seed << ", "
            << 100.0 * options.resolution << " cm\n\n";
  for (const unsigned int sensor : options.sensors) {
    if (wants("laws"))
      measureSensor(sensor, options);
    if (wants("peers"))
      measurePeers(sensor, options);
    if (wants("time"))
      measureTimes(sensor, options);
    if (wants("weights"))
      printShellWeights(
          options.seed, sensor, options.resolution, options.frames, std::cout);
    if (wants("bytes"))
      printStreamBytes(
          options.seed, sensor, options.frames, options.resolution, std::cout);
  }
  if (wants("fused"))
    measureFused(options);
}

} // namespace

int
main(int argc, char** argv)
{
  namespace po = boost::program_options;
  Options chosen;
  po::options_description description(
      "How well noise is told from surfaces in the voxels of the robot cell");
  description.add_options()("help", "show this text")(
      "sensor",
      po::value(&chosen.sensors)->multitoken()->default_value({1}, "1"),
      "sensors, 1 to 6")(
      "frames", po::value(&chosen.frames)->default_value(300), "frames to measure on")(
      "seed", po::value(&chosen.seed)->default_value(1), "seed of the noise")(
      "resolution",
      po::value(&chosen.resolution)->default_value(0.04),
      "voxel edge, metres")(
      "part",
      po::value(&chosen.part)->default_value("all"),
      "laws (the paper's laws and the library's filter), peers (PCL's filters), time, "
      "bytes (what a stream shrinks by), weights (a fit of the filter's), fused (all "
      "six "
      "sensors), or all");
  try {
    po::variables_map values;
    po::store(po::parse_command_line(argc, argv, description), values);
    po::notify(values);
    if (values.count("help") > 0) {
      std::cout << description;
      return 0;
    }
    if (chosen.frames == 0)
      throw std::invalid_argument("--frames must be at least 1");
    if (!(chosen.resolution >= 0.005))
      throw std::invalid_argument("--resolution must be at least 0.005");
    measure(chosen);
  }
  catch (const std::exception& error) {
    std::cerr << "measure_noise: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
