/** \file
 * Runs all sensors of the simulated robot cell at once, for the report that
 * experiments/report.sh makes: the paper's section 3.3. A process for each coder, so that
 * none finds memory that another one left.
 */
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/result_file.h"
#include "measuring/sensors_at_once.h"

#include <boost/program_options.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace {

namespace options = boost::program_options;
using pcl_ext::measuring::NodeFigures;
using pcl_ext::measuring::ResultFile;
using pcl_ext::measuring::RunAtOnce;
using pcl_ext::measuring::Subject;
using pcl_ext::measuring::Variant;

struct AtOnceOptions {
  std::string file;
  Variant variant{};
  std::size_t frames = 0;
  double seconds = 0.0;
};

bool
parse(int argc, const char* const* argv, AtOnceOptions& result)
{
  options::options_description description(
      "Runs the nodes of all sensors and a central one at once.\n"
      "Usage: measure_at_once [options] file\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("file", options::value(&result.file)->required(), "CSV, for the results");
  option("coder",
         pcl_ext::measuring::choice(
             "coder", result.variant, pcl_ext::measuring::variantChoices())
             ->default_value("balanced"),
         "fast balanced small published");
  // All clouds are held in memory: a thousand of each sensor are 21 GB.
  option("frames,n",
         pcl_ext::measuring::count("frames", result.frames, 1, 1000)->default_value(60),
         "clouds of each sensor, 3.5 MB each, which are repeated");
  option("seconds",
         pcl_ext::measuring::number("seconds", result.seconds, 0.1, 86400.0)
             ->default_value(50.0),
         "to run");
  options::variables_map values;
  return pcl_ext::measuring::parseCommandLine(argc, argv, description, "file", values);
}

void
measure(const AtOnceOptions& options)
{
  const pcl_ext::measuring::Workload workload;
  const Variant& variant = options.variant;
  ResultFile results(options.file);
  const Subject run_itself{"at_once_run", "", variant.name, workload.resolution};
  results.add(run_itself, "clouds", static_cast<double>(options.frames));
  results.add(run_itself, "seconds", options.seconds);
  std::vector<pcl_ext::measuring::SensorAtWork> sensors =
      pcl_ext::measuring::sixKinects(workload, variant, options.frames);
  sensors.push_back(pcl_ext::measuring::cellLidar(workload, variant, options.frames));
  const double load = pcl_ext::measuring::loadAverage();
  // Nothing is removed before merging: no threshold fits counts and the lidar's own
  // intensities alike.
  constexpr float keep_all = 0.0f;
  const RunAtOnce run =
      pcl_ext::measuring::runAtOnce(sensors, options.seconds, keep_all);
  std::vector<NodeFigures> nodes = run.sensors;
  nodes.push_back(run.central);
  for (const NodeFigures& node : nodes) {
    const Subject subject{"at_once", node.name, variant.name, workload.resolution};
    results.add(subject, "frames_per_second", node.frames_per_second);
    results.add(subject, "megabits_per_second", node.megabits_per_second);
    results.add(subject, "cpu_percent", node.cpu_percent);
    results.add(subject, "cycle_ms", node.cycle_ms);
    results.add(subject, "max_cycle_ms", node.max_cycle_ms);
    results.add(subject, "memory_mb", node.megabytes);
  }
  const Subject map{"at_once", run.central.name, variant.name, workload.resolution};
  results.add(map, "load_before", load);
  results.add(map, "merge_ms", run.merge_ms);
  results.add(map, "merged_voxels", run.merged_voxels);
  results.close();
}

} // namespace

int
main(int argc, char** argv)
{
  return pcl_ext::measuring::runProgram("measure_at_once", [argc, argv] {
    AtOnceOptions options;
    if (parse(argc, argv, options))
      measure(options);
    return 0;
  });
}
