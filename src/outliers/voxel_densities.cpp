// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/voxel_densities.h"

#include "outliers/density_blocks.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::uint32_t one_density = 256; // 1 in the fixed point of numbers_
constexpr std::uint32_t face_density = 255;
constexpr double most_points = DensityBlocks::most_points;

} // namespace

VoxelDensities::VoxelDensities(const DensityUnitSettings& unit)
: set_unit_(densityUnitOf(unit)), unit_(set_unit_)
{
  if (const auto* const faces = std::get_if<FacesUnit>(&unit))
    full_intensity_ = faces->full_intensity;
  if (const auto* const rays = std::get_if<RaysUnit>(&unit))
    intensities_are_counts_ = rays->intensities_are_counts;
  if (const auto* const automatic = std::get_if<AutomaticUnit>(&unit))
    intensities_are_counts_ = automatic->intensities_are_counts;
}

bool
VoxelDensities::canJudge(const io::VoxelFrame& frame) const
{
  switch (set_unit_) {
  case DensityUnit::Faces:
    return frame.hasIntensities();
  case DensityUnit::Points:
    return frame.hasIntensities() || frame.has_point_counts || frame.points.areThere();
  default:
    return true;
  }
}

DensityUnit
VoxelDensities::unitOf(const io::VoxelFrame& frame) const
{
  if (set_unit_ != DensityUnit::Automatic)
    return set_unit_;
  if (depth_model_ && frame.hasIntensities())
    return DensityUnit::Faces;
  // Counts and native intensities have the same scales, and few points in a voxel of a
  // lidar's are a sign of noise only where its rays are known.
  return sensor_rays_ ? DensityUnit::Rays : DensityUnit::Voxels;
}

bool
VoxelDensities::follow(const io::VoxelFrame& frame,
                       const io::VoxelPosition& first,
                       unsigned int levels)
{
  const DensityUnit last_unit = unit_;
  resolution_ = frame.grid.resolution;
  levels_ = levels;
  // An encoder may omit the model of a frame.
  if (frame.depth_model &&
      (set_unit_ == DensityUnit::Automatic || set_unit_ == DensityUnit::Faces))
    takeDepthModel(frame, first);
  // Not all frames of a stream need have their points.
  if (frame.points.sensor &&
      (set_unit_ == DensityUnit::Automatic || set_unit_ == DensityUnit::Rays))
    if (const auto rays = raysOf(*frame.points.sensor, first))
      sensor_rays_ = rays;
  unit_ = unitOf(frame);
  const bool uses_intensities = unit_ == DensityUnit::Rays
                                    ? intensities_are_counts_ && !frame.has_point_counts
                                    : unit_ != DensityUnit::Voxels;
  if (uses_intensities && frame.hasIntensities())
    makeNumbers(frame.intensity_scale);
  return last_unit == unit_;
}

void
VoxelDensities::makeNumbers(const io::IntensityScale& scale)
{
  double face = face_density; // density 1 for each point
  if (unit_ == DensityUnit::Rays)
    face = 0.0; // the numbers are of points, and other units have none of this
  else if (unit_ == DensityUnit::Faces)
    face = depth_model_ ? model_face_ : static_cast<double>(full_intensity_);
  if (!numbers_.empty() && face == face_ && scale == scale_)
    return;
  face_ = face;
  scale_ = scale;
  numbers_.resize(std::size_t{scale_.maxSymbol()} + 1);
  for (std::size_t symbol = 0; symbol < numbers_.size(); ++symbol) {
    const double intensity = scale_.value(static_cast<std::uint16_t>(symbol));
    if (unit_ == DensityUnit::Rays) {
      numbers_[symbol] = static_cast<std::uint16_t>(
          intensity >= 1.0 ? std::lround(std::min(intensity, most_points)) : 1);
      continue;
    }
    const double density = std::clamp(
        face_density * intensity / face, 0.0, static_cast<double>(face_density));
    // NaN counts as the lowest density, as the voxel is occupied.
    numbers_[symbol] = static_cast<std::uint16_t>(
        density >= 0.0 ? std::lround(density * one_density) : 0);
  }
}

void
VoxelDensities::takeDepthModel(const io::VoxelFrame& frame,
                               const io::VoxelPosition& first)
{
  depth_model_ = frame.depth_model;
  // Relative to position 0, as later frames may have another grid. No overflow, as
  // steps are below 2^31 and the origin is at most 2^56.
  depth_model_->origin -= std::int64_t{depth_model_->step[0]} * first.x +
                          std::int64_t{depth_model_->step[1]} * first.y +
                          std::int64_t{depth_model_->step[2]} * first.z;
  model_face_ = depth_model_->full_symbol / 256.0 *
                static_cast<double>(frame.intensity_scale.step);
  if (factors_.empty() || depth_model_->exponent != exponent_)
    makeFactors();
}

void
VoxelDensities::makeFactors()
{
  exponent_ = depth_model_->exponent;
  constexpr std::size_t one = std::size_t{1} << depth_bits;
  factors_.resize(one + 1);
  const double voxels = std::exp2(levels_); // on an edge of a coarse voxel
  const double edge = resolution_ * voxels;
  const double points_on_face =
      std::max(1.0, VoxelOutlierRemoval::sure_points_per_square_metre * edge * edge);
  for (std::size_t i = 0; i <= one; ++i) {
    // Depth 0 counts as half a step.
    const double depth = std::max(static_cast<double>(i), 0.5) / one;
    // In cut-off depths of a voxel. Beyond 1, where laws saturate, a point has a share
    // of 1.
    const double voxel_depth = depth * voxels;
    const double saturation = std::max(1.0, voxel_depth * voxel_depth);
    // The quadratic law has one more factor of the relative depth.
    const double to_shares = exponent_ == 1 ? std::min(1.0, voxel_depth) : 1.0;
    // 1 / depth^2 points fit on a face.
    const double covered = std::min(1.0, points_on_face * depth * depth);
    factors_[i] = static_cast<std::uint64_t>(
        std::llround(65536.0 * to_shares * saturation / (covered * voxels * voxels)));
  }
}

std::uint32_t
VoxelDensities::operator()(const io::VoxelFrame& frame,
                           std::size_t voxel,
                           const io::VoxelPosition& position) const
{
  constexpr std::uint64_t most = std::uint64_t{face_density} * one_density;
  if (unit_ == DensityUnit::Voxels)
    return most;
  if (unit_ == DensityUnit::Rays)
    return pointsOf(frame, voxel);
  if (unit_ == DensityUnit::Points)
    return static_cast<std::uint32_t>(
        frame.has_point_counts
            ? std::min(std::uint64_t{frame.point_counts[voxel]} * one_density, most)
            : numbers_[frame.intensities[voxel]]);
  std::uint64_t number = numbers_[frame.intensities[voxel]];
  if (depth_model_) {
    const std::int64_t depth = depth_model_->origin +
                               std::int64_t{depth_model_->step[0]} * position.x +
                               std::int64_t{depth_model_->step[1]} * position.y +
                               std::int64_t{depth_model_->step[2]} * position.z;
    const std::int64_t one = std::int64_t{1} << (32 + levels_);
    const auto clamped =
        static_cast<std::uint64_t>(std::clamp(depth, std::int64_t{0}, one));
    number = number * factors_[clamped >> (32 + levels_ - depth_bits)] >> 16;
  }
  else
    number >>= 2 * levels_;
  return static_cast<std::uint32_t>(std::min(number, most));
}

std::uint32_t
VoxelDensities::pointsOf(const io::VoxelFrame& frame, std::size_t voxel) const
{
  if (frame.has_point_counts)
    return std::min(frame.point_counts[voxel],
                    static_cast<std::uint32_t>(DensityBlocks::most_points));
  return hasPoints(frame) ? numbers_[frame.intensities[voxel]] : 1;
}

std::int16_t
VoxelDensities::density(std::uint64_t sum) const
{
  if (unit_ == DensityUnit::Rays)
    return static_cast<std::int16_t>(
        std::clamp(sum, std::uint64_t{1}, std::uint64_t{DensityBlocks::most_points}));
  const std::uint64_t density = (sum + one_density / 2) / one_density;
  return static_cast<std::int16_t>(
      std::clamp(density, std::uint64_t{1}, std::uint64_t{face_density}));
}

} // namespace pcl_ext::PCL_EXT_ABI
