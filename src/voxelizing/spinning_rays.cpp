// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/robust_fit.h"
#include "voxelizing/spinning_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {

bool
setSpinningRays(const SpinningFit& fit,
                const WorldPose& sensor_pose,
                const VoxelGrid& grid,
                scan::ScanLayout& layout)
{
  const double step = depthStepFor(fit.depth_step, grid.resolution);
  const auto wide = [](double number, int bits) {
    return fixedPoint(number, bits, 0x1p54);
  };
  const auto fixed = [](double number, int bits) {
    return static_cast<std::int32_t>(fixedPoint(number, bits, 0x1p30));
  };
  scan::ScanRays& rays = layout.rays;
  rays = scan::ScanRays();
  rays.shape = scan::RayShape::Spinning;
  Eigen::Matrix3d spin;
  for (int axis = 0; axis < 3; ++axis)
    spin.col(axis) = fit.motion.spin.cross(Eigen::Vector3d::Unit(axis));
  const Eigen::Matrix3d axes = sensor_pose.linear();
  const double begin = timeOf(0, layout.width);
  const Eigen::Vector3d first_origin =
      sensor_pose * (fit.motion.shift + begin * fit.motion.velocity);
  const Eigen::Matrix3d first_axes =
      axes * (Eigen::Matrix3d::Identity() + begin * spin);
  const Eigen::Vector3d drift = axes * fit.motion.velocity / layout.width;
  const Eigen::Matrix3d turn = axes * spin / layout.width;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    rays.pose.origin[axis] =
        wide((first_origin[i] - grid.lowerCorner(axis)) / grid.resolution, 16);
    rays.motion.origin[axis] = wide(drift[i] / grid.resolution, 32);
    for (std::size_t of = 0; of < 3; ++of) {
      rays.pose.vectors[of][axis] = fixed(first_axes(i, static_cast<int>(of)), 30);
      rays.motion.vectors[of][axis] = wide(turn(i, static_cast<int>(of)), 46);
    }
  }
  const double most_steps = fit.is_even ? 2.0 * layout.width : two_pi / fit.turn_step;
  for (double steps = 1.0; steps < most_steps; steps *= 2.0) {
    const double angle = steps * fit.turn_step;
    rays.turns.push_back({fixed(std::cos(angle), 30), fixed(std::sin(angle), 30)});
  }
  if (fit.is_even) {
    rays.columns.resize(layout.width);
    std::iota(rays.columns.begin(), rays.columns.end(), 0);
  }
  for (const RowFit& row : fit.rows)
    rays.rows.push_back({fixed(std::cos(row.angle), 30),
                         fixed(std::sin(row.angle), 30),
                         fixed(row.run * step / grid.resolution, 24),
                         fixed(row.rise * step / grid.resolution, 24),
                         fixed(row.along / grid.resolution, 16),
                         fixed(row.across / grid.resolution, 16),
                         fixed(row.up / grid.resolution, 16)});
  return isConsistent(layout);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
