// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/denoising.h"

namespace pcl_ext::tools {

namespace {

/** \brief Thresholds of the paper's Figure 11. Native intensities and fine voxels,
 * which are faint everywhere, have none. */
float
defaultThreshold(IntensityLaw law, double resolution)
{
  if (law == IntensityLaw::Native || law == IntensityLaw::None ||
      resolution < VoxelOutlierRemoval::min_judged_edge)
    return 0.0f;
  return needsSensor(law) ? 64.0f : 2.0f;
}

} // namespace

CellTruth::CellTruth(std::uint32_t seed, unsigned int sensor, double resolution)
: stream_(seed, sensor, resolution)
{}

const std::vector<noise::VoxelTruth>*
CellTruth::of(std::size_t number, const io::VoxelFrame& frame)
{
  stream_.read(static_cast<std::uint32_t>(number), labelled_);
  return labelled_.of(noise::Law::Count).keys == frame.keys ? &labelled_.truth
                                                            : nullptr;
}

Denoising::Denoising(IntensityLaw law,
                     double resolution,
                     const std::optional<float>& threshold)
: removal_({densityUnitSettings(densityUnitOf(law))})
, uses_filter_(!threshold && VoxelOutlierRemoval::isMadeFor(resolution))
, least_(uses_filter_ ? VoxelOutlierRemovalSettings().min_log_odds
                      : threshold.value_or(defaultThreshold(law, resolution)))
{}

const std::vector<int>&
Denoising::voxelsToKeep(const io::VoxelFrame& frame,
                        const std::vector<float>& intensities,
                        const std::vector<noise::VoxelTruth>* truth)
{
  if (uses_filter_)
    removal_.score(frame, log_odds_);
  const std::vector<float>& scores = uses_filter_ ? log_odds_ : intensities;
  kept_.clear();
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const bool is_kept = scores[i] >= least_;
    if (is_kept)
      kept_.push_back(static_cast<int>(i));
    if (!truth)
      continue;
    const bool is_noise = (*truth)[i] == noise::VoxelTruth::Noise;
    ++(is_noise ? report_.noise : report_.surfaces);
    if (!is_kept)
      ++(is_noise ? report_.noise_removed : report_.surfaces_removed);
  }
  return kept_;
}

} // namespace pcl_ext::tools
