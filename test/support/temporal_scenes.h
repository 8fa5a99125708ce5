// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::temporal {

inline constexpr double voxel_edge = 0.04;
inline constexpr std::int64_t wall_size = 48;
inline constexpr std::int64_t wall_depth = 60;

inline io::VoxelFrame
scene(const Voxels& voxels)
{
  return frameOf(voxels, gridAt(0, 0, 0));
}

inline Voxels
voxelsOf(const io::VoxelFrame& frame)
{
  Voxels voxels;
  for (std::size_t i = 0; i < frame.size(); ++i)
    voxels[io::test::latticeIndex(frame, i)] = frame.intensities[i];
  return voxels;
}

inline Voxels
flatWall(std::int64_t depth = wall_depth, std::uint16_t symbol = 9)
{
  Voxels symbols;
  for (std::int64_t x = 0; x < wall_size; ++x)
    for (std::int64_t y = 0; y < wall_size; ++y)
      symbols[{x, y, depth}] = symbol;
  return symbols;
}

/** \brief A square plate at right angles to z, from begin to end along x and y. */
inline Voxels
squarePlate(std::int64_t begin, std::int64_t end, std::int64_t depth)
{
  Voxels voxels;
  for (std::int64_t x = begin; x < end; ++x)
    for (std::int64_t y = begin; y < end; ++y)
      voxels[{x, y, depth}] = 5;
  return voxels;
}

/** \brief In front of the middle of the wall, metres. */
inline constexpr std::array<double, 3> in_front = {
    wall_size * voxel_edge / 2, wall_size* voxel_edge / 2, -0.5};

inline Voxels
shownOf(TemporalVoxelFilter& filter,
        const Voxels& symbols,
        const std::optional<std::array<double, 3>>& sensor = in_front,
        const std::optional<std::chrono::nanoseconds>& time = std::nullopt)
{
  io::VoxelFrame frame = scene(symbols);
  const TemporalFilterStatus status = filter.filter(frame, {sensor, time});
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(isConsistent(frame));
  const Voxels shown = voxelsOf(frame);
  std::size_t both = 0;
  for (const auto& [index, symbol] : symbols)
    both += shown.count(index);
  EXPECT_EQ(status.hidden, symbols.size() - both);
  EXPECT_EQ(status.held, shown.size() - both);
  return shown;
}

/** \brief A filter that has seen the same ten times. */
inline TemporalVoxelFilter
filterBehind(const Voxels& symbols,
             unsigned int frames = TemporalVoxelFilter::usual_frames)
{
  TemporalVoxelFilter filter(frames);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(shownOf(filter, symbols), symbols);
  return filter;
}

} // namespace pcl_ext::temporal
