// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Measures this library: beside the published layout, PCL's class, Draco and zstd, with
 * many streams, in the paper's experiments, and against the truth of the robot cell.
 * Prints the tables of the documents, and results for the report.
 */
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "experiments/tables.h"
#include "measuring/machine.h"
#include "measuring/workload.h"
#include "tables/tables.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::measuring;
using namespace pcl_ext::experiments;

const std::vector<Table> all_tables = {{"efforts", printEfforts},
                                       {"from_sensor", printFromSensor},
                                       {"peers", printPeers},
                                       {"recorded", printRecorded},
                                       {"points", printPoints},
                                       {"profiles", printProfiles},
                                       {"scale", printScale},
                                       {"centre", printCentre},
                                       {"rate", printRateControl},
                                       {"streams", measureStreams},
                                       {"at_once", measureAtOnce},
                                       {"noise", measureNoise},
                                       {"lidar_noise", measureLidarNoise},
                                       {"temporal", measureTemporalFilter},
                                       {"pictures", writePictures}};

const CLI::Range at_least_one(1, std::numeric_limits<std::int32_t>::max());
const CLI::Range megabits(0.0, 1e6);

/** \brief Options of the tables that compare coders, and of many streams. */
void
addCoderOptions(CLI::App& program, Options& options)
{
  program.add_option("recordings", options.recordings, "folders of clouds");
  program.add_option("--efforts", options.efforts, "of tables scale and at_once")
      ->check(CLI::IsMember(variantNames()));
  program
      .add_option("--repetitions",
                  options.repetitions,
                  "of each stream; the fastest time of each frame counts")
      ->check(at_least_one);
  program.add_option("--cloudini",
                     options.cloudini,
                     "points: cloudini's pcd_to_cloudini_converter, if it is there");
  program
      .add_option(
          "--seconds", options.seconds, "scale, centre, at_once: length of each run")
      ->check(CLI::Range(0.01, 86400.0));
  program
      .add_option(
          "--most-streams", options.most_streams, "scale, centre: most streams to try")
      ->check(at_least_one);
  program.add_option(
      "--outlier-removal",
      options.outlier_removal,
      "scale: log-odds below which the sensors remove a voxel as noise, 0 "
      "being the filter's default; else they send all voxels");
  program
      .add_option("--temporal-filter",
                  options.temporal_filter,
                  "scale, centre: frames over which the sensors filter their voxels, 8 "
                  "being usual; 0: they do not")
      ->check(CLI::Range(0u, pcl_ext::TemporalVoxelFilter::most_frames));
}

/** \brief Options of the experiments on the robot cell. */
void
addCellOptions(CLI::App& program, Options& options)
{
  program
      .add_option("--sensors",
                  options.sensors,
                  "noise, rate: 1 to 6; temporal: also 7, the lidar, and 8, the camera "
                  "on a hand; without it all, of rate 1")
      ->check(CLI::Range(1, 8));
  program.add_option("--seed", options.seed, "of the robot cell");
  program.add_option("--methods",
                     options.methods,
                     "noise, lidar_noise: only those with one of these in their names");
  program.add_option("--weather", options.weather, "lidar_noise: none, snow or dust")
      ->check(CLI::IsMember({"none", "snow", "dust"}));
  program.add_option("--folder", options.folder, "pictures: for the CSV files")
      ->check(CLI::ExistingDirectory);
  program.add_option("--rates", options.rates, "rate: of steady links, Mbit/s")
      ->check(megabits);
  program
      .add_option("--wireless",
                  options.wireless,
                  "rate: highest rate of a Wi-Fi, Mbit/s; 0: none")
      ->check(megabits);
  program
      .add_option("--rate-buffer", options.rate_buffer, "rate: with max_rate, seconds")
      ->check(CLI::Range(0.01, 1.0));
  program.add_flag("--change",
                   options.changes_scene,
                   "rate: from the middle on the sensor is the camera on a hand");
}

void
addOptions(CLI::App& program, Options& options)
{
  program.option_defaults()->always_capture_default();
  std::vector<std::string> names;
  for (const Table& table : all_tables)
    names.emplace_back(table.name);
  program.add_option("--tables", options.tables, "tables to print")
      ->check(CLI::IsMember(names))
      ->required();
  program.add_option("--frames,-n", options.frames, "of a sensor of the robot cell")
      ->check(CLI::Range(1, 1000000));
  program
      .add_option("--edges,-r",
                  options.edges,
                  "voxel edges, metres, of points, noise, "
                  "lidar_noise, temporal and rate")
      ->check(CLI::Range(0.0001, 1.0));
  addCoderOptions(program, options);
  addCellOptions(program, options);
}

/** \brief Refuses what a table cannot measure, before anything is measured. */
void
checkOptions(const Options& options)
{
  const auto isWanted = [&](const char* table) {
    return std::find(options.tables.begin(), options.tables.end(), table) !=
           options.tables.end();
  };
  if ((isWanted("noise") || isWanted("rate")) &&
      std::any_of(options.sensors.begin(), options.sensors.end(), [](unsigned int it) {
        return it > pcl_ext::cell::RobotCell::sensor_count;
      }))
    throw std::invalid_argument("--sensors: tables noise and rate are of cameras, 1 to "
                                "6; of the lidar there is table lidar_noise");
  if (isWanted("pictures") && options.folder.empty())
    throw std::invalid_argument("table pictures needs a --folder to write to");
}

} // namespace

int
main(int argc, char** argv)
{
  Options options;
  CLI::App program(
      "Measures this library and its peers, and prints Markdown or, of the "
      "experiments, CSV.",
      "benchmark");
  addOptions(program, options);
  try {
    program.parse(argc, argv);
    checkOptions(options);
    printMachine(std::cout);
    for (const Table& table : all_tables) {
      if (std::find(options.tables.begin(), options.tables.end(), table.name) ==
          options.tables.end())
        continue;
      std::cerr << "benchmark: " << table.name << '\n';
      table.print(options, std::cout);
      if (!std::cout.flush())
        throw std::runtime_error("the table cannot be written");
    }
    return 0;
  }
  catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 1;
  }
  catch (const std::exception& error) {
    std::cerr << "benchmark: " << error.what() << '\n';
    return 1;
  }
}
