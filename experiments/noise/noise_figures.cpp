#include "noise_figures.h"

#include "measuring/markdown_table.h"

#include <result_file.h>

#include <cmath>
#include <ostream>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using measuring::formatted;
using measuring::MarkdownTable;

constexpr double wanted_surfaces = 0.95;

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

std::string
thresholdName(float threshold)
{
  return formatted(static_cast<double>(threshold), 1);
}

DecisionFigures
decisionAt(const JudgedVoxels& voxels, float threshold)
{
  return {voxels.at(threshold), voxels.personKept(threshold)};
}

MethodFigures
figuresOf(const std::string& name,
          const std::vector<float>& thresholds,
          const JudgedVoxels& voxels)
{
  MethodFigures figures;
  figures.method = name;
  figures.noise_share = voxels.noiseShare();
  figures.average_precision = voxels.averagePrecision();
  figures.best = decisionAt(voxels, voxels.bestThreshold());
  figures.usual = decisionAt(voxels, voxels.thresholdThatKeeps(wanted_surfaces));
  for (const float threshold : thresholds)
    figures.thresholds.push_back(decisionAt(voxels, threshold));
  for (std::size_t band = 0; band < band_count; ++band)
    figures.bands[band] = {voxels.numbers(band),
                           voxels.averagePrecision(band),
                           voxels.at(figures.usual.decision.threshold, band)};
  figures.precisions = voxels.precisionsOverRecall(curve_steps);
  return figures;
}

void
printFigures(const std::vector<MethodFigures>& figures, std::ostream& output)
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
                       "person %",
                       "worst frame %"});
  for (const MethodFigures& figure : figures) {
    const Decision& best = figure.best.decision;
    const Decision& usual = figure.usual.decision;
    table.addRow({figure.method,
                  share(figure.average_precision),
                  formatted(static_cast<double>(best.threshold), 2),
                  share(best.precision),
                  share(best.recall),
                  share(best.f1),
                  formatted(static_cast<double>(usual.threshold), 2),
                  percent(usual.kept[0]),
                  percent(usual.kept[1]),
                  percent(usual.kept[2]),
                  percent(usual.kept[3]),
                  percent(figure.usual.person.worst_share)});
  }
  output << "Noise: " << percent(figures.front().noise_share)
         << " % of the voxels.\n\n";
  table.print(output);
}

/** \brief A table of what each method has in each band; dashes where a band has no noise
 * or no surface. */
template <typename CellT>
void
printBands(const std::string& caption,
           const std::vector<MethodFigures>& figures,
           const CellT& cell,
           std::ostream& output)
{
  MarkdownTable::Row header = {"score"};
  for (std::size_t band = 0; band < band_count; ++band)
    header.push_back(nameOfBand(band));
  MarkdownTable table(header);
  for (const MethodFigures& figure : figures) {
    MarkdownTable::Row row = {figure.method};
    for (const BandFigures& band : figure.bands)
      row.push_back(band.numbers.noise == 0 || band.numbers.surface == 0 ? "-"
                                                                         : cell(band));
    table.addRow(std::move(row));
  }
  output << caption << "\n\n";
  table.print(output);
}

void
printThresholds(const std::vector<MethodFigures>& figures, std::ostream& output)
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
                       "person %",
                       "worst frame %"});
  for (const MethodFigures& figure : figures)
    for (const DecisionFigures& at : figure.thresholds) {
      const Decision& decision = at.decision;
      table.addRow({figure.method,
                    thresholdName(decision.threshold),
                    share(decision.precision),
                    share(decision.recall),
                    share(decision.f1),
                    percent(decision.kept[0]),
                    percent(decision.surface_kept),
                    percent(decision.kept[1]),
                    percent(decision.kept[2]),
                    percent(decision.kept[3]),
                    percent(at.person.worst_share)});
    }
  table.print(output);
}

/** \brief Adds quantities of one subject, each of all frames together. */
class SubjectResults {
public:
  SubjectResults(report::Subject subject,
                 std::size_t frames,
                 report::ResultFile& results)
  : subject_(std::move(subject)), frames_(frames), results_(results)
  {}

  void
  add(const std::string& quantity, double value)
  {
    if (!std::isnan(value))
      results_.add(subject_, quantity, value, frames_);
  }

  void
  add(const std::string& prefix, const Decision& decision)
  {
    add(prefix + "threshold", static_cast<double>(decision.threshold));
    add(prefix + "precision", decision.precision);
    add(prefix + "recall", decision.recall);
    add(prefix + "f1", decision.f1);
    add(prefix + "let_through_percent", 100.0 * decision.kept[0]);
    add(prefix + "surface_kept_percent", 100.0 * decision.surface_kept);
    add(prefix + "still_kept_percent", 100.0 * decision.kept[1]);
    add(prefix + "machine_kept_percent", 100.0 * decision.kept[2]);
    add(prefix + "person_kept_percent", 100.0 * decision.kept[3]);
  }

  void
  add(const std::string& prefix, const DecisionFigures& figures)
  {
    add(prefix, figures.decision);
    add(prefix + "person_worst_percent", 100.0 * figures.person.worst_share);
    add(prefix + "person_frames", static_cast<double>(figures.person.frames));
    add(prefix + "person_poor_frames", static_cast<double>(figures.person.poor_frames));
  }

private:
  report::Subject subject_;
  std::size_t frames_;
  report::ResultFile& results_;
};

} // namespace

std::vector<MethodFigures>
figuresOf(std::vector<Method> methods)
{
  std::vector<MethodFigures> figures;
  for (Method& method : methods)
    figures.push_back(figuresOf(
        method.name, method.thresholds, JudgedVoxels(std::move(method.voxels))));
  return figures;
}

std::string
nameOfBand(std::size_t band)
{
  const auto metres = [](float end) { return formatted(static_cast<double>(end), 0); };
  if (band == 0)
    return "up to " + metres(band_ends[band]) + " m";
  if (band + 1 == band_count)
    return metres(band_ends[band - 1]) + " m and more";
  return metres(band_ends[band - 1]) + " to " + metres(band_ends[band]) + " m";
}

void
print(const Measured& measured,
      const std::vector<MethodFigures>& figures,
      std::ostream& output)
{
  printFigures(figures, output);
  if (measured.has_depths) {
    printBands(
        "Average precision by depth:",
        figures,
        [](const BandFigures& band) { return share(band.average_precision); },
        output);
    printBands(
        "Noise let through %, at the threshold for 95 % of all surfaces:",
        figures,
        [](const BandFigures& band) { return percent(band.usual.kept[0]); },
        output);
    printBands(
        "Surfaces' voxels kept %, at that threshold:",
        figures,
        [](const BandFigures& band) { return percent(band.usual.surface_kept); },
        output);
  }
  printThresholds(figures, output);
}

void
addResults(const std::string& experiment,
           const Measured& measured,
           const std::vector<MethodFigures>& figures,
           report::ResultFile& results)
{
  const auto frames = static_cast<double>(measured.frames);
  for (const MethodFigures& figure : figures) {
    const auto resultsOf = [&](const std::string& name) {
      return SubjectResults({name, measured.sensor, figure.method, measured.resolution},
                            measured.frames,
                            results);
    };
    SubjectResults all = resultsOf(experiment);
    all.add("noise_percent", 100.0 * figure.noise_share);
    all.add("average_precision", figure.average_precision);
    all.add("best_", figure.best);
    all.add("usual_", figure.usual);
    for (const DecisionFigures& at : figure.thresholds)
      resultsOf(experiment + "_threshold:" + thresholdName(at.decision.threshold))
          .add("", at);
    SubjectResults curve = resultsOf(experiment + "_curve");
    for (std::size_t i = 0; i < figure.precisions.size(); ++i)
      curve.add("precision at recall " +
                    formatted(static_cast<double>(i + 1) / curve_steps, 2),
                figure.precisions[i]);
    if (!measured.has_depths)
      continue;
    for (std::size_t i = 0; i < band_count; ++i) {
      const BandFigures& band = figure.bands[i];
      SubjectResults of_band = resultsOf(experiment + "_band:" + nameOfBand(i));
      of_band.add("noise_voxels", static_cast<double>(band.numbers.noise) / frames);
      of_band.add("surface_voxels", static_cast<double>(band.numbers.surface) / frames);
      of_band.add("average_precision", band.average_precision);
      of_band.add("let_through_percent", 100.0 * band.usual.kept[0]);
      of_band.add("surface_kept_percent", 100.0 * band.usual.surface_kept);
    }
  }
}

} // namespace noise
} // namespace pcl_ext
