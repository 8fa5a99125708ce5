/** \file
 * Runs all sensors of the simulated robot cell at once, for the report that
 * experiments/report.sh makes: the paper's section 3.3. A process for each coder, so
 * that none finds memory that another one left.
 */
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/result_file.h"
#include "sensors_at_once.h"

#include <cstddef>
#include <string>
#include <vector>

namespace {

using pcl_ext::measuring::ResultFile;
using pcl_ext::measuring::Subject;
using pcl_ext::measuring::Variant;
using pcl_ext::report::NodeFigures;
using pcl_ext::report::RunAtOnce;

struct AtOnceOptions {
  std::string file;
  std::string coder = "balanced";
  std::size_t frames = 60;
  double seconds = 50.0;
};

void
measure(const AtOnceOptions& options)
{
  const pcl_ext::measuring::Workload workload;
  const Variant& variant = pcl_ext::measuring::variantNamed(options.coder);
  ResultFile results(options.file);
  const Subject run_itself{"at_once_run", "", variant.name, workload.resolution};
  results.add(run_itself, "clouds", static_cast<double>(options.frames));
  results.add(run_itself, "seconds", options.seconds);
  std::vector<pcl_ext::report::SensorAtWork> sensors =
      pcl_ext::report::sixKinects(workload, variant, options.frames);
  sensors.push_back(pcl_ext::report::cellLidar(workload, variant, options.frames));
  const double load = pcl_ext::measuring::loadAverage();
  // Nothing is removed before merging: no threshold fits counts and the lidar's own
  // intensities alike.
  constexpr float keep_all = 0.0f;
  const RunAtOnce run = pcl_ext::report::runAtOnce(sensors, options.seconds, keep_all);
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
  AtOnceOptions options;
  CLI::App program("Runs the nodes of all sensors and a central one at once.",
                   "measure_at_once");
  program.option_defaults()->always_capture_default();
  program.add_option("file", options.file, "CSV, for the results")->required();
  program.add_option("--coder", options.coder, "effort or layout of all streams")
      ->check(CLI::IsMember(pcl_ext::measuring::variantNames()));
  // All clouds are held in memory: a thousand of each sensor are 21 GB.
  program
      .add_option("--frames,-n",
                  options.frames,
                  "clouds of each sensor, 3.5 MB each, which are repeated")
      ->check(CLI::Range(1, 1000));
  program.add_option("--seconds", options.seconds, "to run")
      ->check(CLI::Range(0.1, 86400.0));
  return pcl_ext::measuring::runProgram(
      program, argc, argv, [&options] { measure(options); });
}
