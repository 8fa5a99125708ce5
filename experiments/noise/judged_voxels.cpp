// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "judged_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

void
ScoredVoxels::add(const std::vector<VoxelTruth>& truth,
                  const std::vector<float>& scores)
{
  std::vector<float> of_person;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (std::isnan(scores[i]))
      throw std::invalid_argument("a score is NaN");
    voxels_.push_back({scores[i], truth.at(i)});
    if (truth[i] == VoxelTruth::Person)
      of_person.push_back(scores[i]);
  }
  if (of_person.size() >= least_person_voxels)
    person_scores_.push_back(std::move(of_person));
}

JudgedVoxels::JudgedVoxels(ScoredVoxels voxels)
: voxels_(std::move(voxels.voxels_)), person_scores_(std::move(voxels.person_scores_))
{
  std::sort(voxels_.begin(), voxels_.end(), [](const Voxel& a, const Voxel& b) {
    return a.score < b.score;
  });
  for (const Voxel& voxel : voxels_)
    noise_ += voxel.truth == VoxelTruth::Noise ? 1 : 0;
}

std::vector<JudgedVoxels::Step>
JudgedVoxels::steps() const
{
  std::vector<Step> steps;
  Step step;
  for (std::size_t i = 0; i < voxels_.size();) {
    const float score = voxels_[i].score;
    step.more_noise = 0.0;
    for (; i < voxels_.size() && voxels_[i].score == score; ++i)
      step.more_noise += voxels_[i].truth == VoxelTruth::Noise ? 1.0 : 0.0;
    step.noise += step.more_noise;
    step.removed = static_cast<double>(i);
    step.threshold =
        i < voxels_.size() ? voxels_[i].score : std::numeric_limits<float>::infinity();
    steps.push_back(step);
  }
  return steps;
}

double
JudgedVoxels::averagePrecision() const
{
  double sum = 0.0;
  for (const Step& step : steps())
    sum += step.more_noise * step.noise / step.removed;
  return sum / static_cast<double>(noise_);
}

Decision
JudgedVoxels::at(float threshold) const
{
  std::array<double, voxel_truth_count> all{};
  std::array<double, voxel_truth_count> kept{};
  for (const Voxel& voxel : voxels_) {
    all[static_cast<std::size_t>(voxel.truth)] += 1.0;
    kept[static_cast<std::size_t>(voxel.truth)] += voxel.score < threshold ? 0.0 : 1.0;
  }
  Decision decision;
  decision.threshold = threshold;
  const double noise_removed = all[0] - kept[0];
  const double surfaces = std::accumulate(all.begin() + 1, all.end(), 0.0);
  const double surfaces_kept = std::accumulate(kept.begin() + 1, kept.end(), 0.0);
  const double removed = noise_removed + surfaces - surfaces_kept;
  decision.precision = noise_removed / removed;
  decision.recall = noise_removed / all[0];
  decision.f1 = 2.0 * noise_removed / (removed + all[0]);
  decision.surface_kept = surfaces_kept / surfaces;
  for (std::size_t i = 0; i < voxel_truth_count; ++i)
    decision.kept[i] = kept[i] / all[i];
  decision.person_worst =
      person_scores_.empty() ? std::numeric_limits<double>::quiet_NaN() : 1.0;
  for (const std::vector<float>& scores : person_scores_) {
    const auto stays = std::count_if(
        scores.begin(), scores.end(), [&](float score) { return score >= threshold; });
    decision.person_worst =
        std::min(decision.person_worst,
                 static_cast<double>(stays) / static_cast<double>(scores.size()));
  }
  return decision;
}

float
JudgedVoxels::thresholdThatKeeps(double surface_share) const
{
  const double may_go =
      (1.0 - surface_share) * static_cast<double>(voxels_.size() - noise_);
  std::size_t gone = 0;
  for (const Voxel& voxel : voxels_) {
    gone += voxel.truth == VoxelTruth::Noise ? 0 : 1;
    if (static_cast<double>(gone) > may_go)
      return voxel.score;
  }
  return std::numeric_limits<float>::infinity();
}

float
JudgedVoxels::bestThreshold() const
{
  double best = 0.0;
  float threshold = 0.0f;
  for (const Step& step : steps()) {
    const double f1 = 2.0 * step.noise / (step.removed + static_cast<double>(noise_));
    if (f1 > best) {
      best = f1;
      threshold = step.threshold;
    }
  }
  return threshold;
}

std::vector<double>
JudgedVoxels::precisionsOverRecall(std::size_t count) const
{
  std::vector<double> precisions;
  if (noise_ == 0)
    return precisions;
  for (const Step& step : steps())
    while (precisions.size() < count &&
           step.noise * static_cast<double>(count) >=
               static_cast<double>((precisions.size() + 1) * noise_))
      precisions.push_back(step.noise / step.removed);
  return precisions;
}

double
JudgedVoxels::noiseShare() const
{
  return static_cast<double>(noise_) / static_cast<double>(voxels_.size());
}

} // namespace noise
} // namespace pcl_ext
