// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "scores.h"

#include "measuring/markdown_table.h"
#include "measuring/results.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

using measuring::formatted;
using measuring::timeOf;

constexpr double wanted_surfaces = 0.95;
constexpr std::size_t curve_steps = 50;

} // namespace

std::vector<MethodRun>
runsOf(std::vector<Method> methods)
{
  std::vector<MethodRun> runs;
  for (Method& method : methods)
    runs.push_back({std::move(method), {}, {}, {}});
  return runs;
}

void
score(const LabelledFrame& frame, MethodRun& run)
{
  std::vector<float> scores;
  run.ms.add(timeOf([&] { run.method.score_voxels(frame, scores); }));
  run.voxels.add(frame.truth, scores);
}

void
score(const LabelledScan& scan, MethodRun& run)
{
  std::vector<float> of_points(scan.returns->size());
  std::vector<float> of_voxels;
  if (!run.method.score_points) {
    run.ms.add(timeOf([&] { run.method.score_voxels(scan.voxels, of_voxels); }));
    for (std::size_t i = 0; i < of_points.size(); ++i)
      of_points[i] = of_voxels[scan.voxel_of_return[i]];
  }
  else {
    run.ms.add(timeOf([&] { run.method.score_points(scan, of_points); }));
    of_voxels.assign(scan.voxels.truth.size(), -std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < of_points.size(); ++i) {
      float& highest = of_voxels[scan.voxel_of_return[i]];
      highest = std::max(highest, of_points[i]);
    }
  }
  run.points.add(scan.truth, of_points);
  run.voxels.add(scan.voxels.truth, of_voxels);
}

void
addJudgement(measuring::Subject subject,
             const Method& method,
             ScoredVoxels scored,
             std::size_t frames,
             measuring::Results& results)
{
  const JudgedVoxels judged(std::move(scored));
  const std::string experiment = subject.experiment;
  subject.coder = method.name;
  const auto add = [&](const std::string& quantity, double value) {
    results.add(subject, quantity, value, frames);
  };
  const auto addDecision = [&](const std::string& prefix, float threshold) {
    const Decision decision = judged.at(threshold);
    add(prefix + "threshold", static_cast<double>(threshold));
    add(prefix + "precision", decision.precision);
    add(prefix + "recall", decision.recall);
    add(prefix + "f1", decision.f1);
    add(prefix + "surface_kept_percent", 100.0 * decision.surface_kept);
    const char* const names[] = {
        "let_through", "still_kept", "machine_kept", "person_kept"};
    for (std::size_t i = 0; i < std::size(names); ++i)
      add(prefix + names[i] + "_percent", 100.0 * decision.kept[i]);
    add(prefix + "person_worst_percent", 100.0 * decision.person_worst);
  };
  add("noise_percent", 100.0 * judged.noiseShare());
  add("average_precision", judged.averagePrecision());
  addDecision("best_", judged.bestThreshold());
  addDecision("usual_", judged.thresholdThatKeeps(wanted_surfaces));
  for (const float threshold : method.thresholds) {
    subject.experiment =
        experiment + "_threshold:" + formatted(static_cast<double>(threshold), 1);
    addDecision("", threshold);
  }
  subject.experiment = experiment + "_curve";
  const std::vector<double> precisions = judged.precisionsOverRecall(curve_steps);
  for (std::size_t i = 0; i < precisions.size(); ++i)
    add("precision at recall " + formatted(static_cast<double>(i + 1) / curve_steps, 2),
        precisions[i]);
}

} // namespace noise
} // namespace pcl_ext
