#include "temporal_samples.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace pcl_ext {
namespace noise {

namespace {

void
requireWritten(const std::ofstream& file)
{
  if (!file)
    throw std::runtime_error("the samples cannot be written");
}

} // namespace

TemporalSamples::TemporalSamples(const std::string& folder, std::int64_t first_judged)
: frame_file_(folder + "/temporal_frame.csv")
, first_judged_(first_judged)
, bytes_(folder + "/temporal_bytes.csv")
{
  requireWritten(bytes_);
}

void
TemporalSamples::add(const SurfaceHistory& truth,
                     const LabelledFrame& frame,
                     const std::vector<FilteredStream>& filtered)
{
  const std::int64_t number = truth.frames() - 1;
  if (number == 0) {
    bytes_ << "frame";
    for (const FilteredStream& one : filtered)
      bytes_ << ',' << one.name;
    bytes_ << '\n';
  }
  bytes_ << number;
  for (const FilteredStream& one : filtered)
    bytes_ << ',' << one.coded.front().lastSize();
  bytes_ << '\n';
  for (const FilteredStream& one : filtered)
    if (one.name == "temporal" && number >= first_judged_)
      keep(truth, frame, one);
}

void
TemporalSamples::keep(const SurfaceHistory& truth,
                      const LabelledFrame& frame,
                      const FilteredStream& filtered)
{
  const double percent = filtered.judge.nearShown(truth.surfaces()).percent();
  if (!(percent < worst_percent_))
    return;
  worst_percent_ = percent;
  worst_frame_ = truth.frames() - 1;
  worst_.clear();
  const io::VoxelFrame& shown = filtered.shown();
  const std::vector<std::uint64_t>& measured = frame.of(Law::Count).keys;
  std::vector<std::uint64_t> keys;
  std::set_union(measured.begin(),
                 measured.end(),
                 shown.keys.begin(),
                 shown.keys.end(),
                 std::back_inserter(keys));
  for (const std::uint64_t key : keys) {
    const auto found = std::lower_bound(measured.begin(), measured.end(), key);
    const bool is_measured = found != measured.end() && *found == key;
    const bool is_noise =
        is_measured &&
        frame.truth[static_cast<std::size_t>(found - measured.begin())] ==
            VoxelTruth::Noise;
    const bool is_shown = std::binary_search(shown.keys.begin(), shown.keys.end(), key);
    worst_.push_back({centreOf(shown.grid, key),
                      is_measured,
                      is_shown,
                      is_noise,
                      is_measured && !is_noise && !filtered.judge.isNearShown(key),
                      is_shown && truth.isGhost(key)});
  }
}

void
TemporalSamples::close()
{
  bytes_.close();
  requireWritten(bytes_);
  std::ofstream file(frame_file_);
  file << "frame,x,y,z,is_measured,is_shown,is_noise,is_missed,is_ghost\n";
  for (const Voxel& voxel : worst_)
    file << worst_frame_ << ',' << voxel.centre.x() << ',' << voxel.centre.y() << ','
         << voxel.centre.z() << ',' << voxel.is_measured << ',' << voxel.is_shown << ','
         << voxel.is_noise << ',' << voxel.is_missed << ',' << voxel.is_ghost << '\n';
  file.close();
  requireWritten(file);
}

} // namespace noise
} // namespace pcl_ext
