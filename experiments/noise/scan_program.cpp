#include "scan_program.h"

#include "measuring/command_line.h"
#include "measuring/result_file.h"
#include "scan_methods.h"
#include "scan_results.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief Steps of a VLP-16 as it is simulated, and of an HDL-64 whose revolutions are
 * images of 2048 columns. */
constexpr RaySteps cell_steps = {0.2, 2.0};
constexpr RaySteps image_steps = {360.0 / 2048.0, 0.425};

bool
isWanted(const ScanMethod& method, const std::vector<std::string>& names)
{
  return names.empty() ||
         std::any_of(names.begin(), names.end(), [&](const std::string& name) {
           return method.name.find(name) != std::string::npos;
         });
}

std::vector<ScanMethod>
wantedMethods(const ScanOptions& options)
{
  RaySteps steps = options.folder.empty() ? cell_steps : image_steps;
  steps.azimuth = options.azimuth_step.value_or(steps.azimuth);
  steps.ring = options.ring_step.value_or(steps.ring);
  std::vector<ScanMethod> all = scanMethods(steps);
  if (!options.predictions.empty())
    all.push_back(predictions(options.predictions, options.meanings));
  std::vector<ScanMethod> wanted;
  std::copy_if(
      all.begin(),
      all.end(),
      std::back_inserter(wanted),
      [&](const ScanMethod& method) { return isWanted(method, options.methods); });
  if (wanted.empty())
    throw std::invalid_argument("no method has a name with '" +
                                options.methods.front() + "' in it");
  return wanted;
}

/** \brief Last folder of a path, without commas. */
std::string
sensorName(const std::string& folder)
{
  std::string name = std::filesystem::canonical(folder).filename().string();
  std::replace(name.begin(), name.end(), ',', '_');
  return name;
}

} // namespace

void
addScanOptions(CLI::App& program, ScanOptions& options)
{
  program
      .add_option("--labelled",
                  options.folder,
                  "folder of labelled scans, for part scans: .bin and .label files in "
                  "it, in its folders velodyne and labels (SemanticKITTI), or "
                  "snow_velodyne and snow_labels (SnowyKITTI), or PCD files with a "
                  "field label")
      ->check(CLI::ExistingDirectory);
  program
      .add_option("--rows",
                  options.rows,
                  "rows of the images that .bin files are, 64 for SnowyKITTI; 1: none")
      ->check(CLI::Range(1, 4096));
  program.add_option("--first-frame", options.first_frame, "of part scans, from 0");
  program.add_option("--noise-labels",
                     options.meanings.noise,
                     "labels of noise; 1 is snow in SnowyKITTI and an outlier in "
                     "SemanticKITTI, 110 falling snow in WADS");
  program.add_option("--person-labels", options.meanings.persons, "labels of persons");
  program.add_option("--pole-labels", options.meanings.poles, "labels of poles");
  program.add_option("--ignore-labels",
                     options.meanings.ignored,
                     "labels that are not judged: 0 for SemanticKITTI and WADS, where "
                     "it is unlabelled; none for SnowyKITTI, where it is all surfaces");
  program
      .add_option("--azimuth-step",
                  options.azimuth_step,
                  "of the lidar, degrees; without it 0.2 for sensor 7, else that of "
                  "2048 columns")
      ->check(CLI::Range(0.001, 10.0));
  program
      .add_option("--ring-step",
                  options.ring_step,
                  "of the lidar, degrees; without it 2 for sensor 7, else 0.425")
      ->check(CLI::Range(0.001, 90.0));
  program
      .add_option("--predictions",
                  options.predictions,
                  "folder of a network's .label files, one for each scan by its name, "
                  "as a peer in part scans; --noise-labels say what they mean")
      ->check(CLI::ExistingDirectory);
  program.add_option("--methods",
                     options.methods,
                     "of part scans only those with one of these in their names");
}

void
measureScans(const ScanOptions& options,
             const cell::RobotCell& cell,
             std::size_t most_frames,
             std::vector<double> resolutions,
             measuring::ResultFile& results)
{
  if (resolutions.empty())
    resolutions = {0.05, 0.1, 0.2};
  std::unique_ptr<LabelledScans> scans;
  ScanRange range;
  if (options.folder.empty()) {
    scans = std::make_unique<ScansOfCell>(cell);
    range.sensor = options.cell_sensor;
  }
  else {
    scans =
        std::make_unique<ScansOfFolder>(options.folder, options.meanings, options.rows);
    range.sensor = sensorName(options.folder);
  }
  if (options.first_frame >= scans->size())
    throw std::runtime_error("there is no scan " + std::to_string(options.first_frame) +
                             ": there are " + std::to_string(scans->size()));
  range.first = options.first_frame;
  range.count = std::min(most_frames, scans->size() - range.first);
  range.resolutions = std::move(resolutions);
  for (const ScanMethod& method : wantedMethods(options))
    judgeScans(*scans, range, method, results);
}

} // namespace noise
} // namespace pcl_ext
