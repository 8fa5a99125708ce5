#include "judged_voxels.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace pcl_ext {
namespace noise {

std::uint8_t
ScoredVoxels::bandOf(float depth) const
{
  std::uint8_t band = 0;
  while (band + 1u < band_ends_.size() && depth >= band_ends_[band])
    ++band;
  return band;
}

void
ScoredVoxels::add(const LabelledFrame& frame, const std::vector<float>& scores)
{
  add(frame.truth, frame.depth, scores);
}

void
ScoredVoxels::add(const std::vector<VoxelTruth>& truth,
                  const std::vector<float>& depth,
                  const std::vector<float>& scores)
{
  std::vector<float> of_person;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    voxels_.push_back({scores[i], truth[i], bandOf(depth[i])});
    if (truth[i] == VoxelTruth::Person)
      of_person.push_back(scores[i]);
  }
  if (of_person.size() >= least_person_voxels)
    person_scores_.push_back(std::move(of_person));
}

JudgedVoxels::JudgedVoxels(ScoredVoxels voxels)
: band_ends_(std::move(voxels.band_ends_))
, voxels_(std::move(voxels.voxels_))
, person_scores_(std::move(voxels.person_scores_))
{
  std::sort(voxels_.begin(), voxels_.end(), [](const Voxel& a, const Voxel& b) {
    return a.score < b.score;
  });
}

template <typename WantedT>
VoxelNumbers
JudgedVoxels::numbersOf(const WantedT& wanted) const
{
  VoxelNumbers numbers;
  for (const Voxel& voxel : voxels_)
    if (wanted(voxel))
      ++(voxel.truth == VoxelTruth::Noise ? numbers.noise : numbers.surface);
  return numbers;
}

VoxelNumbers
JudgedVoxels::numbers() const
{
  return numbersOf([](const Voxel&) { return true; });
}

VoxelNumbers
JudgedVoxels::numbers(std::size_t band) const
{
  return numbersOf([&](const Voxel& voxel) { return voxel.band == band; });
}

template <typename WantedT>
double
JudgedVoxels::averagePrecisionOf(const WantedT& wanted) const
{
  double noise = 0.0;
  double removed = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < voxels_.size();) {
    double more_noise = 0.0;
    const float score = voxels_[i].score;
    for (; i < voxels_.size() && voxels_[i].score == score; ++i)
      if (wanted(voxels_[i])) {
        more_noise += voxels_[i].truth == VoxelTruth::Noise ? 1.0 : 0.0;
        removed += 1.0;
      }
    noise += more_noise;
    if (removed > 0.0)
      sum += more_noise * noise / removed;
  }
  return sum / noise;
}

double
JudgedVoxels::averagePrecision() const
{
  return averagePrecisionOf([](const Voxel&) { return true; });
}

double
JudgedVoxels::averagePrecision(std::size_t band) const
{
  return averagePrecisionOf([&](const Voxel& voxel) { return voxel.band == band; });
}

template <typename WantedT>
Decision
JudgedVoxels::decisionOf(float threshold, const WantedT& wanted) const
{
  std::array<double, voxel_truth_count> all{};
  std::array<double, voxel_truth_count> kept{};
  for (const Voxel& voxel : voxels_)
    if (wanted(voxel)) {
      all[static_cast<std::size_t>(voxel.truth)] += 1.0;
      kept[static_cast<std::size_t>(voxel.truth)] +=
          voxel.score < threshold ? 0.0 : 1.0;
    }
  Decision decision;
  decision.threshold = threshold;
  const double noise_removed = all[0] - kept[0];
  const double surfaces = std::accumulate(all.begin() + 1, all.end(), 0.0);
  const double surfaces_kept = std::accumulate(kept.begin() + 1, kept.end(), 0.0);
  decision.precision = noise_removed / (noise_removed + surfaces - surfaces_kept);
  decision.recall = noise_removed / all[0];
  decision.f1 =
      2.0 * noise_removed / (noise_removed + surfaces - surfaces_kept + all[0]);
  decision.surface_kept = surfaces_kept / surfaces;
  for (std::size_t i = 0; i < voxel_truth_count; ++i)
    decision.kept[i] = kept[i] / all[i];
  return decision;
}

Decision
JudgedVoxels::at(float threshold) const
{
  return decisionOf(threshold, [](const Voxel&) { return true; });
}

Decision
JudgedVoxels::at(float threshold, std::size_t band) const
{
  return decisionOf(threshold, [&](const Voxel& voxel) { return voxel.band == band; });
}

float
JudgedVoxels::thresholdThatKeeps(double surface_share) const
{
  const double may_go = (1.0 - surface_share) * static_cast<double>(numbers().surface);
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
  const auto all_noise = static_cast<double>(numbers().noise);
  double noise = 0.0;
  double removed = 0.0;
  double best = 0.0;
  float threshold = 0.0f;
  for (std::size_t i = 0; i < voxels_.size();) {
    const float score = voxels_[i].score;
    for (; i < voxels_.size() && voxels_[i].score == score; ++i) {
      noise += voxels_[i].truth == VoxelTruth::Noise ? 1.0 : 0.0;
      removed += 1.0;
    }
    const double f1 = 2.0 * noise / (removed + all_noise);
    if (f1 > best) {
      best = f1;
      threshold = i < voxels_.size() ? voxels_[i].score
                                     : std::numeric_limits<float>::infinity();
    }
  }
  return threshold;
}

PersonKept
JudgedVoxels::personKept(float threshold) const
{
  PersonKept kept;
  kept.frames = person_scores_.size();
  kept.worst_share = kept.frames > 0 ? 1.0 : std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<float>& scores : person_scores_) {
    const auto removed = std::count_if(
        scores.begin(), scores.end(), [&](float score) { return score < threshold; });
    const double share =
        1.0 - static_cast<double>(removed) / static_cast<double>(scores.size());
    kept.poor_frames += share < 0.8 ? 1 : 0;
    kept.worst_share = std::min(kept.worst_share, share);
  }
  return kept;
}

std::vector<double>
JudgedVoxels::precisionsOverRecall(std::size_t steps) const
{
  const std::size_t all_noise = numbers().noise;
  std::vector<double> precisions;
  std::size_t noise = 0;
  for (std::size_t i = 0; i < voxels_.size();) {
    const float score = voxels_[i].score;
    for (; i < voxels_.size() && voxels_[i].score == score; ++i)
      noise += voxels_[i].truth == VoxelTruth::Noise ? 1 : 0;
    while (precisions.size() < steps &&
           noise * steps >= (precisions.size() + 1) * all_noise)
      precisions.push_back(static_cast<double>(noise) / static_cast<double>(i));
  }
  if (all_noise == 0)
    precisions.clear();
  return precisions;
}

double
JudgedVoxels::noiseShare() const
{
  return static_cast<double>(numbers().noise) / static_cast<double>(voxels_.size());
}

} // namespace noise
} // namespace pcl_ext
