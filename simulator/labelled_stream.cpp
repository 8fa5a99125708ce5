// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/labelled_stream.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

void
markTruth(const io::VoxelFrame& some, VoxelTruth truth, LabelledFrame& frame)
{
  const std::vector<std::uint64_t>& keys = frame.of(Law::Count).keys;
  for (const std::uint64_t key : some.keys) {
    const auto found = std::lower_bound(keys.begin(), keys.end(), key);
    if (found == keys.end() || *found != key)
      throw std::logic_error("a surface's voxel is not among the frame's");
    frame.truth[static_cast<std::size_t>(found - keys.begin())] = truth;
  }
}

Eigen::Vector3d
centreOf(const io::VoxelGrid& grid, std::uint64_t key)
{
  const io::VoxelPosition position = io::voxelPosition(key);
  return {grid.centre(0, position.x),
          grid.centre(1, position.y),
          grid.centre(2, position.z)};
}

LabelledStream::LabelledStream(std::uint32_t seed,
                               unsigned int sensor,
                               double resolution)
: sensor_(sensor)
, cell_(seed)
, count_(Model<CountLaw>(resolution), cell_.sensorPose(sensor))
, quadratic_(Model<QuadraticLaw>(resolution), cell_.sensorPose(sensor))
, linear_(Model<LinearLaw>(resolution), cell_.sensorPose(sensor))
{}

const io::VoxelFrame&
LabelledStream::surfaceVoxelsOf(cell::Mover mover)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  surfaces_ = captured_.cloud;
  for (std::size_t pixel = 0; pixel < surfaces_.size(); ++pixel)
    if (captured_.truth[pixel] != cell::PointTruth::Surface || movers_[pixel] != mover)
      surfaces_[pixel].x = nan;
  count_.voxelize(surfaces_, surface_voxels_);
  return surface_voxels_;
}

void
LabelledStream::read(std::uint32_t number, LabelledFrame& frame)
{
  cell_.capture(sensor_, number, captured_);
  cell_.movers(movers_);
  count_.setPose(captured_.pose);
  quadratic_.setPose(captured_.pose);
  linear_.setPose(captured_.pose);
  count_.voxelize(captured_.cloud, frame.of(Law::Count));
  quadratic_.voxelize(captured_.cloud, frame.of(Law::Quadratic));
  linear_.voxelize(captured_.cloud, frame.of(Law::Linear));

  const io::VoxelFrame& voxels = frame.of(Law::Count);
  frame.truth.assign(voxels.size(), VoxelTruth::Noise);
  // The later ones replace the earlier ones.
  for (const auto& [mover, truth] :
       {std::pair(cell::Mover::Machine, VoxelTruth::Machine),
        std::pair(cell::Mover::Person, VoxelTruth::Person),
        std::pair(cell::Mover::None, VoxelTruth::Still)})
    markTruth(surfaceVoxelsOf(mover), truth, frame);
}

} // namespace noise
} // namespace pcl_ext
