#include "comparison_options.h"

#include "measuring/command_line.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

namespace options = boost::program_options;

const std::vector<std::string>&
tableNames()
{
  static const std::vector<std::string> names = {
      "peers", "efforts", "stages", "raw", "recorded", "bits", "points", "edges"};
  return names;
}

options::options_description
describeOptions(ComparisonOptions& result)
{
  options::options_description description(
      "Compares this library's efforts with the published layout, PCL, Draco and zstd "
      "on "
      "the same clouds, and prints Markdown.\n"
      "Usage: compare_with_peers [options] [folder of PCD files ...]\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and stop");
  option("recording", options::value(&result.recordings), "folders of PCD files");
  option(
      "tables",
      options::value(&result.tables)->multitoken(),
      "which to make (default: all but bits): peers efforts stages raw recorded bits "
      "points edges");
  option("frames,n",
         options::value(&result.frames)->default_value(300),
         "of the robot cell");
  option("sensor", options::value(&result.sensor)->default_value(1), "1 to 6");
  option("i-frame-rate",
         options::value(&result.i_frame_rate)->default_value(30),
         "frames from one I-frame to the next");
  option("error-every",
         options::value(&result.error_every)->default_value(10),
         "frames from one whose errors are searched to the next; 0: none");
  option("repetitions",
         options::value(&result.repetitions)->default_value(3),
         "of each stream; each frame's fastest counts");
  option("growth-frames",
         options::value(&result.growth_frames)->default_value(5),
         "of the sampled room for each number of points and each voxel edge");
  option("fewest-points",
         options::value(&result.fewest_points)->default_value(1000),
         "of the sampled room");
  option("most-points",
         options::value(&result.most_points)->default_value(10000000),
         "of the sampled room");
  option("edge-points",
         options::value(&result.edge_points)->default_value(1000000),
         "of the sampled room while the voxel edge changes");
  return description;
}

void
check(const ComparisonOptions& options)
{
  for (const std::string& table : options.tables)
    if (std::count(tableNames().begin(), tableNames().end(), table) == 0)
      throw std::invalid_argument("--tables knows no '" + table + "'");
  if (options.frames == 0 || options.repetitions == 0 || options.growth_frames == 0 ||
      options.fewest_points == 0 || options.edge_points == 0)
    throw std::invalid_argument(
        "numbers of frames, repetitions and points must be above "
        "0");
}

} // namespace

bool
ComparisonOptions::wants(const std::string& table) const
{
  if (tables.empty()) // but for what has a section of its own in doc/benchmarks.md
    return table != "bits";
  return std::count(tables.begin(), tables.end(), table) > 0;
}

std::optional<ComparisonOptions>
parseComparisonOptions(int argc, const char* const* argv)
{
  ComparisonOptions result;
  const options::options_description description = describeOptions(result);
  options::variables_map values;
  if (!parseCommandLine(argc, argv, description, "recording", values))
    return std::nullopt;
  check(result);
  return result;
}

} // namespace measuring
} // namespace pcl_ext
