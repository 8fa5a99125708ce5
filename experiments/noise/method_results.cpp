#include "method_results.h"

#include "measuring/markdown_table.h"
#include "measuring/result_file.h"

#include <cmath>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using measuring::formatted;

constexpr double wanted_surfaces = 0.95;
constexpr std::size_t curve_steps = 50;

/** \brief Adds quantities of one subject, each of all frames together. */
class SubjectResults {
public:
  SubjectResults(measuring::Subject subject,
                 std::size_t frames,
                 measuring::ResultFile& results)
  : subject_(std::move(subject)), frames_(frames), results_(results)
  {}

  void
  add(const std::string& quantity, double value)
  {
    if (!std::isnan(value))
      results_.add(subject_, quantity, value, frames_);
  }

  /** \brief The decision of a threshold, and what it keeps of the person. */
  void
  add(const std::string& prefix, const JudgedVoxels& voxels, float threshold)
  {
    const Decision decision = voxels.at(threshold);
    add(prefix + "threshold", static_cast<double>(threshold));
    add(prefix + "precision", decision.precision);
    add(prefix + "recall", decision.recall);
    add(prefix + "f1", decision.f1);
    add(prefix + "let_through_percent", 100.0 * decision.kept[0]);
    add(prefix + "surface_kept_percent", 100.0 * decision.surface_kept);
    add(prefix + "still_kept_percent", 100.0 * decision.kept[1]);
    add(prefix + "machine_kept_percent", 100.0 * decision.kept[2]);
    add(prefix + "person_kept_percent", 100.0 * decision.kept[3]);
    add(prefix + "pole_kept_percent", 100.0 * decision.kept[4]);
    const PersonKept person = voxels.personKept(threshold);
    add(prefix + "person_worst_percent", 100.0 * person.worst_share);
    add(prefix + "person_frames", static_cast<double>(person.frames));
    add(prefix + "person_poor_frames", static_cast<double>(person.poor_frames));
  }

private:
  measuring::Subject subject_;
  std::size_t frames_;
  measuring::ResultFile& results_;
};

std::string
nameOfBand(const std::vector<float>& ends, std::size_t band)
{
  const auto metres = [](float end) { return formatted(static_cast<double>(end), 0); };
  if (band == 0)
    return "up to " + metres(ends[band]) + " m";
  if (band + 1 == ends.size())
    return metres(ends[band - 1]) + " m and more";
  return metres(ends[band - 1]) + " to " + metres(ends[band]) + " m";
}

void
addMethod(const Measured& measured,
          const std::string& method,
          const std::vector<float>& thresholds,
          const JudgedVoxels& voxels,
          measuring::ResultFile& results)
{
  const auto resultsOf = [&](const std::string& suffix) {
    return SubjectResults(
        {measured.experiment + suffix, measured.sensor, method, measured.resolution},
        measured.frames,
        results);
  };
  const float usual_threshold = voxels.thresholdThatKeeps(wanted_surfaces);
  SubjectResults all = resultsOf("");
  all.add("noise_percent", 100.0 * voxels.noiseShare());
  all.add("average_precision", voxels.averagePrecision());
  all.add("best_", voxels, voxels.bestThreshold());
  all.add("usual_", voxels, usual_threshold);
  for (const float threshold : thresholds)
    resultsOf("_threshold:" + formatted(static_cast<double>(threshold), 1))
        .add("", voxels, threshold);
  SubjectResults curve = resultsOf("_curve");
  const std::vector<double> precisions = voxels.precisionsOverRecall(curve_steps);
  for (std::size_t i = 0; i < precisions.size(); ++i)
    curve.add("precision at recall " +
                  formatted(static_cast<double>(i + 1) / curve_steps, 2),
              precisions[i]);
  if (!measured.has_depths)
    return;
  const auto frames = static_cast<double>(measured.frames);
  for (std::size_t i = 0; i < voxels.bandEnds().size(); ++i) {
    SubjectResults band = resultsOf("_band:" + nameOfBand(voxels.bandEnds(), i));
    const VoxelNumbers numbers = voxels.numbers(i);
    const Decision usual = voxels.at(usual_threshold, i);
    band.add("noise_" + measured.unit, static_cast<double>(numbers.noise) / frames);
    band.add("surface_" + measured.unit, static_cast<double>(numbers.surface) / frames);
    band.add("average_precision", voxels.averagePrecision(i));
    band.add("let_through_percent", 100.0 * usual.kept[0]);
    band.add("surface_kept_percent", 100.0 * usual.surface_kept);
  }
}

} // namespace

void
addDecisions(const Measured& measured, Method method, measuring::ResultFile& results)
{
  const JudgedVoxels voxels(std::move(method.voxels));
  SubjectResults all(
      {measured.experiment, measured.sensor, method.name, measured.resolution},
      measured.frames,
      results);
  all.add("noise_percent", 100.0 * voxels.noiseShare());
  for (const float threshold : method.thresholds)
    all.add("given_", voxels, threshold);
}

void
addResults(const Measured& measured,
           std::vector<Method> methods,
           measuring::ResultFile& results)
{
  for (Method& method : methods)
    addMethod(measured,
              method.name,
              method.thresholds,
              JudgedVoxels(std::move(method.voxels)),
              results);
}

} // namespace noise
} // namespace pcl_ext
