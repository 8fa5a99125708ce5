// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_voxels.h"

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/impl/colour_mean.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "voxelizing/common_step.h"
#include "voxels/radix_sort.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace nodes {

namespace {

// Lattice indices are -2^20 .. 2^20 - 1.
constexpr std::int32_t lattice_end = std::int32_t{1} << (io::max_grid_depth - 1);

/** \brief A voxelizer of points whose coordinates are voxels from the origin. */
io::Voxelizer
mergingVoxelizer()
{
  io::EncoderSettings settings;
  settings.resolution = 1.0;
  settings.origin.emplace(); // does not move
  settings.aggregation = io::Aggregation::Sum;
  return {settings, IntensityUnit::Native};
}

/** \brief The lower one of the two middle values, which are reordered; 0 of none. */
template <typename ValueT>
ValueT
median(std::vector<ValueT>& values)
{
  if (values.empty())
    return ValueT(0);
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool
isOrigin(const std::array<double, 3>& origin)
{
  io::EncoderSettings settings;
  settings.origin = origin;
  return io::checkSettings(settings).ok();
}

} // namespace

MergedVoxels::MergedVoxels(double resolution, const std::optional<Origin>& origin)
: resolution_(resolution)
, has_fixed_origin_(origin.has_value())
, origin_(origin.value_or(Origin{}))
{}

void
MergedVoxels::clear()
{
  voxels_.clear();
  parts_.clear();
}

std::optional<LatestFrame>
MergedVoxels::add(ReceivedStream& stream,
                  Time oldest,
                  Time newest,
                  const std::optional<StampRange>& stamps)
{
  const std::optional<LatestFrame> latest =
      stream.latestVoxels(oldest, newest, frame_, stamps);
  if (!latest) {
    stream.setMergedVoxels(0, 0);
    return latest;
  }
  appendVoxels(frame_);
  Part part{&stream, voxels_.size(), {}};
  const std::uint32_t half = static_cast<std::uint32_t>(frame_.grid.size() / 2);
  for (std::size_t axis = 0; axis < 3; ++axis)
    part.middle[axis] = frame_.grid.centre(axis, half);
  parts_.push_back(part);
  return latest;
}

void
MergedVoxels::finish(io::VoxelFrame& merged)
{
  const float limit = intensityLimit();
  locateVoxels(limit);
  const bool are_all_on_lattice = intensities_.size() == voxels_.size();
  if (!are_all_on_lattice && !has_fixed_origin_ && moveOrigin())
    locateVoxels(limit);
  voxelize(merged);
  mergeColours(merged);
  if (memory_rule_.shouldRelease(voxels_.size() * sizeof(Voxel)))
    releaseMemory();
}

void
MergedVoxels::releaseMemory()
{
  voxelizer_.reset();
  frame_ = io::VoxelFrame();
  voxels_ = std::vector<Voxel>();
  parts_ = std::vector<Part>();
  coordinates_ = std::vector<float>();
  intensities_ = std::vector<float>();
  magnitudes_ = std::vector<float>();
  coloured_voxels_ = std::vector<ColouredVoxel>();
  spare_colours_ = std::vector<ColouredVoxel>();
}

void
MergedVoxels::appendVoxels(const io::VoxelFrame& frame)
{
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition position = io::voxelPosition(frame.keys[i]);
    Voxel voxel{};
    voxel.centre = {frame.grid.centre(0, position.x),
                    frame.grid.centre(1, position.y),
                    frame.grid.centre(2, position.z)};
    voxel.intensity = frame.hasIntensities()
                          ? frame.intensity_scale.value(frame.intensities[i])
                          : 1.0f;
    voxel.has_colour = frame.colour_bits > 0;
    if (voxel.has_colour)
      voxel.colour = frame.fullColour(i);
    voxels_.push_back(voxel);
  }
}

bool
MergedVoxels::findIndex(const Voxel& voxel, const Origin& origin, Index& index) const
{
  // A centre on a face is in the upper voxel, but may be just below after rounding.
  constexpr double margin = 1.0 / 1024.0;
  constexpr auto end = static_cast<double>(lattice_end);
  const double voxels_per_metre = 1.0 / resolution_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // From the lower end of the lattice, so that a cast rounds down.
    const double position =
        (voxel.centre[axis] - origin[axis]) * voxels_per_metre + margin + end;
    // Negated, so that NaN fails.
    if (!(position >= 0.0 && position < 2.0 * end))
      return false;
    index[axis] = static_cast<std::int32_t>(position) - lattice_end;
  }
  return true;
}

std::size_t
MergedVoxels::countOnLattice(const Origin& origin) const
{
  Index index;
  return static_cast<std::size_t>(
      std::count_if(voxels_.begin(), voxels_.end(), [&](const Voxel& voxel) {
        return findIndex(voxel, origin, index);
      }));
}

bool
MergedVoxels::moveOrigin()
{
  const Origin before = origin_;
  std::size_t most = intensities_.size();
  const auto tryOrigin = [&](const Origin& origin) {
    if (most == voxels_.size() || !isOrigin(origin))
      return;
    const std::size_t on_lattice = countOnLattice(origin);
    if (on_lattice <= most)
      return;
    most = on_lattice;
    origin_ = origin;
  };
  tryOrigin(Origin{});
  for (const Part& part : parts_) {
    // A corner of a voxel about the world's origin.
    Origin corner;
    for (std::size_t axis = 0; axis < 3; ++axis)
      corner[axis] = std::round(part.middle[axis] / resolution_) * resolution_;
    tryOrigin(corner);
  }
  return origin_ != before;
}

double
MergedVoxels::typicalIntensity()
{
  std::vector<float> medians;
  std::size_t next = 0;
  for (const Part& part : parts_) {
    magnitudes_.clear();
    for (; next < part.end; ++next)
      if (voxels_[next].intensity != 0.0f)
        magnitudes_.push_back(std::abs(voxels_[next].intensity));
    if (!magnitudes_.empty())
      medians.push_back(median(magnitudes_));
  }
  return static_cast<double>(median(medians));
}

float
MergedVoxels::intensityLimit()
{
  constexpr double most_steps = 65535.0;
  constexpr double steps_of_typical = 64.0;
  io::CommonStep step;
  float highest = 0.0f;
  for (const Voxel& voxel : voxels_) {
    step.add(voxel.intensity);
    highest = std::max(highest, std::abs(voxel.intensity));
  }
  const double exact = step.divisor() == 0 ? 0.0 : most_steps / step.divisor();
  if (static_cast<double>(highest) <= exact || parts_.size() < 2)
    return highest;
  // As long as a typical intensity has a step, those above it are as bright as they
  // are.
  const double typical = typicalIntensity();
  if (static_cast<double>(highest) <= typical * most_steps)
    return highest;
  const double beside_typical = typical * most_steps / steps_of_typical;
  return static_cast<float>(
      std::min(std::max(exact, beside_typical), static_cast<double>(highest)));
}

void
MergedVoxels::locateVoxels(float limit)
{
  coordinates_.clear();
  intensities_.clear();
  std::size_t next = 0;
  for (const Part& part : parts_) {
    std::size_t outside = 0;
    std::size_t reduced = 0;
    Index index;
    for (; next < part.end; ++next) {
      if (!findIndex(voxels_[next], origin_, index)) {
        ++outside;
        continue;
      }
      // Floats have enough bits for the middle of each voxel.
      for (const std::int32_t coordinate : index)
        coordinates_.push_back(static_cast<float>(coordinate) + 0.5f);
      const float intensity = voxels_[next].intensity;
      intensities_.push_back(std::clamp(intensity, -limit, limit));
      reduced += std::abs(intensity) > limit ? 1 : 0;
    }
    part.stream->setMergedVoxels(outside, reduced);
  }
}

void
MergedVoxels::voxelize(io::VoxelFrame& merged)
{
  if (!voxelizer_)
    voxelizer_.emplace(mergingVoxelizer());
  io::PointView points;
  points.coordinates = coordinates_.data();
  points.coordinate_stride = 3 * sizeof(float);
  points.intensities = intensities_.data();
  points.intensity_stride = sizeof(float);
  points.count = intensities_.size();
  // Merged frames are independent: each has a grid and a scale of its own.
  constexpr bool may_refit = true;
  voxelizer_->voxelize(points, may_refit, merged);
  merged.depth_model.reset();
  merged.grid.resolution = resolution_;
  merged.grid.origin = origin_;
}

void
MergedVoxels::mergeColours(io::VoxelFrame& merged)
{
  coloured_voxels_.clear();
  Index index;
  for (const Voxel& voxel : voxels_) {
    if (!voxel.has_colour || !findIndex(voxel, origin_, index))
      continue;
    const auto position = [&](std::size_t axis) {
      return static_cast<std::uint32_t>(index[axis] - merged.grid.first_index[axis]);
    };
    coloured_voxels_.push_back(
        {io::mortonKey({position(0), position(1), position(2)}), voxel.colour});
  }
  if (coloured_voxels_.empty())
    return;
  io::radixSort(coloured_voxels_, spare_colours_, io::usedBits(coloured_voxels_));
  merged.colour_bits = 8;
  merged.colours.reserve(merged.size());
  std::size_t next = 0;
  for (const std::uint64_t key : merged.keys) {
    io::detail::ColourMean colours;
    for (; next < coloured_voxels_.size() && coloured_voxels_[next].key == key; ++next)
      colours.add(coloured_voxels_[next].colour);
    // Black where no stream has a colour.
    merged.colours.push_back(colours.mean().value_or(io::VoxelColour{}));
  }
}

} // namespace nodes
} // namespace pcl_ext
