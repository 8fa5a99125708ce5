// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Streams of voxel frames that look like a sensor's: surfaces that stay and
 * flicker at their edges, noise, numbers of points that vary a little. Integers only,
 * so that every machine makes the same.
 */
#pragma once

#include "support/voxel_frames.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief A sensor that looks at a room which does not change. */
class RoomStream {
public:
  struct Settings {
    std::uint64_t seed = 1;
    unsigned int depth = 8; ///< at least 4
    unsigned int bits = 8;
    std::uint32_t width = 60; ///< of the surfaces, voxels; below 2^depth
    std::uint64_t noise = 10; ///< voxels a frame that are anywhere
    /** \brief Numbers of points as symbols if there is none. */
    std::optional<DepthModel> depth_model;
  };

  explicit RoomStream(const Settings& settings)
  : settings_(settings), random_(settings.seed), frame_(emptyFrame(settings.depth))
  {
    frame_.intensity_scale.bits = settings.bits;
    frame_.depth_model = settings.depth_model;
    const std::uint32_t end = std::uint32_t{1} << settings.depth;
    for (std::uint32_t x = 0; x < settings.width; ++x)
      for (std::uint32_t y = 0; y < settings.width; ++y) {
        // A floor with waves, and a wall over one of its edges.
        addToScene({x, y, 2 + (x / 8 * y / 8) % 3});
        if (x == 0)
          addToScene({end - 1 - y % 2, y, std::min(3 + y, end - 1)});
      }
  }

  const VoxelFrame&
  next()
  {
    std::map<std::uint64_t, std::uint16_t> voxels;
    for (const auto& [key, voxel] : scene_)
      if (below(random_, 256) < voxel.share)
        voxels[key] = symbolOf(key, voxel.points + below(random_, 8) / 7);
    const std::uint64_t end = std::uint64_t{1} << (3 * settings_.depth);
    for (std::uint64_t i = 0; i < settings_.noise; ++i) {
      const std::uint64_t key = below(random_, end);
      voxels[key] = symbolOf(key, 1);
    }
    clearVoxels(frame_);
    for (const auto& [key, symbol] : voxels) {
      frame_.keys.push_back(key);
      frame_.intensities.push_back(symbol);
    }
    return frame_;
  }

private:
  struct Voxel {
    std::uint64_t share;  ///< of the frames that have it, in 1/256
    std::uint64_t points; ///< 1 or more
  };

  void
  addToScene(const VoxelPosition& position)
  {
    const std::uint64_t kind = below(random_, 10);
    const std::uint64_t share = kind < 7 ? 256 : kind < 9 ? 230 : 90;
    scene_[mortonKey(position)] = {share, 1 + below(random_, kind < 7 ? 6 : 2)};
  }

  std::uint16_t
  symbolOf(std::uint64_t key, std::uint64_t points)
  {
    std::uint64_t symbol = points;
    if (settings_.depth_model) {
      const std::uint64_t point =
          settings_.depth_model->pointSymbol(voxelPosition(key));
      symbol = (points * point + (1 << 15)) >> 16;
      symbol += below(random_, 8) == 0 ? 1 : 0;
    }
    return static_cast<std::uint16_t>(
        std::min<std::uint64_t>(symbol, frame_.intensity_scale.maxSymbol()));
  }

  Settings settings_;
  std::mt19937_64 random_;
  VoxelFrame frame_;
  std::map<std::uint64_t, Voxel> scene_;
};

/** \brief A depth model for a grid of some depth: along x a point is worth from
 * little up to a third of the scale. */
inline DepthModel
roomDepthModel(unsigned int depth, unsigned int bits, std::uint8_t exponent = 2)
{
  DepthModel model;
  model.exponent = exponent;
  model.full_symbol = ((1u << bits) / 3) << 8;
  model.origin = std::int64_t{1} << 30;
  model.step = {static_cast<std::int32_t>((std::int64_t{3} << 30) >> depth), 1000, -77};
  return model;
}

/** \brief Settings of a room that a sensor sees, with depth model or without. */
inline RoomStream::Settings
roomSettings(unsigned int depth,
             std::uint32_t width,
             bool has_depth_model = false,
             unsigned int bits = 8)
{
  RoomStream::Settings settings;
  settings.depth = depth;
  settings.width = width;
  settings.bits = bits;
  if (has_depth_model)
    settings.depth_model = roomDepthModel(depth, bits);
  return settings;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
