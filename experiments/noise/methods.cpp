#include "methods.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <cmath>
#include <iomanip>
#include <memory>
#include <ostream>
#include <sstream>

namespace pcl_ext {
namespace noise {

namespace {

constexpr double wanted_surfaces = 0.95;

Method
filterMethod(const std::string& name, Law law, VoxelOutlierRemovalSettings settings)
{
  const auto removal = std::make_shared<VoxelOutlierRemoval>(settings);
  return {name,
          [removal, law](const LabelledFrame& frame, std::vector<float>& scores) {
            removal->score(frame.of(law), scores);
          },
          {0.0f, 1.0f, 2.0f, 2.5f, 3.0f, 4.0f, 5.0f},
          {}};
}

std::string
percent(double share)
{
  return std::isnan(share) ? "-" : formatted(100.0 * share, 1);
}

} // namespace

std::string
formatted(double number, int digits)
{
  if (std::isnan(number)) // of no voxels
    return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << number;
  return text.str();
}

void
printTable(const std::vector<std::vector<std::string>>& rows, std::ostream& output)
{
  for (std::size_t row = 0; row < rows.size(); ++row) {
    output << '|';
    for (const std::string& cell : rows[row])
      output << ' ' << cell << " |";
    output << '\n';
    if (row > 0)
      continue;
    output << '|';
    for (std::size_t i = 0; i < rows[row].size(); ++i)
      output << "---|";
    output << '\n';
  }
  output << '\n';
}

std::vector<Method>
lawMethods()
{
  std::vector<Method> methods;
  for (const Law law : laws) {
    Method method;
    method.name = nameOf(law);
    method.score = [law](const LabelledFrame& frame, std::vector<float>& scores) {
      const io::VoxelFrame& voxels = frame.of(law);
      scores.clear();
      for (const std::uint16_t symbol : voxels.intensities)
        scores.push_back(voxels.intensity_scale.value(symbol));
    };
    if (law == Law::Count)
      method.thresholds = {2, 3, 4, 5, 7, 10, 15, 20};
    else
      method.thresholds = {13, 26, 38, 51, 77, 102, 128, 191, 255};
    methods.push_back(std::move(method));
  }
  return methods;
}

std::vector<Method>
filterMethods(bool are_merged)
{
  VoxelOutlierRemovalSettings shares;
  if (are_merged)
    shares.unit = DensityUnit::Faces;
  VoxelOutlierRemovalSettings alone = shares;
  alone.use_history = false;
  std::vector<Method> methods;
  methods.push_back(filterMethod("filter, quadratic", Law::Quadratic, shares));
  methods.push_back(
      filterMethod("filter, quadratic, no history", Law::Quadratic, alone));
  if (!are_merged)
    methods.push_back(filterMethod("filter, linear", Law::Linear, shares));
  methods.push_back(
      filterMethod("filter, count", Law::Count, VoxelOutlierRemovalSettings()));
  return methods;
}

void
judge(const LabelledFrame& frame, std::vector<Method>& methods)
{
  std::vector<float> scores;
  for (Method& method : methods) {
    method.score(frame, scores);
    method.voxels.add(frame, scores);
  }
}

void
printFigures(std::vector<Method>& methods, std::ostream& output)
{
  std::vector<std::vector<std::string>> rows = {{"score",
                                                 "average precision",
                                                 "best threshold",
                                                 "precision",
                                                 "recall",
                                                 "F1",
                                                 "threshold for 95 % of surfaces",
                                                 "noise let through %",
                                                 "kept: still %",
                                                 "machines %",
                                                 "person %"}};
  for (Method& method : methods) {
    method.voxels.sort();
    const Decision best = method.voxels.at(method.voxels.bestThreshold());
    const Decision usual =
        method.voxels.at(method.voxels.thresholdThatKeeps(wanted_surfaces));
    rows.push_back({method.name,
                    formatted(method.voxels.averagePrecision()),
                    formatted(static_cast<double>(best.threshold), 2),
                    formatted(best.precision),
                    formatted(best.recall),
                    formatted(best.f1),
                    formatted(static_cast<double>(usual.threshold), 2),
                    percent(usual.kept[0]),
                    percent(usual.kept[1]),
                    percent(usual.kept[2]),
                    percent(usual.kept[3])});
  }
  output << "Noise: " << percent(methods.front().voxels.noiseShare())
         << " % of the voxels.\n\n";
  printTable(rows, output);
}

void
printThresholds(const std::vector<Method>& methods, std::ostream& output)
{
  std::vector<std::vector<std::string>> rows = {{"score",
                                                 "threshold",
                                                 "precision",
                                                 "recall",
                                                 "F1",
                                                 "noise let through %",
                                                 "kept: surfaces %",
                                                 "still %",
                                                 "machines %",
                                                 "person %"}};
  for (const Method& method : methods)
    for (const float threshold : method.thresholds) {
      const Decision decision = method.voxels.at(threshold);
      rows.push_back({method.name,
                      formatted(static_cast<double>(threshold), 1),
                      formatted(decision.precision),
                      formatted(decision.recall),
                      formatted(decision.f1),
                      percent(decision.kept[0]),
                      percent(decision.surface_kept),
                      percent(decision.kept[1]),
                      percent(decision.kept[2]),
                      percent(decision.kept[3])});
    }
  printTable(rows, output);
}

void
printBands(const std::vector<Method>& methods, std::ostream& output)
{
  std::vector<std::vector<std::string>> rows = {{"score"}};
  for (std::size_t band = 0; band < band_count; ++band) {
    std::ostringstream name;
    if (band > 0)
      name << band_ends[band - 1];
    if (band + 1 == band_count)
      name << " m and more";
    else
      name << (band > 0 ? " to " : "up to ") << band_ends[band] << " m";
    rows.front().push_back(name.str());
  }
  for (const Method& method : methods) {
    const float threshold = method.voxels.thresholdThatKeeps(wanted_surfaces);
    rows.push_back({method.name});
    for (std::size_t band = 0; band < band_count; ++band) {
      const Decision decision = method.voxels.at(threshold, band);
      rows.back().push_back(formatted(method.voxels.averagePrecision(band)) + "; " +
                            percent(decision.kept[0]) + "; " +
                            percent(decision.surface_kept));
    }
  }
  output << "Average precision; % of the noise that is let through and % of the "
            "surfaces' voxels that are kept at the threshold for 95 % of all surfaces:"
            "\n\n";
  printTable(rows, output);
}

} // namespace noise
} // namespace pcl_ext
