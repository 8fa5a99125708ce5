/** \file
 * Measures how many streams one central computer decodes and one link carries. Prints
 * the tables of doc/benchmarks.md about them.
 */
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "scale_tables.h"

#include <boost/program_options.hpp>

#include <iostream>
#include <stdexcept>
#include <string>

namespace {

using namespace pcl_ext::measuring;
namespace options = boost::program_options;

constexpr double shortest_run = 0.01; // seconds
constexpr double longest_run = 86400.0;

bool
parse(int argc, const char* const* argv, ScaleOptions& result)
{
  result.variants = libraryVariants();
  pcl_ext::VoxelOutlierRemovalSettings outlier_removal;
  options::options_description description(
      "Finds how many 20 Hz streams one CentralNode decodes in time and how many a "
      "gigabit link carries, runs six sensors at once, and prints Markdown.\n"
      "Usage: measure_scale [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("recording",
         options::value(&result.recordings),
         "folders of PCD files whose streams are sent besides the robot cell's");
  option("efforts",
         choiceOfSeveral("efforts", result.variants, variantChoices()),
         "efforts of the streams: fast balanced small published (default: all)");
  option("frames,n",
         count("frames", result.frames, 1)->default_value(300),
         "frames of each sensor of the robot cell, a multiple of 30");
  option("seconds",
         number("seconds", result.seconds, shortest_run, longest_run)
             ->default_value(5.0, "5"),
         "length of each run");
  option("most-streams",
         count("most-streams", result.most_streams, 1)->default_value(800),
         "largest number of streams to try");
  option("sensor-seconds",
         number("sensor-seconds", result.sensor_seconds, shortest_run, longest_run)
             ->default_value(15.0, "15"),
         "length of the run of six sensors");
  option("sensor-frames",
         count("sensor-frames", result.sensor_frames, 1)->default_value(60),
         "clouds of each of the six, 3.5 MB each, which are repeated");
  option("outlier-removal",
         options::value(&outlier_removal.min_log_odds),
         "log-odds below which the sensors remove a voxel as noise, 0 being the "
         "default of the filter; without this option they send all voxels");
  options::variables_map values;
  if (!parseCommandLine(argc, argv, description, "recording", values))
    return false;
  if (values.count("outlier-removal") != 0)
    result.workload.outlier_removal = outlier_removal;
  const unsigned int i_frame_rate = result.workload.i_frame_rate;
  if (result.frames >= i_frame_rate && result.frames % i_frame_rate != 0)
    throw std::invalid_argument("--frames is " + std::to_string(result.frames) +
                                "; it must be a multiple of " +
                                std::to_string(i_frame_rate) +
                                ", as streams are repeated from their first I-frame");
  return true;
}

} // namespace

int
main(int argc, char** argv)
{
  return runProgram("measure_scale", [argc, argv] {
    ScaleOptions options;
    if (!parse(argc, argv, options))
      return 0;
    printMachine(std::cout);
    printManyStreams(options, std::cout);
    printSixSensors(options, std::cout);
    return 0;
  });
}
