#include "outliers/voxel_densities.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {

namespace {

constexpr std::uint32_t one_density = 256; // 1 in the fixed point of numbers_
constexpr double face_density = 255.0;

} // namespace

bool
VoxelDensities::follow(const io::VoxelFrame& frame, const io::VoxelPosition& first)
{
  const bool were_faces = areFaces();
  // An encoder may omit the model of a frame.
  if (frame.depth_model && unit_ != DensityUnit::Points)
    takeDepthModel(frame, first);
  double face = face_density; // density 1 for each point
  if (areFaces())
    face = depth_model_ ? model_face_ : static_cast<double>(full_intensity_);
  if (numbers_.empty() || face != face_ || frame.intensity_scale != scale_) {
    face_ = face;
    scale_ = frame.intensity_scale;
    numbers_.resize(std::size_t{scale_.maxSymbol()} + 1);
    for (std::size_t symbol = 0; symbol < numbers_.size(); ++symbol) {
      const double intensity = scale_.value(static_cast<std::uint16_t>(symbol));
      const double density =
          std::clamp(face_density * intensity / face, 0.0, face_density);
      // NaN counts as the lowest density, as the voxel is occupied.
      numbers_[symbol] = static_cast<std::uint16_t>(
          density >= 0.0 ? std::lround(density * one_density) : 0);
    }
  }
  return were_faces == areFaces();
}

void
VoxelDensities::takeDepthModel(const io::VoxelFrame& frame,
                               const io::VoxelPosition& first)
{
  depth_model_ = frame.depth_model;
  // Relative to position 0, as later frames may have another grid. No overflow, as steps
  // are below 2^31 and the origin is at most 2^56.
  depth_model_->origin -= std::int64_t{depth_model_->step[0]} * first.x +
                          std::int64_t{depth_model_->step[1]} * first.y +
                          std::int64_t{depth_model_->step[2]} * first.z;
  model_face_ = depth_model_->full_symbol / 256.0 *
                static_cast<double>(frame.intensity_scale.step);
  if (depth_model_->exponent != exponent_ || frame.grid.resolution != resolution_)
    makeFactors(depth_model_->exponent, frame.grid.resolution);
}

void
VoxelDensities::makeFactors(unsigned int exponent, double resolution)
{
  exponent_ = exponent;
  resolution_ = resolution;
  constexpr std::size_t one = std::size_t{1} << depth_bits;
  factors_.resize(one + 1);
  const double points_on_face = std::max(
      1.0, VoxelOutlierRemoval::sure_points_per_square_metre * resolution * resolution);
  for (std::size_t i = 0; i <= one; ++i) {
    // Depth 0 counts as half a step.
    const double depth = std::max(static_cast<double>(i), 0.5) / one;
    // The quadratic law has one more factor of the relative depth.
    const double to_shares = exponent == 1 ? depth : 1.0;
    // 1 / depth^2 points fit on a face.
    const double covered = std::min(1.0, points_on_face * depth * depth);
    factors_[i] =
        static_cast<std::uint64_t>(std::llround(65536.0 * to_shares / covered));
  }
}

std::int16_t
VoxelDensities::operator()(std::uint16_t symbol,
                           const io::VoxelPosition& position) const
{
  std::uint64_t number = numbers_[symbol];
  if (depth_model_) {
    const std::int64_t depth = depth_model_->origin +
                               std::int64_t{depth_model_->step[0]} * position.x +
                               std::int64_t{depth_model_->step[1]} * position.y +
                               std::int64_t{depth_model_->step[2]} * position.z;
    constexpr std::int64_t one = std::int64_t{1} << 32;
    const auto clamped =
        static_cast<std::uint64_t>(std::clamp(depth, std::int64_t{0}, one));
    const auto place = static_cast<std::size_t>(clamped >> (32 - depth_bits));
    number = number * factors_[place] >> 16;
  }
  const std::uint64_t density = (number + one_density / 2) / one_density;
  return static_cast<std::int16_t>(
      std::clamp<std::uint64_t>(density, 1, static_cast<std::uint64_t>(face_density)));
}

} // namespace pcl_ext
