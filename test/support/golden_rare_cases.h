// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Golden streams of what the streams of sensors seldom have: each is made for
 * some rules of doc/bitstream*.md that the others do not reach.
 */
#pragma once

#include "support/golden_stream.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief Stamps of a stream whose I-frame has none; they go back below 0, and the
 * frame_id becomes empty. */
inline std::optional<FrameStamp>
rareStamp(std::size_t index)
{
  switch (index) {
  case 1:
    return FrameStamp{77000, "a frame"};
  case 2:
    return FrameStamp{76000, ""};
  case 4:
    return FrameStamp{~std::uint64_t{0} - 4, ""};
  case 5:
    return FrameStamp{9, "b"};
  default:
    return std::nullopt;
  }
}

/** \brief Blocks that fill up, empty and fill again; then other voxels, twice, so that
 * nothing that is known is of use, with frames after them that know these. */
inline GoldenStream
goldenJumps(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(43);
  VoxelFrame frame = emptyFrame(4, 4);
  std::set<std::uint64_t> keys;
  const auto addAnywhere = [&](std::size_t count) {
    while (keys.size() < count)
      keys.insert(64 + below(random, 64 * 63));
  };
  const auto send = [&] {
    setVoxels(random, keys, frame);
    stream.frames.push_back({frame, rareStamp(stream.frames.size())});
  };
  const auto addToBlock = [&](std::size_t most) {
    for (std::uint64_t cell = 0; cell < 64 && most > 0; ++cell)
      most -= keys.insert(cell * 37 % 64).second ? 1 : 0;
    send();
  };
  addAnywhere(90);
  const std::set<std::uint64_t> anywhere = keys;
  // Half of the first octant, and each of the octants with the highest numbers.
  keys.insert({0, 1, 2, 3, 32, 40, 48, 56});
  send();
  keys.insert({4, 5, 6, 7, 9, 17}); // beside cells that are occupied
  send();
  for (const std::size_t count : {10u, 10u, 64u})
    addToBlock(count);
  keys = anywhere;
  send();
  addToBlock(64);
  for (const std::size_t count : {90u, 40u}) {
    keys.clear();
    addAnywhere(count);
    send();
    addAnywhere(count + 5);
    send();
    stream.frames.push_back({emptyFrame(4, 4), std::nullopt});
    addAnywhere(count + 10);
    send();
  }
  return stream;
}

/** \brief Blocks with voxels in three or all four of their octants with the highest
 * numbers: it depends on how many there are where else new ones come. */
inline GoldenStream
goldenOctants(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  VoxelFrame frame = emptyFrame(4);
  for (std::uint64_t i = 0; i < 5; ++i) {
    std::set<std::uint64_t> keys;
    for (std::uint64_t block = 0; block < 64; ++block) {
      const std::uint64_t first = 64 * block;
      const bool is_full = block % 2 == 0;
      keys.insert({first + 32, first + 40, first + 48});
      if (is_full)
        keys.insert(first + 56);
      if (i > 0)
        keys.insert({first + i, first + 8 + i, first + (is_full ? 32 : 56) + i});
    }
    frame.keys.assign(keys.begin(), keys.end());
    frame.intensities.assign(keys.size(), 1);
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

/** \brief Voxels that stay, and others that come and go at random, each with a share of
 * its own, of blocks that get many new ones: what is remembered reaches its
 * thresholds. */
inline GoldenStream
goldenFlicker(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(67);
  VoxelFrame frame = emptyFrame(4);
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 32; ++i) {
    std::set<std::uint64_t> keys;
    for (std::uint64_t key = 2048; key < 4096; key += 16)
      keys.insert(key);
    for (const std::uint64_t key : seen)
      if (below(random, 32) < key * 37 % 61 % 9 * (key % 4) + 1)
        keys.insert(key);
    for (int block = 0; block < 5; ++block) {
      const std::uint64_t first = 64 * below(random, 32);
      for (std::uint64_t count = below(random, 13); count > 0; --count)
        keys.insert(first + below(random, 64));
    }
    seen.insert(keys.begin(), keys.lower_bound(2048));
    frame.keys.assign(keys.begin(), keys.end());
    frame.intensities.clear();
    for (const std::uint64_t key : keys)
      frame.intensities.push_back(static_cast<std::uint16_t>(key % 3));
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

/** \brief A voxel frame with a depth model and these keys, of 1 or 2 points each.
 * \param[in] share of a point's symbol, in 2^-6, by a voxel's key
 * \param[in] noise added to the symbol, by a voxel's key
 */
template <typename ShareT, typename NoiseT>
inline VoxelFrame
depthFrame(const DepthModel& model,
           unsigned int depth,
           unsigned int bits,
           const std::vector<std::uint64_t>& keys,
           ShareT share,
           NoiseT noise)
{
  VoxelFrame frame = emptyFrame(depth, bits);
  frame.depth_model = model;
  frame.keys = keys;
  for (const std::uint64_t key : keys) {
    const std::uint64_t point = model.pointSymbol(voxelPosition(key));
    const std::uint64_t exact = (1 + key % 5 / 3) * point * share(key) / 64;
    frame.intensities.push_back(static_cast<std::uint16_t>(std::min<std::uint64_t>(
        ((exact + (1 << 15)) >> 16) + noise(key), frame.intensity_scale.maxSymbol())));
  }
  return frame;
}

/** \brief Every some keys below an end. */
inline std::vector<std::uint64_t>
everySome(std::uint64_t some, std::uint64_t end)
{
  std::vector<std::uint64_t> keys;
  for (std::uint64_t key = 5; key < end; key += some)
    keys.push_back(key);
  return keys;
}

/** \brief Depths before and after all that a model has, voxels without residuals,
 * depth offsets as large as there are, and numbers of points of 0. Then frames of more
 * than a thousand voxels, with fewer and with more residuals than that. */
inline GoldenStream
goldenDepthLimits(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  DepthModel model;
  model.exponent = 1;
  model.full_symbol = 300u << 8;
  model.origin = -(std::int64_t{1} << 30);
  model.step = {402653184, 1000, -8600000};
  // Shares of a point's symbol in 2^-6, for voxels that come one third after the other:
  // depth offsets become as high, and then as low, as they are allowed to.
  constexpr std::uint64_t shares[][3] = {
      {64, 0, 0}, {64, 95, 0}, {64, 141, 33}, {64, 64, 17}, {0, 30, 3000}};
  const auto send = [&](const std::vector<std::uint64_t>& keys, std::uint64_t i) {
    stream.frames.push_back(
        {depthFrame(
             model,
             4,
             10,
             keys,
             [&](std::uint64_t key) { return i < 5 ? shares[i][key % 3] : 64; },
             [&](std::uint64_t key) { return i == 7 ? key % 41 : 0; }),
         std::nullopt});
  };
  for (std::uint64_t i = 0; i < 8; ++i) {
    std::vector<std::uint64_t> keys;
    for (const std::uint64_t key : everySome(13, 4096))
      if (key % 3 <= i && i != 5)
        keys.push_back(key);
    if (i == 6)
      model.exponent = 2;
    send(keys, i);
  }
  send(everySome(3, 3072), 8); // 1023 voxels
  send(everySome(3, 3075), 8); // 1024 voxels
  send(everySome(2, 4096), 8);
  return stream;
}

/** \brief Residuals as large as there are, and a model with which no voxel has one. */
inline GoldenStream
goldenLargeResiduals(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  const std::vector<std::uint64_t> keys = everySome(7, 512);
  const auto none = [](std::uint64_t) { return std::uint64_t{0}; };
  DepthModel model;
  model.exponent = 1;
  model.full_symbol = 20000u << 8;
  model.step = {1 << 29, 12345678, 1 << 25};
  // An encoder uses a model that predicts the symbols of the I-frame.
  stream.frames.push_back(
      {depthFrame(
           model, 3, 16, keys, [](std::uint64_t) { return 64; }, none),
       std::nullopt});
  model.origin = std::int64_t{1} << 32;
  model.step = {0, 0, 0};
  for (int i = 0; i < 10; ++i) {
    // Depth offsets are learnt: with a larger model a point is worth more than the
    // scale.
    model.full_symbol = i < 8 ? 1u << 23 : i < 9 ? (1u << 24) - 1 : 100;
    const std::uint64_t symbol = i < 8 ? 49000 : i < 9 ? 45000 : 3;
    stream.frames.push_back(
        {depthFrame(model, 3, 16, keys, none, [&](std::uint64_t) { return symbol; }),
         std::nullopt});
  }
  return stream;
}

/** \brief Scales of other numbers of bits than those of sensors. */
inline GoldenStream
goldenScales(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(47);
  const std::pair<unsigned int, std::uint16_t> scales[] = {
      {1, 9}, {2, 100}, {4, 254}, {5, 0}, {14, 0}, {15, 65535}};
  for (const auto& [bits, range] : scales) {
    VoxelFrame frame = randomFrame(random, 4, 40, bits);
    frame.intensity_scale.companded_range = range;
    for (int i = 0; i < 2; ++i) {
      stream.frames.push_back({frame, std::nullopt});
      walk(random, 5, frame);
    }
  }
  return stream;
}

/** \brief Symbols of all sizes, of which some stay, some vary, and some jump. */
inline GoldenStream
goldenSpread(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(71);
  VoxelFrame frame = emptyFrame(3, 12);
  constexpr std::uint64_t means[] = {3, 4, 5, 7, 12, 60, 600, 3000};
  for (int i = 0; i < 8; ++i) {
    clearVoxels(frame);
    for (std::uint64_t key = 0; key < 512; ++key) {
      const std::uint64_t mean = means[key / 64];
      const std::uint64_t width =
          key % 8 == 7 ? 2 * mean + 5 : mean * (key % 8) / 6 + 1;
      const std::uint64_t symbol =
          below(random, 30) == 0
              ? below(random, 4096)
              : mean - std::min(mean, width / 2) + below(random, width);
      frame.keys.push_back(key);
      frame.intensities.push_back(
          static_cast<std::uint16_t>(std::min<std::uint64_t>(symbol, 4095)));
    }
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

/** \brief Voxels within cells: more than a thousand cells, few voxels, none, and parts
 * whose voxels are all in one half. */
inline GoldenStream
goldenFewCells(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(53);
  VoxelFrame frame = emptyFrame(9, 5);
  frame.grid.resolution = 0.004;
  const auto send = [&](const std::set<std::uint64_t>& keys) {
    frame.keys.assign(keys.begin(), keys.end());
    frame.intensities.assign(keys.size(), 3);
    stream.frames.push_back({frame, std::nullopt});
  };
  const auto cell = [](std::uint64_t index) { return index * 7919 % (1 << 18) << 9; };
  std::set<std::uint64_t> keys;
  for (std::uint64_t i = 0; i < 1600; ++i)
    keys.insert(cell(i % 1050) + below(random, 512));
  send(keys);
  keys.clear();
  for (std::uint64_t i = 0; i < 300; ++i)
    keys.insert(cell(i % 100) + below(random, 512));
  send(keys);
  send({});
  keys.clear();
  for (std::uint64_t i = 0; i < 20; ++i) {
    keys.insert(cell(3) + i);
    keys.insert(cell(4) + 511 - 3 * i);
  }
  send(keys);
  keys.clear();
  for (std::size_t i = 0, size = 0; i < 24; ++i)
    for (size += 15 + i % 3; keys.size() < size;)
      keys.insert(cell(i) + below(random, 512));
  send(keys);
  return stream;
}

/** \brief Colours that stay: voxels that are away for seven and for eight frames with
 * voxels; then an I-frame without voxels; then numbers of points alone, some large. */
inline GoldenStream
goldenStill(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 11, {}};
  std::mt19937_64 random(59);
  VoxelFrame frame = emptyFrame(3);
  for (int i = 0; i < 15; ++i) {
    clearVoxels(frame);
    frame.colour_bits = i < 13 ? 3 : 0;
    for (std::uint64_t key = 0; key < 300 && i != 4 && i != 11; key += 3) {
      if ((key == 120 && i > 0 && i < 9) || (key == 150 && i > 0 && i < 10))
        continue;
      const bool is_other = key == 120 || key == 150;
      frame.keys.push_back(key);
      frame.intensities.push_back(2);
      if (frame.colour_bits > 0)
        frame.colours.push_back(is_other ? VoxelColour{0, 1, 7} : VoxelColour{5, 3, 2});
    }
    if (i >= 13) {
      addPointCounts(random, frame);
      frame.point_counts[7] = 1u << 22;
      frame.point_counts[8] = 0xfffff;
    }
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
