/** \file
 * Compares this library's efforts with the published layout, PCL's class, Draco and
 * zstd on the same clouds, in one run; in one thread, except for a table of threads. Prints
 * the tables of doc/benchmarks.md.
 */
#include "comparison_tables.h"
#include "measuring/command_line.h"
#include "measuring/machine.h"

#include <boost/program_options.hpp>

#include <cstddef>
#include <iostream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::measuring;
namespace options = boost::program_options;

struct Table {
  std::string name;
  void (*print)(const ComparisonOptions&, std::ostream&);
};

const std::vector<Table> all_tables = {{"efforts", printEfforts},
                                       {"stages", printStages},
                                       {"raw", printRawToBytes},
                                       {"peers", printPeers},
                                       {"recorded", printRecorded},
                                       {"points", printGrowthWithPoints},
                                       {"edges", printGrowthWithEdge},
                                       {"threads", printThreads},
                                       {"profiles", printProfiles},
                                       {"bits", printBits}};

/** \brief Those that have a section of their own in doc/benchmarks.md. */
constexpr std::ptrdiff_t tables_apart = 2;

Choices<Table>
tableChoices()
{
  Choices<Table> choices;
  for (const Table& table : all_tables)
    choices.emplace_back(table.name, table);
  return choices;
}

bool
parse(int argc,
      const char* const* argv,
      ComparisonOptions& result,
      std::vector<Table>& tables)
{
  tables.assign(all_tables.begin(), all_tables.end() - tables_apart);
  options::options_description description(
      "Compares this library's efforts with the published layout, PCL, Draco and zstd "
      "on the same clouds, and prints Markdown.\n"
      "Usage: compare_with_peers [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("recording", options::value(&result.recordings), "folders of PCD files");
  option(
      "tables",
      choiceOfSeveral("tables", tables, tableChoices()),
      "tables to print (default: all but profiles and bits): efforts stages raw peers "
      "recorded points edges threads profiles bits");
  option("frames,n",
         count("frames", result.frames, 1)->default_value(300),
         "frames of the robot cell");
  option("sensor",
         count("sensor", result.sensor, 1, 6)->default_value(1),
         "sensor of the robot cell, 1 to 6");
  option("i-frame-rate",
         count("i-frame-rate", result.i_frame_rate, 0)->default_value(30),
         "frames from one I-frame to the next");
  option("error-every",
         count("error-every", result.error_every, 0)->default_value(10),
         "frames from one whose position errors are measured to the next; 0: none");
  option("repetitions",
         count("repetitions", result.repetitions, 1)->default_value(3),
         "repetitions of each stream; the fastest time of each frame counts");
  option("growth-frames",
         count("growth-frames", result.growth_frames, 1)->default_value(5),
         "frames of the sampled room for each number of points and each voxel edge");
  option("fewest-points",
         count("fewest-points", result.fewest_points, 1)->default_value(1000),
         "least number of points of the sampled room");
  option("most-points",
         count("most-points", result.most_points, 1)->default_value(10000000),
         "largest number of points of the sampled room");
  option("edge-points",
         count("edge-points", result.edge_points, 1)->default_value(1000000),
         "points of the sampled room while the voxel edge changes");
  options::variables_map values;
  return parseCommandLine(argc, argv, description, "recording", values);
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("compare_with_peers", [argc, argv] {
    ComparisonOptions options;
    std::vector<Table> tables;
    if (!parse(argc, argv, options, tables))
      return 0;
    printMachine(std::cout);
    for (const Table& table : tables) {
      std::cerr << "compare_with_peers: " << table.name << '\n';
      table.print(options, std::cout);
      std::cout.flush();
    }
    return 0;
  });
}
