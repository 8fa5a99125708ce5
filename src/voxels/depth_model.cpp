// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/impl/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

bool
isConsistent(const DepthModel& model)
{
  constexpr std::int64_t farthest = std::int64_t{1} << 56;
  return (model.exponent == 1 || model.exponent == 2) &&
         model.full_symbol < (std::uint32_t{1} << 24) && model.origin >= -farthest &&
         model.origin <= farthest;
}

std::optional<DepthModel>
depthModelOf(const DepthLaw& law,
             const std::array<double, 3>& sensor_origin,
             const std::array<double, 3>& optical_axis,
             const VoxelGrid& grid,
             const IntensityScale& scale)
{
  if (scale.offset != 0.0f || scale.companded_range != 0)
    return std::nullopt;
  const double one = std::exp2(32);
  DepthModel model;
  model.exponent = static_cast<std::uint8_t>(law.exponent);
  const double full_symbol =
      256.0 * law.full_intensity / static_cast<double>(scale.step);
  double origin = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    origin += optical_axis[axis] * (grid.centre(axis, 0) - sensor_origin[axis]);
    const double step = one * optical_axis[axis] * grid.resolution / law.cut_off_depth;
    // Negated, so that NaN fails.
    if (!(std::abs(step) < std::exp2(31)))
      return std::nullopt;
    model.step[axis] = static_cast<std::int32_t>(std::lround(step));
  }
  origin *= one / law.cut_off_depth;
  if (!(std::abs(origin) <= std::exp2(56)) ||
      !(full_symbol >= 0.0 && full_symbol < std::exp2(24) - 1.0))
    return std::nullopt;
  model.origin = std::llround(origin);
  model.full_symbol = static_cast<std::uint32_t>(std::lround(full_symbol));
  if (!isConsistent(model))
    return std::nullopt;
  return model;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
