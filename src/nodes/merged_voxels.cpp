#include "nodes/merged_voxels.h"

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "bytes/exceptions.h"

#include <cstddef>

namespace pcl_ext {
namespace nodes {

namespace {

io::Voxelizer
mergingVoxelizer(double resolution)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.aggregation = io::Aggregation::Sum;
  return {settings, IntensityUnit::Native};
}

} // namespace

void
MergedVoxels::clear()
{
  coordinates_.clear();
  intensities_.clear();
}

void
MergedVoxels::add(const ReceivedStream& stream, Time oldest, Time newest)
{
  if (stream.latestVoxels(oldest, newest, frame_))
    appendCentres(frame_);
}

void
MergedVoxels::finish(io::VoxelFrame& merged)
{
  // After an exception the voxelizer may contain a part of the points.
  const auto release = [&] {
    releaseMemory();
    merged = io::VoxelFrame();
  };
  callOrCleanUp([&] { voxelize(merged); }, release);
  if (memory_rule_.shouldRelease((coordinates_.size() + intensities_.size()) *
                                 sizeof(float)))
    releaseMemory();
}

void
MergedVoxels::releaseMemory()
{
  voxelizer_.reset();
  frame_ = io::VoxelFrame();
  coordinates_ = std::vector<float>();
  intensities_ = std::vector<float>();
}

void
MergedVoxels::voxelize(io::VoxelFrame& merged)
{
  if (!voxelizer_)
    voxelizer_.emplace(mergingVoxelizer(resolution_));
  io::PointView points;
  points.coordinates = coordinates_.data();
  points.coordinate_stride = 3;
  points.intensities = intensities_.data();
  points.intensity_stride = 1;
  points.count = intensities_.size();
  // Merged frames are independent: each has a grid and a scale of its own.
  constexpr bool may_refit = true;
  voxelizer_->voxelize(points, may_refit, merged);
  merged.depth_model.reset();
}

void
MergedVoxels::appendCentres(const io::VoxelFrame& frame)
{
  const float margin = io::faceMargin(resolution_);
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    coordinates_.insert(coordinates_.end(), {x + margin, y + margin, z + margin});
    intensities_.push_back(frame.hasIntensities() ? intensity : 1.0f);
  });
}

} // namespace nodes
} // namespace pcl_ext
