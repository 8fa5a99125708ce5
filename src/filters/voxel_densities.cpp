#include "voxel_densities.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {

namespace {

constexpr std::uint32_t one_density = 256; // fixed point of numbers_
constexpr double face_density = 255.0;

} // namespace

bool
VoxelDensities::follow(const io::VoxelFrame& frame)
{
  const bool were_faces = areFaces();
  // An encoder leaves the model out of frames where it does not pay.
  if (frame.depth_model && unit_ != DensityUnit::Points)
    depth_model_ = frame.depth_model;
  double face = face_density; // so that a point is a density of 1
  if (areFaces())
    face = depth_model_ ? depth_model_->full_symbol / 256.0 *
                              static_cast<double>(frame.intensity_scale.step)
                        : static_cast<double>(full_intensity_);
  if (numbers_.empty() || face != face_ || frame.intensity_scale != scale_) {
    face_ = face;
    scale_ = frame.intensity_scale;
    numbers_.resize(std::size_t{scale_.maxSymbol()} + 1);
    for (std::size_t symbol = 0; symbol < numbers_.size(); ++symbol) {
      const double intensity = scale_.value(static_cast<std::uint16_t>(symbol));
      const double density =
          std::clamp(face_density * intensity / face, 0.0, face_density);
      // What is no number counts as the least; the voxel is there.
      numbers_[symbol] = static_cast<std::uint16_t>(
          density >= 0.0 ? std::lround(density * one_density) : 0);
    }
  }
  return were_faces == areFaces();
}

std::int16_t
VoxelDensities::operator()(std::uint16_t symbol,
                           const io::VoxelPosition& position) const
{
  std::uint32_t number = numbers_[symbol];
  if (depth_model_ && depth_model_->exponent == 1) {
    // A point is worth its relative depth once more under the quadratic law.
    const std::int64_t depth = depth_model_->origin +
                               std::int64_t{depth_model_->step[0]} * position.x +
                               std::int64_t{depth_model_->step[1]} * position.y +
                               std::int64_t{depth_model_->step[2]} * position.z;
    constexpr std::int64_t one = std::int64_t{1} << 32;
    number = static_cast<std::uint32_t>(
        number * (static_cast<std::uint64_t>(std::clamp(depth, std::int64_t{0}, one)) >>
                  16) >>
        16);
  }
  const std::uint32_t density = (number + one_density / 2) / one_density;
  return static_cast<std::int16_t>(std::max(density, 1u));
}

} // namespace pcl_ext
