#include "methods.h"

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <markdown_table.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <sstream>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using benchmarks::formatted;
using benchmarks::MarkdownTable;

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
percent(double number)
{
  return std::isnan(number) ? "-" : formatted(100.0 * number, 1);
}

/** \brief Three digits, or a dash for one of no voxels. */
std::string
share(double number)
{
  return std::isnan(number) ? "-" : formatted(number, 3);
}

} // namespace

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
  MarkdownTable table({"score",
                       "average precision",
                       "best threshold",
                       "precision",
                       "recall",
                       "F1",
                       "threshold for 95 % of surfaces",
                       "noise let through %",
                       "kept: still %",
                       "machines %",
                       "person %"});
  for (Method& method : methods) {
    method.voxels.sort();
    const Decision best = method.voxels.at(method.voxels.bestThreshold());
    const Decision usual =
        method.voxels.at(method.voxels.thresholdThatKeeps(wanted_surfaces));
    table.addRow({method.name,
                  share(method.voxels.averagePrecision()),
                  formatted(static_cast<double>(best.threshold), 2),
                  share(best.precision),
                  share(best.recall),
                  share(best.f1),
                  formatted(static_cast<double>(usual.threshold), 2),
                  percent(usual.kept[0]),
                  percent(usual.kept[1]),
                  percent(usual.kept[2]),
                  percent(usual.kept[3])});
  }
  output << "Noise: " << percent(methods.front().voxels.noiseShare())
         << " % of the voxels.\n\n";
  table.print(output);
}

void
printThresholds(const std::vector<Method>& methods, std::ostream& output)
{
  MarkdownTable table({"score",
                       "threshold",
                       "precision",
                       "recall",
                       "F1",
                       "noise let through %",
                       "kept: surfaces %",
                       "still %",
                       "machines %",
                       "person %"});
  for (const Method& method : methods)
    for (const float threshold : method.thresholds) {
      const Decision decision = method.voxels.at(threshold);
      table.addRow({method.name,
                    formatted(static_cast<double>(threshold), 1),
                    share(decision.precision),
                    share(decision.recall),
                    share(decision.f1),
                    percent(decision.kept[0]),
                    percent(decision.surface_kept),
                    percent(decision.kept[1]),
                    percent(decision.kept[2]),
                    percent(decision.kept[3])});
    }
  table.print(output);
}

void
printBands(const std::vector<Method>& methods, std::ostream& output)
{
  MarkdownTable::Row header = {"score"};
  for (std::size_t band = 0; band < band_count; ++band) {
    std::ostringstream name;
    if (band > 0)
      name << band_ends[band - 1];
    if (band + 1 == band_count)
      name << " m and more";
    else
      name << (band > 0 ? " to " : "up to ") << band_ends[band] << " m";
    header.push_back(name.str());
  }
  MarkdownTable table(header);
  for (const Method& method : methods) {
    const float threshold = method.voxels.thresholdThatKeeps(wanted_surfaces);
    MarkdownTable::Row row = {method.name};
    for (std::size_t band = 0; band < band_count; ++band) {
      const Decision decision = method.voxels.at(threshold, band);
      row.push_back(share(method.voxels.averagePrecision(band)) + "; " +
                    percent(decision.kept[0]) + "; " + percent(decision.surface_kept));
    }
    table.addRow(std::move(row));
  }
  output << "Average precision; % of the noise that is let through and % of the "
            "surfaces' voxels that are kept at the threshold for 95 % of all surfaces:"
            "\n\n";
  table.print(output);
}

} // namespace noise
} // namespace pcl_ext
