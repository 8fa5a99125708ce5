/** \file
 * Measures this library beside the published layout, PCL's class, Draco and zstd, and
 * many streams. Prints the tables of doc/benchmarks.md.
 */
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/workload.h"
#include "tables/tables.h"

#include <cstdint>
#include <iostream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::measuring;

using PrintTable = void (*)(const Options&, std::ostream&);

const std::vector<std::pair<std::string, PrintTable>> all_tables = {
    {"efforts", printEfforts},
    {"from_sensor", printFromSensor},
    {"peers", printPeers},
    {"recorded", printRecorded},
    {"points", printPoints},
    {"profiles", printProfiles},
    {"scale", printScale}};

void
addOptions(CLI::App& program, Options& options)
{
  program.option_defaults()->always_capture_default();
  std::vector<std::string> names;
  for (const auto& table : all_tables)
    names.push_back(table.first);
  const CLI::Range at_least_one(1, std::numeric_limits<std::int32_t>::max());
  const CLI::Range seconds(0.01, 86400.0);
  program.add_option("recordings", options.recordings, "folders of clouds");
  program.add_option("--tables", options.tables, "tables to print")
      ->check(CLI::IsMember(names))
      ->required();
  program.add_option("--efforts", options.efforts, "of table scale")
      ->check(CLI::IsMember(variantNames()));
  program.add_option("--frames,-n", options.frames, "of a sensor of the robot cell")
      ->check(at_least_one);
  program
      .add_option("--repetitions",
                  options.repetitions,
                  "of each stream; the fastest time of each frame counts")
      ->check(at_least_one);
  program.add_option("--results", options.results_file, "points: CSV file to write");
  program.add_option("--edges", options.edges, "points: voxel edges, metres");
  program.add_option("--cloudini",
                     options.cloudini,
                     "points: cloudini's pcd_to_cloudini_converter, if it is there");
  program.add_option("--seconds", options.seconds, "scale: length of each run")
      ->check(seconds);
  program
      .add_option("--most-streams", options.most_streams, "scale: most streams to try")
      ->check(at_least_one);
  program.add_option(
      "--outlier-removal",
      options.outlier_removal,
      "scale: log-odds below which the sensors remove a voxel as noise, 0 "
      "being the filter's default; else they send all voxels");
  program
      .add_option("--temporal-filter",
                  options.temporal_filter,
                  "scale: frames over which the sensors filter their voxels, 8 "
                  "being usual; 0: they do not")
      ->check(CLI::Range(0u, pcl_ext::TemporalVoxelFilter::most_frames));
}

} // namespace

int
main(int argc, char** argv)
{
  Options options;
  CLI::App program("Measures this library and its peers, and prints Markdown.",
                   "benchmark");
  addOptions(program, options);
  return runProgram(program, argc, argv, [&options] {
    printMachine(std::cout);
    for (const auto& [name, print] : all_tables) {
      if (std::find(options.tables.begin(), options.tables.end(), name) ==
          options.tables.end())
        continue;
      std::cerr << "benchmark: " << name << '\n';
      print(options, std::cout);
      std::cout.flush();
    }
  });
}
