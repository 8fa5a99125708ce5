#include "streams/denoising.h"

#include "measuring/samples.h"

namespace pcl_ext {
namespace tools {

namespace {

/** \brief Thresholds of the paper's Figure 11, to compare the filter with. Native
 * intensities and fine voxels, which are faint everywhere, have none. */
float
defaultThreshold(IntensityLaw law, double resolution)
{
  if (law == IntensityLaw::Native || law == IntensityLaw::None ||
      resolution < VoxelOutlierRemoval::min_judged_edge)
    return 0.0f;
  return needsSensor(law) ? 64.0f : 2.0f;
}

VoxelOutlierRemovalSettings
removalSettings(IntensityLaw law)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = densityUnitOf(law);
  return settings;
}

void
countRemoved(const std::vector<float>& scores,
             float least,
             const std::vector<noise::VoxelTruth>* truth,
             RemovedVoxels& removed)
{
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (scores[i] >= least)
      continue;
    ++removed.all;
    if (truth)
      ++((*truth)[i] == noise::VoxelTruth::Noise ? removed.noise : removed.surfaces);
  }
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
: settings_(removalSettings(law)), removal_(settings_)
{
  report_.has_filter = VoxelOutlierRemoval::isMadeFor(resolution);
  report_.threshold = threshold.value_or(defaultThreshold(law, resolution));
  report_.uses_filter = report_.has_filter && !threshold;
}

const std::vector<int>&
Denoising::voxelsToKeep(const io::VoxelFrame& frame,
                        const std::vector<float>& intensities,
                        const std::vector<noise::VoxelTruth>* truth)
{
  if (report_.has_filter) {
    const double ms = measuring::timeOf([&] { removal_.score(frame, log_odds_); });
    report_.ms += report_.uses_filter ? ms : 0.0;
    countRemoved(log_odds_, settings_.min_log_odds, truth, report_.by_filter);
  }
  countRemoved(intensities, report_.threshold, truth, report_.by_threshold);
  if (truth) {
    report_.labelled_voxels += truth->size();
    for (const noise::VoxelTruth voxel : *truth)
      report_.noise_voxels += voxel == noise::VoxelTruth::Noise ? 1 : 0;
  }
  report_.ms += measuring::timeOf([&] {
    const std::vector<float>& scores = report_.uses_filter ? log_odds_ : intensities;
    const float least =
        report_.uses_filter ? settings_.min_log_odds : report_.threshold;
    kept_.clear();
    for (std::size_t i = 0; i < scores.size(); ++i)
      if (scores[i] >= least)
        kept_.push_back(static_cast<int>(i));
  });
  return kept_;
}

} // namespace tools
} // namespace pcl_ext
