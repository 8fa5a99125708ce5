// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The tables noise and lidar_noise.
 */
#include "experiments/tables.h"
#include "measuring/results.h"
#include "scores.h"

#include <string>
#include <utility>

namespace pcl_ext {
namespace experiments {

namespace {

using noise::MethodRun;

void
addTimes(const measuring::Subject& subject,
         const MethodRun& run,
         measuring::Results& results)
{
  results.add(subject, "median_ms", run.ms.median(), run.ms.count());
  results.add(subject, "longest_ms", run.ms.largest(), run.ms.count());
}

cell::LidarWeather
weatherOf(const Options& options)
{
  cell::LidarWeather weather;
  weather.kind = options.weather == "snow"   ? cell::Weather::Snow
                 : options.weather == "dust" ? cell::Weather::Dust
                                             : cell::Weather::None;
  return weather;
}

} // namespace

void
measureNoise(const Options& options, std::ostream& output)
{
  measuring::Results results(output);
  for (const unsigned int sensor : options.sensorsOr({1, 2, 3, 4, 5, 6}))
    for (const double edge : options.edgesOr({0.04})) {
      noise::LabelledStream stream(options.seed, sensor, edge);
      std::vector<MethodRun> runs = noise::runsOf(
          noise::methodsNamed(options.methods, noise::cameraMethods(edge)));
      noise::LabelledFrame frame;
      for (std::uint32_t i = 0; i < options.frames; ++i) {
        stream.read(i, frame);
        for (MethodRun& run : runs)
          noise::score(frame, run);
      }
      for (MethodRun& run : runs) {
        measuring::Subject subject = {
            "noise", std::to_string(sensor), run.method.name, edge};
        addTimes(subject, run, results);
        noise::addJudgement(
            subject, run.method, std::move(run.voxels), options.frames, results);
      }
    }
}

void
measureLidarNoise(const Options& options, std::ostream& output)
{
  measuring::Results results(output);
  cell::RobotCell cell(options.seed);
  cell.setLidarWeather(weatherOf(options));
  const std::string sensor =
      options.weather == "none" ? "7" : "7 in " + options.weather;
  for (const double edge : options.edgesOr({0.1})) {
    std::vector<MethodRun> runs =
        noise::runsOf(noise::methodsNamed(options.methods, noise::lidarMethods()));
    noise::LabelledScan scan;
    for (std::uint32_t i = 0; i < options.frames; ++i) {
      noise::readScan(cell, i, edge, scan);
      for (MethodRun& run : runs)
        noise::score(scan, run);
    }
    for (MethodRun& run : runs) {
      measuring::Subject subject = {"lidar_points", sensor, run.method.name, edge};
      addTimes(subject, run, results);
      noise::addJudgement(
          subject, run.method, std::move(run.points), options.frames, results);
      subject.experiment = "lidar_voxels";
      noise::addJudgement(
          subject, run.method, std::move(run.voxels), options.frames, results);
    }
  }
}

} // namespace experiments
} // namespace pcl_ext
