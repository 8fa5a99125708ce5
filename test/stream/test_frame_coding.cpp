// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>

#include "stream/frame_encoder.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using Change = std::function<void(VoxelFrame&)>;

/** \brief A decoder's grid counts from its lower corner in the published layout. */
void
expectSamePlaces(const VoxelFrame& frame, const VoxelFrame& expected)
{
  expectSameVoxels(frame, expected);
  EXPECT_EQ(frame.grid.depth, expected.grid.depth);
  EXPECT_EQ(frame.grid.resolution, expected.grid.resolution);
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(frame.grid.centre(axis, 3), expected.grid.centre(axis, 3), 1e-9);
}

TEST(FrameCoding, IFramesComeEveryNthFrameAndOnRequest)
{
  std::mt19937_64 random(2);
  const VoxelFrame frame = randomFrame(random, 4, 20);
  for (const StreamFormat format : all_formats)
    for (const unsigned int rate : {0u, 1u, 2u, 3u, 7u, 4000000000u}) {
      FrameEncoder encoder(format, rate, Effort::Balanced);
      const unsigned int period = std::max(rate, 1u);
      unsigned int begin = 0; // of the period, which a request begins anew
      for (unsigned int number = 0; number < 22; ++number) {
        if (number == 11) {
          encoder.requestIFrame();
          begin = number;
        }
        const bool is_i_frame = (number - begin) % period == 0;
        EXPECT_EQ(encoder.isIFrameDue(), is_i_frame);
        encoded(encoder, frame);
        EXPECT_EQ(encoder.statistics().is_i_frame, is_i_frame);
        EXPECT_EQ(encoder.statistics().frame_number, number + 1);
      }
    }
}

TEST(FrameCoding, AnotherGridOrScaleMakesAnIFrame)
{
  const std::vector<Change> grids = {
      [](VoxelFrame& frame) { frame.grid.first_index[1] += 1; },
      [](VoxelFrame& frame) { frame.grid.resolution *= 1.5; },
      [](VoxelFrame& frame) { frame.grid.depth = 5; }};
  const std::vector<Change> scales = {
      [](VoxelFrame& frame) { frame.intensity_scale.bits = 15; },
      [](VoxelFrame& frame) { frame.intensity_scale.step = 1.0f / 3.0f; },
      [](VoxelFrame& frame) { frame.intensity_scale.offset = -0.25f; },
      [](VoxelFrame& frame) { frame.intensity_scale.companded_range = 0x8000; }};
  std::mt19937_64 random(1);
  for (const StreamFormat format : all_formats) {
    std::vector<Change> changes = grids;
    if (format == StreamFormat::Version1)
      changes.insert(changes.end(), scales.begin(), scales.end());
    FrameEncoder encoder(format, 100, Effort::Balanced);
    FrameDecoder decoder;
    VoxelFrame frame = randomFrame(random, 4, 20);
    const auto expectFrame = [&](bool is_i_frame) {
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
      expectSamePlaces(back, frame);
      EXPECT_EQ(encoder.statistics().is_i_frame, is_i_frame);
      EXPECT_EQ(decoder.statistics().is_i_frame, is_i_frame);
    };
    expectFrame(true);
    for (std::size_t i = 0; i < changes.size(); ++i) {
      SCOPED_TRACE(i);
      expectFrame(false);
      changes[i](frame);
      expectFrame(true);
    }
    expectFrame(false);
  }
}

// ---------------------------------------------------------------- invalid input

TEST(FrameCoding, InvalidFramesAreRefusedAndTheStreamGoesOn)
{
  constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Change> of_voxels = {
      [](VoxelFrame& f) { std::swap(f.keys[3], f.keys[4]); },
      [](VoxelFrame& f) { f.keys[4] = f.keys[3]; },
      [](VoxelFrame& f) { f.keys.back() = 1u << 12; },
      [](VoxelFrame& f) {
        f.intensity_scale.bits = 4;
        f.intensities[5] = 16;
      },
      [](VoxelFrame& f) { f.intensities.pop_back(); },
      [](VoxelFrame& f) { f.keys.clear(); }};
  const std::vector<Change> of_all = {
      [](VoxelFrame& f) { f.grid.depth = 0; },
      [](VoxelFrame& f) { f.grid.depth = 22; },
      [](VoxelFrame& f) { f.grid.resolution = 0.0; },
      [=](VoxelFrame& f) { f.grid.resolution = not_a_number; },
      [=](VoxelFrame& f) { f.grid.origin[2] = not_a_number; },
      [](VoxelFrame& f) { f.intensity_scale.step = 0.0f; },
      [=](VoxelFrame& f) {
        f.intensity_scale.offset = static_cast<float>(not_a_number);
      },
      [](VoxelFrame& f) { f.intensity_scale.bits = 17; },
      [](VoxelFrame& f) { f.intensity_scale.companded_range = 255; },
      [](VoxelFrame& f) { f.intensity_scale.companded_range = 65536; },
      [](VoxelFrame& f) {
        f.intensity_scale = {0.0f, 1.0f, 16, 65535};
      }};
  const std::vector<Change> of_version1 = {
      [](VoxelFrame& f) { f.grid.first_index[0] = (1 << 20) - 15; },
      [](VoxelFrame& f) { f.grid.first_index[2] = -(1 << 20) - 1; },
      [](VoxelFrame& f) { f.grid.origin[0] = 1e13; }};
  const std::vector<Change> of_published = {
      [](VoxelFrame& f) { f.intensity_scale.bits = 16; },
      [](VoxelFrame& f) { f.intensity_scale.step = 2.0f; },
      [](VoxelFrame& f) { f.intensity_scale.companded_range = 256; }};
  std::mt19937_64 random(12);
  for (const StreamFormat format : all_formats) {
    const VoxelFrame good = randomFrame(random, 4, 30);
    std::vector<VoxelFrame> bad;
    const auto add = [&](const std::vector<Change>& changes, bool has_voxels) {
      for (const Change& change : changes) {
        bad.push_back(good);
        change(bad.back());
        if (!has_voxels)
          bad.back().clearVoxels();
      }
    };
    add(of_voxels, true);
    for (const bool has_voxels : {true, false}) {
      add(of_all, has_voxels);
      add(format == StreamFormat::Version1 ? of_version1 : of_published, has_voxels);
    }
    FrameEncoder encoder(format, 10, Effort::Balanced);
    FrameDecoder decoder;
    VoxelFrame back;
    for (std::size_t i = 0; i < bad.size(); ++i) {
      Bytes bytes{1, 2, 3};
      EXPECT_EQ(encoder.encode(bad[i], std::nullopt, bytes).code(),
                CompressionCode::InvalidInput)
          << i;
      EXPECT_TRUE(bytes.empty());
      ASSERT_EQ(decoded(decoder, encoded(encoder, good), back), CompressionCode::Ok);
      expectSameVoxels(back, good);
      EXPECT_EQ(decoder.statistics().frame_number, i + 1);
      EXPECT_EQ(decoder.statistics().is_i_frame, i % 10 == 0);
    }
    Bytes bytes;
    const FrameStamp stamp{
        1, std::string(format == StreamFormat::Version1 ? 1025 : 1, 'x')};
    EXPECT_EQ(encoder.encode(good, stamp, bytes).code(), CompressionCode::InvalidInput);
  }
}

TEST(FrameCoding, FramesOfInconsistentContentsAreRefused)
{
  std::mt19937_64 random(7);
  VoxelFrame good = randomFrame(random, 4, 10);
  addColours(random, 4, good);
  addPointCounts(random, good);
  addFields(random, good);
  VoxelFrame modelled = good;
  modelled.depth_model = roomDepthModel(4, 8);
  EXPECT_TRUE(isConsistent(modelled));
  const std::vector<Change> changes = {
      [](VoxelFrame& f) { f.colours.pop_back(); },
      [](VoxelFrame& f) { f.colours[3].g = 16; },
      [](VoxelFrame& f) { f.colour_bits = 0; },
      [](VoxelFrame& f) { f.colour_bits = 9; },
      [](VoxelFrame& f) { f.colour_bits = 255; },
      [](VoxelFrame& f) { f.colour_bits = 264; }, // 8 in a byte
      [](VoxelFrame& f) { f.point_counts[0] = 0; },
      [](VoxelFrame& f) { f.point_counts.clear(); },
      [](VoxelFrame& f) { f.intensity_scale.bits = 0; },
      [](VoxelFrame& f) { f.intensities.clear(); },
      [](VoxelFrame& f) { f.fields[0].numbers.pop_back(); },
      [](VoxelFrame& f) { f.fields[0].name.clear(); },
      [](VoxelFrame& f) { f.fields[0].name.assign(65, 'a'); },
      [](VoxelFrame& f) { f.fields[0].type = FieldType(9); },
      [](VoxelFrame& f) { f.fields[0].step = -1.0; },
      [](VoxelFrame& f) { f.viewpoint[1] = (1 << 22) + 1; },
      [](VoxelFrame& f) { f.fields.resize(65, f.fields[0]); },
      [](VoxelFrame& f) {
        removeIntensities(f);
        f.depth_model = roomDepthModel(4, 8);
      }};
  FrameEncoder encoder(StreamFormat::Version1, 30);
  encoded(encoder, good);
  Bytes bytes;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    VoxelFrame frame = good;
    changes[i](frame);
    EXPECT_FALSE(isConsistent(frame)) << i;
    EXPECT_EQ(encoder.encode(frame, std::nullopt, bytes).code(),
              CompressionCode::InvalidInput)
        << i;
  }
  FrameEncoder published(StreamFormat::Published, 30);
  EXPECT_EQ(published.encode(good, std::nullopt, bytes).code(),
            CompressionCode::InvalidInput);
}

/** \brief Random frames with fields of all kinds of numbers. */
VoxelFrame
frameWithFields(std::mt19937_64& random, bool has_point_counts)
{
  VoxelFrame frame = emptyFrame(5);
  frame.intensity_scale.bits = 0;
  frame.has_point_counts = has_point_counts;
  std::set<std::uint64_t> keys;
  for (std::uint64_t i = below(random, 400); i > 0; --i)
    keys.insert(below(random, 1 << 15));
  frame.keys.assign(keys.begin(), keys.end());
  for (std::size_t i = 0; has_point_counts && i < keys.size(); ++i)
    frame.point_counts.push_back(static_cast<std::uint32_t>(1 + below(random, 3)));
  const auto add =
      [&](const char* name, FieldType type, std::uint32_t count, auto draw) {
        FrameField& field = frame.fields.emplace_back();
        field.name = name;
        field.type = type;
        field.count = count;
        for (std::size_t i = 0; i < frame.pointCount() * count; ++i)
          field.numbers.push_back(draw());
      };
  const std::uint64_t kinds = below(random, 3);
  add("wide", FieldType::Float64, 1, [&] { return random() >> below(random, 64); });
  add("few", FieldType::UInt32, 1, [&] {
    return kinds == 0 ? random() >> 32 : 123456789 * below(random, 2 + kinds);
  });
  add("one", FieldType::Int8, 1, [&] { return kinds; });
  add("tuple", FieldType::Float32, 5, [&] { return random() >> 40; });
  frame.viewpoint = {static_cast<std::int32_t>(below(random, 64)) - 16, 16, -(1 << 22)};
  return frame;
}

TEST(FieldsOfFrames, RandomNumbersComeBack)
{
  for (const Effort effort : all_efforts)
    for (const bool has_point_counts : {false, true}) {
      std::mt19937_64 random(5);
      FrameEncoder encoder(StreamFormat::Version1, 5, effort);
      FrameDecoder decoder;
      for (int i = 0; i < 40; ++i) {
        const VoxelFrame frame = frameWithFields(random, has_point_counts);
        Bytes bytes;
        ASSERT_TRUE(encoder.encode(frame, std::nullopt, bytes).ok());
        VoxelFrame decoded;
        ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
        EXPECT_EQ(decoded.keys, frame.keys);
        ASSERT_EQ(decoded.fields.size(), frame.fields.size());
        for (std::size_t k = 0; k < frame.fields.size(); ++k) {
          EXPECT_EQ(decoded.fields[k], frame.fields[k]);
          EXPECT_EQ(decoded.fields[k].numbers, frame.fields[k].numbers)
              << i << " " << k;
        }
      }
    }
}

TEST(FieldsOfFrames, AreGoneInFramesWithoutThem)
{
  std::mt19937_64 random(8);
  VoxelFrame frame = frameWithFields(random, false);
  for (const StreamFormat format : all_formats) {
    FrameDecoder decoder;
    VoxelFrame decoded;
    Bytes bytes;
    ASSERT_TRUE(FrameEncoder(StreamFormat::Version1, 1)
                    .encode(frame, std::nullopt, bytes)
                    .ok());
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
    ASSERT_FALSE(decoded.fields.empty());
    VoxelFrame without = emptyFrame(5);
    without.keys = {1, 2};
    without.intensities = {1, 2};
    ASSERT_TRUE(FrameEncoder(format, 1).encode(without, std::nullopt, bytes).ok());
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
    EXPECT_EQ(decoded.size(), 2u);
    EXPECT_TRUE(decoded.fields.empty() && isConsistent(decoded));
  }
}

TEST(FieldsOfFrames, OthersTakeAnIFrame)
{
  std::mt19937_64 random(6);
  VoxelFrame frame = frameWithFields(random, true);
  FrameEncoder encoder(StreamFormat::Version1, 30, Effort::Fast);
  const auto is_i_frame = [&] {
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(frame, std::nullopt, bytes).ok());
    return encoder.statistics().is_i_frame;
  };
  EXPECT_TRUE(is_i_frame());
  EXPECT_FALSE(is_i_frame());
  frame.fields[0].step = 0.5;
  EXPECT_TRUE(is_i_frame());
  frame.fields[1].name = "other";
  EXPECT_TRUE(is_i_frame());
  frame.fields.pop_back();
  EXPECT_TRUE(is_i_frame());
  EXPECT_FALSE(is_i_frame());
}

} // namespace
