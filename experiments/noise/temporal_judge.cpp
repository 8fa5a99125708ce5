#include "temporal_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

constexpr double usual_share = 0.8; ///< of the frames

bool
contains(const std::vector<std::uint64_t>& sorted, std::uint64_t key)
{
  return std::binary_search(sorted.begin(), sorted.end(), key);
}

} // namespace

void
SurfaceHistory::add(const io::VoxelFrame& voxels,
                    const std::vector<VoxelTruth>& truth,
                    TrueView view)
{
  grid_ = voxels.grid;
  surfaces_.clear();
  person_.clear();
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (truth[i] != VoxelTruth::Noise)
      surfaces_.push_back(voxels.keys[i]);
    if (truth[i] == VoxelTruth::Person)
      person_.push_back(voxels.keys[i]);
  }
  new_.emplace_front();
  if (frames_ >= frames_without)
    std::copy_if(surfaces_.begin(),
                 surfaces_.end(),
                 std::back_inserter(new_.front()),
                 [this](std::uint64_t key) { return isNew(key); });
  new_.resize(std::min(new_.size(), frames_later + 1));
  views_.push_front(std::move(view));
  if (views_.size() > ghost_frames)
    views_.pop_back();
  near_.mark(grid_, surfaces_, frames_);
  ++frames_;
}

bool
SurfaceHistory::isNew(std::uint64_t key) const
{
  if (near_.lastTime(key) >= frames_ - frames_without)
    return false;
  std::size_t neighbours = 0;
  forEachNearby(grid_, key, [&](std::uint64_t near) {
    neighbours += near != key && contains(surfaces_, near) ? 1 : 0;
  });
  return neighbours >= least_neighbours;
}

std::vector<std::uint64_t>
SurfaceHistory::earlierNewSurfaces() const
{
  std::vector<std::uint64_t> still_there;
  if (new_.size() > frames_later)
    std::copy_if(
        new_[frames_later].begin(),
        new_[frames_later].end(),
        std::back_inserter(still_there),
        [this](std::uint64_t key) { return near_.lastTime(key) == frames_ - 1; });
  return still_there;
}

bool
SurfaceHistory::isGhost(std::uint64_t key) const
{
  return views_.size() == ghost_frames &&
         std::all_of(views_.begin(), views_.end(), [&](const TrueView& view) {
           return view.seesThrough(grid_, key);
         });
}

void
IntensityErrors::Sums::add(double value)
{
  count += 1.0;
  sum += value;
  squares += value * value;
}

double
IntensityErrors::Sums::squaresAround(double mean) const
{
  return squares - 2.0 * mean * sum + count * mean * mean;
}

void
IntensityErrors::add(const io::VoxelFrame& measured,
                     const io::VoxelFrame& shown,
                     bool is_judged)
{
  ++frames_;
  const auto intensity = [](const io::VoxelFrame& frame, std::size_t i) {
    return static_cast<double>(frame.intensity_scale.value(frame.intensities[i]));
  };
  std::size_t j = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    Voxel& voxel = voxels_[measured.keys[i]];
    const double value = intensity(measured, i);
    voxel.measured.add(value);
    while (j < shown.size() && shown.keys[j] < measured.keys[i])
      ++j;
    if (is_judged && j < shown.size() && shown.keys[j] == measured.keys[i]) {
      voxel.shown.add(intensity(shown, j));
      voxel.measured_where_shown.add(value);
    }
  }
}

double
IntensityErrors::ratio() const
{
  double shown = 0.0;
  double measured = 0.0;
  for (const auto& [key, voxel] : voxels_) {
    if (voxel.measured.count < usual_share * static_cast<double>(frames_))
      continue;
    const double mean = voxel.measured.sum / voxel.measured.count;
    shown += voxel.shown.squaresAround(mean);
    measured += voxel.measured_where_shown.squaresAround(mean);
  }
  return measured > 0.0 ? std::sqrt(shown / measured)
                        : std::numeric_limits<double>::quiet_NaN();
}

CountedVoxels
ShownJudge::nearShown(const std::vector<std::uint64_t>& keys) const
{
  const auto near = std::count_if(
      keys.begin(), keys.end(), [this](std::uint64_t key) { return isNearShown(key); });
  return {static_cast<double>(keys.size()), static_cast<double>(near)};
}

void
ShownJudge::add(const SurfaceHistory& truth,
                const io::VoxelFrame& measured,
                const io::VoxelFrame& shown)
{
  frame_ = truth.frames() - 1;
  near_.mark(shown.grid, shown.keys, frame_);
  intensity.add(measured, shown, frame_ >= first_judged_);
  const auto addTo = [](CountedVoxels& sum, const CountedVoxels& more) {
    sum.all += more.all;
    sum.counted += more.counted;
  };
  addTo(new_surface, nearShown(truth.newSurfaces()));
  addTo(new_surface_later, nearShown(truth.earlierNewSurfaces()));
  if (truth.person().size() >= least_person_voxels)
    person_percent.add(nearShown(truth.person()).percent());
  if (frame_ < first_judged_)
    return;
  if (!truth.surfaces().empty())
    surface_percent.add(nearShown(truth.surfaces()).percent());
  for (const std::uint64_t key : shown.keys) {
    const bool is_ghost = truth.isGhost(key);
    const bool is_left = is_ghost && truth.hasBeenLeft(key);
    addTo(noise, {1.0, truth.isNoise(key) ? 1.0 : 0.0});
    addTo(ghosts, {1.0, is_ghost ? 1.0 : 0.0});
    addTo(left_behind, {1.0, is_left ? 1.0 : 0.0});
  }
}

} // namespace noise
} // namespace pcl_ext
