#include "outliers/region_filters.h"

#include "voxels/keep_voxels.h"

#include <algorithm>
#include <limits>
#include <string>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

namespace {

constexpr float not_judged = std::numeric_limits<float>::infinity();

/** \brief Number of keys that are not among others; both ascend. */
std::size_t
countMissing(const std::vector<std::uint64_t>& keys,
             const std::vector<std::uint64_t>& others)
{
  return static_cast<std::size_t>(
      std::count_if(keys.begin(), keys.end(), [&others](std::uint64_t key) {
        return !std::binary_search(others.begin(), others.end(), key);
      }));
}

} // namespace

OutlierRemovalStatus
RegionOutlierRemoval::score(const io::VoxelFrame& frame, std::vector<float>& log_odds)
{
  constexpr unsigned int quadratic = 2;
  const unsigned int of_faces = settings_.unit == DensityUnit::Faces ? quadratic : 0;
  frames_.assign(frame, frame.depth_model ? frame.depth_model->exponent : of_faces);
  const std::size_t count = frames_.frames().size();
  while (removals_.size() < count)
    removals_.emplace_back(settings_);
  log_odds_.resize(count);
  OutlierRemovalStatus status;
  for (std::size_t levels = 0; levels < count; ++levels) {
    const io::VoxelFrame& of_levels = frames_.frames()[levels];
    log_odds_[levels].assign(of_levels.size(), not_judged);
    if (of_levels.keys.empty() ||
        of_levels.grid.resolution > VoxelOutlierRemoval::max_resolution * (1.0 + 1e-6))
      continue;
    if (status = removals_[levels].score(of_levels, log_odds_[levels]); !status.ok()) {
      log_odds.assign(frame.size(), not_judged);
      return status;
    }
  }
  log_odds.resize(frame.size());
  std::size_t unjudged = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    log_odds[i] = log_odds_[frames_.levelsOf(i)][frames_.indexOf(i)];
    unjudged += log_odds[i] == not_judged ? 1 : 0;
  }
  if (unjudged > 0)
    return {OutlierRemovalCode::Ok,
            std::to_string(unjudged) + " of " + std::to_string(frame.size()) +
                " voxels were not judged: they are coarser than 0.2 m"};
  return status;
}

OutlierRemovalStatus
RegionOutlierRemoval::filter(io::VoxelFrame& frame)
{
  OutlierRemovalStatus status = score(frame, own_log_odds_);
  if (status.ok())
    status.removed = io::keepVoxels(frame, [this](std::size_t i) {
      return !(own_log_odds_[i] < settings_.min_log_odds);
    });
  return status;
}

void
RegionOutlierRemoval::setSensorPosition(const std::array<double, 3>& position)
{
  settings_.sensor_position = position;
  for (VoxelOutlierRemoval& removal : removals_)
    removal.setSensorPosition(position);
}

std::size_t
RegionOutlierRemoval::rememberedBlocks() const
{
  std::size_t blocks = 0;
  for (const VoxelOutlierRemoval& removal : removals_)
    blocks += removal.rememberedBlocks();
  return blocks;
}

DensityUnit
RegionOutlierRemoval::unit() const
{
  for (const VoxelOutlierRemoval& removal : removals_)
    if (removal.unit() != settings_.unit)
      return removal.unit();
  return settings_.unit;
}

TemporalFilterStatus
RegionTemporalFilter::filter(io::VoxelFrame& frame,
                             const SensorView& view,
                             const DirectionDepths* rays)
{
  frames_.assign(frame, frame.depth_model ? frame.depth_model->exponent : 0);
  std::vector<io::VoxelFrame>& frames = frames_.frames();
  while (filters_.size() < frames.size())
    filters_.emplace_back(frame_count_, holds_);
  TemporalFilterStatus status;
  io::SensorMotion motion = io::SensorMotion::Unknown;
  for (std::size_t levels = 0; levels < frames.size(); ++levels) {
    if (status = filters_[levels].filter(frames[levels], view, rays); !status.ok())
      return status;
    motion = std::max(motion, status.sensor_motion);
  }
  const std::vector<std::uint64_t> before = frame.keys;
  frames_.unite(frame);
  status.hidden = countMissing(before, frame.keys);
  status.held = countMissing(frame.keys, before);
  status.sensor_motion = motion;
  return status;
}

std::size_t
RegionTemporalFilter::rememberedVoxels() const
{
  std::size_t voxels = 0;
  for (const TemporalVoxelFilter& filter : filters_)
    voxels += filter.rememberedVoxels();
  return voxels;
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
