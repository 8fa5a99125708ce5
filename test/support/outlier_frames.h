// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

namespace pcl_ext {

/** \brief Index of a voxel; those of large grids need more than 32 bits. */
using LatticeIndex = std::array<std::int64_t, 3>;

/** \brief Voxels by their index on the lattice, with symbols. */
using Voxels = std::map<LatticeIndex, std::uint16_t>;

inline io::VoxelGrid
gridAt(std::int32_t x, std::int32_t y, std::int32_t z, unsigned int depth = 7)
{
  io::VoxelGrid grid;
  grid.resolution = 0.04;
  grid.first_index = {x, y, z};
  grid.depth = depth;
  return grid;
}

inline io::VoxelFrame
frameOf(const Voxels& voxels,
        const io::VoxelGrid& grid,
        const io::IntensityScale& scale = {})
{
  std::map<std::uint64_t, std::uint16_t> by_key;
  for (const auto& [index, symbol] : voxels)
    by_key[io::mortonKey(
        {static_cast<std::uint32_t>(index[0] - grid.first_index[0]),
         static_cast<std::uint32_t>(index[1] - grid.first_index[1]),
         static_cast<std::uint32_t>(index[2] - grid.first_index[2])})] = symbol;
  io::VoxelFrame frame;
  frame.grid = grid;
  frame.intensity_scale = scale;
  for (const auto& [key, symbol] : by_key) {
    frame.keys.push_back(key);
    frame.intensities.push_back(symbol);
  }
  EXPECT_TRUE(io::isConsistent(frame));
  return frame;
}

using Scores = std::map<LatticeIndex, float>;

inline Scores
scoresOf(VoxelOutlierRemoval& removal, const io::VoxelFrame& frame)
{
  std::vector<float> log_odds;
  removal.score(frame, log_odds);
  EXPECT_EQ(log_odds.size(), frame.size());
  Scores scores;
  for (std::size_t i = 0; i < frame.size(); ++i)
    scores[io::test::latticeIndex(frame, i)] = log_odds[i];
  return scores;
}

inline VoxelOutlierRemovalSettings
settingsOf(DensityUnit unit, bool use_history = true)
{
  return {densityUnitSettings(unit, {{use_history}})};
}

/** \brief A wall at x with some holes, and noise before it. */
inline Voxels
wall(std::mt19937_64& random, std::int32_t x)
{
  Voxels voxels;
  for (std::int64_t y = 20; y < 45; ++y)
    for (std::int64_t z = 20; z < 45; ++z)
      if (random() % 8 != 0)
        voxels[{x + static_cast<std::int32_t>(random() % 2), y, z}] =
            static_cast<std::uint16_t>(30 + random() % 226);
  for (int i = 0; i < 40; ++i)
    voxels[{static_cast<std::int32_t>(10 + random() % 50),
            static_cast<std::int32_t>(10 + random() % 50),
            static_cast<std::int32_t>(10 + random() % 50)}] =
        static_cast<std::uint16_t>(30 + random() % 60);
  return voxels;
}

inline void
expectSame(const Scores& scores, const Scores& expected, float tolerance)
{
  ASSERT_EQ(scores.size(), expected.size());
  for (const auto& [index, score] : expected)
    ASSERT_NEAR(scores.at(index), score, tolerance)
        << index[0] << ' ' << index[1] << ' ' << index[2];
}

} // namespace pcl_ext
