#include "merged_stream.h"

#include <algorithm>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief A surface that never moves decides before the person, and noise last. */
int
rank(VoxelTruth truth)
{
  switch (truth) {
  case VoxelTruth::Still:
    return 3;
  case VoxelTruth::Person:
    return 2;
  case VoxelTruth::Machine:
  case VoxelTruth::Pole:
    return 1;
  case VoxelTruth::Noise:
    break;
  }
  return 0;
}

} // namespace

void
mergeFrames(const std::vector<LabelledFrame>& frames, LabelledFrame& merged)
{
  std::vector<std::uint64_t> keys;
  for (const LabelledFrame& frame : frames) {
    const auto& more = frame.of(Law::Count).keys;
    keys.insert(keys.end(), more.begin(), more.end());
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  merged.truth.assign(keys.size(), VoxelTruth::Noise);
  merged.depth.assign(keys.size(), 0.0f);
  for (const Law law : camera_laws) {
    io::VoxelFrame& voxels = merged.of(law);
    voxels = io::VoxelFrame();
    voxels.grid = frames.front().of(law).grid;
    voxels.intensity_scale.bits = 16;
    voxels.keys = keys;
    voxels.intensities.assign(keys.size(), 0);
  }
  for (const LabelledFrame& frame : frames) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < frame.truth.size(); ++i) {
      while (keys[at] != frame.of(Law::Count).keys[i])
        ++at;
      for (const Law law : camera_laws)
        merged.of(law).intensities[at] = static_cast<std::uint16_t>(
            merged.of(law).intensities[at] + frame.of(law).intensities[i]);
      if (rank(frame.truth[i]) > rank(merged.truth[at]))
        merged.truth[at] = frame.truth[i];
    }
  }
}

MergedStream::MergedStream(std::uint32_t seed, double resolution)
: frames_(cell::RobotCell::sensor_count)
{
  for (unsigned int sensor = 1; sensor <= cell::RobotCell::sensor_count; ++sensor)
    streams_.push_back(std::make_unique<LabelledStream>(seed, sensor, resolution));
}

void
MergedStream::read(std::uint32_t number, LabelledFrame& merged)
{
  // All sensors have the grid of the crop box.
  for (std::size_t i = 0; i < streams_.size(); ++i)
    streams_[i]->read(number, frames_[i]);
  mergeFrames(frames_, merged);
}

} // namespace noise
} // namespace pcl_ext
