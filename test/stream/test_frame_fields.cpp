// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields of frames: whatever the numbers are, they come back.
 */
#include <pcl_ext/compression/frame_decoder.h>

#include "stream/frame_encoder.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

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

TEST(FieldsOfFrames, InconsistentOnesAreRefused)
{
  std::mt19937_64 random(7);
  const VoxelFrame valid = frameWithFields(random, true);
  const auto is_consistent = [&](auto change) {
    VoxelFrame frame = valid;
    change(frame);
    return isConsistent(frame);
  };
  EXPECT_TRUE(is_consistent([](VoxelFrame&) {}));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields[0].numbers.pop_back(); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields[0].name.clear(); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields[0].name.assign(65, 'a'); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields[0].type = FieldType(9); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields[0].step = -1.0; }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.viewpoint[1] = (1 << 22) + 1; }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.fields.resize(65, f.fields[0]); }));
}

} // namespace
