// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The streams whose bytes are kept in test/data/golden, so that what was once
 * written stays readable and is written the same. Made of integers only, with nothing
 * that differs between standard libraries.
 */
#pragma once

#include "support/changing_frames.h"
#include "support/golden_disorder.h"
#include "support/golden_fields.h"
#include "support/golden_rare_cases.h"
#include "support/golden_scans.h"
#include "support/golden_stream.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

inline GoldenStream
goldenRoom(const std::string& name,
           Effort effort,
           const RoomStream::Settings& settings,
           bool has_stamps)
{
  GoldenStream stream{name, effort, 5, {}};
  RoomStream room(settings);
  for (std::uint64_t i = 0; i < 12; ++i) {
    GoldenFrame frame{room.next(), std::nullopt};
    if (i == 3 || i == 4 || i == 10) // nothing is seen, on a P- and an I-frame, too
      clearVoxels(frame.frame);
    if (has_stamps && i != 7)
      frame.stamp = FrameStamp{1700000000000000 + 49987 * i - (i == 9 ? 1000000 : 0),
                               i < 6 ? "sensor" : "a longer name of a frame"};
    stream.frames.push_back(frame);
  }
  return stream;
}

/** \brief Any voxels of grids of all depths with symbols of all sizes. */
inline GoldenStream
goldenWalks(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 7, {}};
  std::mt19937_64 random(3);
  for (const unsigned int depth : {1u, 2u, 3u, 9u, 21u})
    for (const unsigned int bits : {1u, 8u, 16u}) {
      VoxelFrame frame = randomFrame(random, depth, depth == 1 ? 4 : 50, bits);
      for (int i = 0; i < 4; ++i) {
        stream.frames.push_back({frame, std::nullopt});
        walk(random, 3, frame);
      }
    }
  return stream;
}

/** \brief Symbols of which nothing can be expected, of 3, 8 and 13 bits. */
inline GoldenStream
goldenNoise(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 4, {}};
  std::mt19937_64 random(17);
  for (const unsigned int bits : {3u, 8u, 13u}) {
    RoomStream::Settings settings;
    settings.depth = 6;
    settings.width = 24;
    settings.bits = bits;
    RoomStream room(settings);
    for (int i = 0; i < 3; ++i) {
      GoldenFrame frame{room.next(), std::nullopt};
      for (std::uint16_t& symbol : frame.frame.intensities)
        symbol = static_cast<std::uint16_t>(random() >> (64 - bits));
      stream.frames.push_back(frame);
    }
  }
  return stream;
}

/** \brief Frames large enough for all that coders do with many voxels, and more of them
 * than anything that is remembered counts. */
inline GoldenStream
goldenLargeRoom(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  RoomStream::Settings settings;
  settings.depth = 7;
  settings.width = 45;
  settings.noise = 40;
  RoomStream room(settings);
  for (int i = 0; i < 36; ++i)
    stream.frames.push_back({room.next(), std::nullopt});
  return stream;
}

/** \brief Dense blocks, so that new ones come beside known ones, and small symbols of
 * which some are the highest there is. */
inline GoldenStream
goldenDense(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 9, {}};
  std::mt19937_64 random(29);
  for (const unsigned int depth : {3u, 4u, 5u}) {
    VoxelFrame frame = randomFrame(random, depth, depth == 3 ? 40 : 200);
    for (int i = 0; i < 9; ++i) {
      for (std::uint16_t& symbol : frame.intensities)
        symbol = static_cast<std::uint16_t>(
            below(random, 50) == 0 ? 255 - below(random, 2) : below(random, 4));
      stream.frames.push_back({frame, std::nullopt});
      walk(random, 15, frame);
    }
  }
  return stream;
}

/** \brief A depth model that changes, which the encoder does without, as all symbols
 * are the same. */
inline GoldenStream
goldenLargeRests(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 30, {}};
  std::mt19937_64 random(31);
  VoxelFrame frame = randomFrame(random, 3, 60, 16);
  DepthModel model;
  model.exponent = 1;
  model.origin = std::int64_t{1} << 32;
  model.step = {0, 0, 0};
  for (int i = 0; i < 24; ++i) {
    // Depth offsets are learnt; a model of another size then gives other numbers of
    // points.
    model.full_symbol = i < 20 ? 1u << 23 : i < 22 ? (1u << 24) - 1 : 100;
    frame.depth_model = model;
    for (std::uint16_t& symbol : frame.intensities)
      symbol = static_cast<std::uint16_t>(i < 20 ? 49000 : i < 22 ? 48000 : i);
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

/** \brief Rooms with colours and numbers of points, with and without intensities and a
 * depth model. */
inline GoldenStream
goldenColours(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 6, {}};
  std::mt19937_64 random(37);
  for (const unsigned int colour_bits : {1u, 5u, 8u, 7u}) {
    RoomStream::Settings settings;
    settings.depth = 6;
    settings.width = 24;
    settings.noise = 5;
    if (colour_bits == 7)
      settings.depth_model = roomDepthModel(settings.depth, settings.bits, 1);
    RoomStream room(settings);
    for (int i = 0; i < 14; ++i) {
      GoldenFrame golden{room.next(), std::nullopt};
      if (i == 9 || i == 12) // nothing is seen, on a P- and an I-frame
        clearVoxels(golden.frame);
      addColours(random, colour_bits, golden.frame);
      if (colour_bits != 1)
        addPointCounts(random, golden.frame);
      if (colour_bits == 5)
        removeIntensities(golden.frame);
      stream.frames.push_back(golden);
    }
  }
  return stream;
}

/** \brief Voxels that are alone, which are coded within cells: points of a surface, and
 * some parts with many. */
inline GoldenStream
goldenFineVoxels(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 3, {}};
  std::mt19937_64 random(41);
  for (const unsigned int bits : {0u, 8u, 13u})
    for (int i = 0; i < 4; ++i) {
      GoldenFrame golden{fineFrame(random, bits), std::nullopt};
      golden.frame.grid.origin = {16777216.0, -33554432.5, 0.0};
      if (bits != 8)
        addPointCounts(random, golden.frame);
      if (bits != 13)
        addColours(random, 7, golden.frame);
      stream.frames.push_back(golden);
    }
  return stream;
}

/** \brief Layouts of messages, which others follow and none, in frames of all kinds. */
inline GoldenStream
goldenLayouts(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 5, {}};
  ChangingFrames frames(8);
  const auto place =
      [](const char* field, FieldType type, std::uint32_t count, std::uint32_t offset) {
        PlacedField placed;
        placed.name = field;
        placed.type = type;
        placed.count = count;
        placed.offset = offset;
        return placed;
      };
  MessageLayout layout;
  layout.fields = {place("x", FieldType::Float64, 1, 8),
                   place("y", FieldType::Float64, 1, 16),
                   place("z", FieldType::Float64, 1, 24),
                   place("intensity", FieldType::UInt8, 1, 0),
                   place("colour of all sides", FieldType::Int16, 130, 200)};
  layout.point_step = 4096;
  layout.row_padding = 65536;
  MessageLayout of_points_without_fields;
  of_points_without_fields.point_step = 1;
  for (unsigned int i = 0; i < 14; ++i) {
    stream.frames.push_back({frames.next(10), std::nullopt});
    if (i != 2 && i < 11)
      stream.frames.back().frame.layout =
          std::make_shared<MessageLayout>(i < 8 ? layout : of_points_without_fields);
  }
  return stream;
}

/** \brief Frames of changes, and others among them. */
inline GoldenStream
goldenChanges(const std::string& name, Effort effort, const ChangingFrames& first)
{
  GoldenStream stream{name, effort, 30, {}};
  ChangingFrames frames = first;
  for (unsigned int i = 0; i < 34; ++i) {
    const bool is_quiet = i == 5 || (i > 11 && i < 24);
    const bool changes_much = i == 1 || i == 27;
    const unsigned int changes = changes_much ? 3000 : is_quiet ? 1 : 10 + 5 * (i % 7);
    stream.frames.push_back({frames.next(changes), std::nullopt});
  }
  return stream;
}

/** \brief Frames of changes after an I-frame with a refinement, and a P-frame with one
 * among them. */
inline GoldenStream
goldenFineChanges(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 6, {}};
  ChangingFrames frames(8, false, true);
  for (unsigned int i = 0; i < 12; ++i)
    stream.frames.push_back({frames.next(i == 7 ? 6000 : 10 * (i % 3)), std::nullopt});
  return stream;
}

/** \brief A rough wall that jumps, so that frames do without the history, keep it and at
 * last replace it, until it rests; then one without depth model and numbers of points. */
inline GoldenStream
goldenMovedWall(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 40, {}};
  std::mt19937_64 random(61);
  const DepthModel model = roomDepthModel(6, 8, 1);
  constexpr std::uint32_t rest = 18;
  for (std::uint32_t i = 0; i < rest + 10; ++i) {
    const bool is_plain = i >= rest + 4;
    // The history of many voxels costs a frame of few of them most.
    const bool is_large = effort != Effort::Fast && i < 5 && i % 2 == 0;
    const std::uint32_t width = is_large ? 40 : 17;
    std::mt19937_64 roughness(!is_plain && i > rest ? rest : i);
    std::set<std::uint64_t> keys;
    for (std::uint32_t y = 0; y < width; ++y)
      for (std::uint32_t z = 0; z < width; ++z) {
        const auto rough_x = static_cast<std::uint32_t>(below(roughness, 60));
        if (below(random, 30) > 0)
          keys.insert(mortonKey({rough_x, 11 + y, 12 + z}));
      }
    VoxelFrame frame = emptyFrame(6);
    setVoxels(random, keys, frame);
    if (!is_plain) {
      frame.depth_model = model;
      for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
        frame.intensities[voxel] = static_cast<std::uint16_t>(
            model.pointSymbol(voxelPosition(frame.keys[voxel])) >> 15);
      addPointCounts(random, frame);
    }
    stream.frames.push_back({frame, std::nullopt});
  }
  return stream;
}

/** \brief All golden streams; each name is a file's. */
inline std::vector<GoldenStream>
goldenStreams()
{
  std::vector<GoldenStream> streams;
  const std::pair<Effort, const char*> efforts[] = {{Effort::Fast, "fast_"},
                                                    {Effort::Balanced, "balanced_"},
                                                    {Effort::Small, "small_"}};
  for (const auto& [effort, prefix] : efforts) {
    RoomStream::Settings settings;
    settings.depth = 7;
    settings.width = 20;
    settings.noise = 5;
    streams.push_back(
        goldenRoom(std::string(prefix) + "counts", effort, settings, true));
    GoldenStream companded =
        goldenRoom(std::string(prefix) + "companded", effort, settings, false);
    for (GoldenFrame& frame : companded.frames)
      frame.frame.intensity_scale.companded_range = 1000;
    streams.push_back(companded);
    settings.bits = 16;
    settings.depth_model = roomDepthModel(settings.depth, settings.bits, 1);
    streams.push_back(
        goldenRoom(std::string(prefix) + "linear_16_bits", effort, settings, false));
    settings.bits = 8;
    settings.depth_model = roomDepthModel(settings.depth, settings.bits, 2);
    streams.push_back(
        goldenRoom(std::string(prefix) + "quadratic_8_bits", effort, settings, true));
    GoldenStream moving =
        goldenRoom(std::string(prefix) + "moving_sensor", effort, settings, false);
    for (std::size_t i = 0; i < moving.frames.size(); ++i)
      moving.frames[i].frame.depth_model->origin +=
          1000000 * static_cast<std::int64_t>(i);
    streams.push_back(moving);
    streams.push_back(goldenWalks(std::string(prefix) + "walks", effort));
    streams.push_back(goldenNoise(std::string(prefix) + "noise", effort));
    streams.push_back(goldenLargeRoom(std::string(prefix) + "large_room", effort));
    streams.push_back(goldenDense(std::string(prefix) + "dense", effort));
    streams.push_back(goldenLargeRests(std::string(prefix) + "large_rests", effort));
    streams.push_back(goldenColours(std::string(prefix) + "colours", effort));
    streams.push_back(goldenFineVoxels(std::string(prefix) + "fine_voxels", effort));
    streams.push_back(goldenJumps(std::string(prefix) + "jumps", effort));
    streams.push_back(goldenFlicker(std::string(prefix) + "flicker", effort));
    streams.push_back(goldenDepthLimits(std::string(prefix) + "depth_limits", effort));
    streams.push_back(
        goldenLargeResiduals(std::string(prefix) + "large_residuals", effort));
    streams.push_back(goldenScales(std::string(prefix) + "scales", effort));
    streams.push_back(goldenFewCells(std::string(prefix) + "few_cells", effort));
    streams.push_back(goldenMovedWall(std::string(prefix) + "moved_wall", effort));
    streams.push_back(goldenFields(std::string(prefix) + "fields", effort));
  }
  // What one effort has, or all have in common.
  streams.push_back(goldenSpread("fast_spread", Effort::Fast));
  streams.push_back(goldenScans("fast_scans", Effort::Fast));
  streams.push_back(goldenMovingScans("balanced_scans", Effort::Balanced));
  streams.push_back(goldenFreeScans("small_scans", Effort::Small));
  streams.push_back(goldenOctants("fast_octants", Effort::Fast));
  streams.push_back(goldenStill("small_still", Effort::Small));
  streams.push_back(goldenChanges("fast_changes", Effort::Fast, ChangingFrames(8)));
  streams.push_back(
      goldenChanges("balanced_changes", Effort::Balanced, ChangingFrames(16, true)));
  streams.push_back(goldenChanges("small_changes", Effort::Small, ChangingFrames(0)));
  streams.push_back(goldenFineChanges("small_fine_changes", Effort::Small));
  streams.push_back(goldenLayouts("fast_layouts", Effort::Fast));
  streams.push_back(goldenDisorder("disorder"));
  return streams;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
