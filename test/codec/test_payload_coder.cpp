// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/payload_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

class Ends {
public:
  Ends(Effort effort, CodingWorkspace& work) : effort_(effort), work_(work) {}

  Bytes
  encode(const VoxelFrame& frame, bool is_i_frame)
  {
    Bytes payload;
    sizes_ = encodePayload(encoder_.of(effort_), work_, frame, is_i_frame, payload);
    EXPECT_EQ(sizes_.occupancy + sizes_.intensity, payload.size());
    return payload;
  }

  bool
  decode(const Bytes& payload,
         const VoxelFrame& expected,
         bool is_i_frame,
         VoxelFrame& back)
  {
    return decode(payload, expected, expected.size(), is_i_frame, back);
  }

  bool
  decode(const Bytes& payload,
         const VoxelFrame& like,
         std::size_t voxel_count,
         bool is_i_frame,
         VoxelFrame& back)
  {
    PayloadCoder& coder = decoder_.of(effort_);
    const bool is_good = decodePayload(
        coder, work_, payload, like, voxel_count, is_i_frame, back, decoded_sizes_);
    if (is_good)
      coder.learn();
    return is_good;
  }

  void
  expectRoundTrip(const VoxelFrame& frame, bool is_i_frame)
  {
    const Bytes payload = encode(frame, is_i_frame);
    VoxelFrame back;
    ASSERT_TRUE(decode(payload, frame, is_i_frame, back));
    expectSameFrame(back, frame);
    EXPECT_EQ(decoded_sizes_.occupancy, sizes_.occupancy);
    EXPECT_EQ(decoder_.of(effort_).trackedVoxels(),
              encoder_.of(effort_).trackedVoxels());
    EXPECT_EQ(trackedVoxels(frame), frame.size());
  }

  std::size_t
  trackedVoxels(const VoxelFrame& frame)
  {
    return decoder_.of(effort_).match(work_, frame);
  }

private:
  Effort effort_;
  CodingWorkspace& work_;
  PayloadCoders encoder_;
  PayloadCoders decoder_;
  PayloadSizes sizes_;
  PayloadSizes decoded_sizes_;
};

class PayloadCoding : public testing::TestWithParam<Effort> {};

INSTANTIATE_TEST_SUITE_P(Efforts,
                         PayloadCoding,
                         testing::ValuesIn(all_efforts),
                         [](const auto& effort) { return nameOf(effort.param); });

/** \brief All voxels of a cube of some levels at the grid's lower corner. */
VoxelFrame
cube(std::mt19937_64& random,
     unsigned int depth,
     unsigned int levels,
     unsigned int bits)
{
  std::set<std::uint64_t> keys;
  for (std::uint64_t key = 0; key < std::uint64_t{1} << (3 * levels); ++key)
    keys.insert(key);
  VoxelFrame frame = emptyFrame(depth, bits);
  setVoxels(random, keys, frame);
  return frame;
}

/** \brief Frames at the limits of the coders, of one grid and scale. */
std::vector<VoxelFrame>
oddFrames(unsigned int depth, unsigned int bits)
{
  std::mt19937_64 random(depth * 100 + bits);
  const std::uint64_t cells = std::uint64_t{1} << std::min(3 * depth, 62u);
  const auto some = [&](std::uint64_t count) {
    return randomFrame(random, depth, std::min(count, cells), bits);
  };
  std::vector<VoxelFrame> frames{some(1), emptyFrame(depth, bits), some(1), some(2)};
  VoxelFrame last = emptyFrame(depth, bits); // the last voxel of the grid
  setVoxels(random, {(std::uint64_t{1} << (3 * depth)) - 1}, last);
  frames.push_back(last);
  for (unsigned int levels = 1; levels <= std::min(depth, bits == 8 ? 4u : 3u);
       ++levels)
    for (int i = 0; i < 2; ++i)
      frames.push_back(cube(random, depth, levels, bits));
  const std::size_t distinct = frames.size();
  frames.push_back(some(cells / 2 < 300 ? cells / 2 : 300));
  frames.push_back(emptyFrame(depth, bits));
  frames.push_back(emptyFrame(depth, bits));
  for (const bool is_highest : {false, true})
    for (int i = 0; i < 3; ++i) {
      VoxelFrame frame = some(100);
      const std::uint32_t symbol = is_highest ? frame.intensity_scale.maxSymbol() : 0;
      std::fill(frame.intensities.begin(),
                frame.intensities.end(),
                static_cast<std::uint16_t>(symbol));
      frames.push_back(frame);
      frame.intensities[0] = static_cast<std::uint16_t>(
          is_highest ? 0 : frame.intensity_scale.maxSymbol());
      frames.push_back(frame);
    }
  VoxelFrame wanderer = some(60);
  for (int i = 0; i < 12; ++i) {
    frames.push_back(wanderer);
    walk(random, 6, wanderer);
  }
  for (std::size_t i = 0; i < 20; ++i) // everything changes at once, back and forth
    frames.push_back(frames[i * 2 % (distinct - 2) + 2]);
  return frames;
}

TEST_P(PayloadCoding, OddFramesComeBack)
{
  CodingWorkspace work;
  for (const unsigned int depth : {1u, 2u, 3u, 5u, 13u, 21u})
    for (const unsigned int bits : {1u, 2u, 4u, 5u, 8u, 12u, 13u, 16u}) {
      // Each depth and each number of bits with both.
      const std::size_t rate = (depth / 2 + bits / 4) % 2 == 0 ? 5 : 1000;
      SCOPED_TRACE("depth " + std::to_string(depth) + ", " + std::to_string(bits) +
                   " bits, I-frames every " + std::to_string(rate));
      Ends ends(GetParam(), work);
      const std::vector<VoxelFrame> frames = oddFrames(depth, bits);
      for (std::size_t i = 0; i < frames.size(); ++i)
        ASSERT_NO_FATAL_FAILURE(ends.expectRoundTrip(frames[i], i % rate == 0)) << i;
    }
}

/** \brief A depth model with any of its numbers, among them the ends of their
 * ranges. */
DepthModel
anyDepthModel(std::mt19937_64& random)
{
  DepthModel model;
  model.exponent = static_cast<std::uint8_t>(1 + below(random, 2));
  const std::uint64_t size = below(random, 5);
  model.full_symbol =
      size == 0   ? 0
      : size == 1 ? (1u << 24) - 1
                  : static_cast<std::uint32_t>(
                        below(random, std::uint64_t{1} << (1 + below(random, 24))));
  constexpr std::int64_t farthest = std::int64_t{1} << 56;
  const std::uint64_t origin = below(random, 5);
  model.origin = origin == 0   ? farthest
                 : origin == 1 ? -farthest
                               : static_cast<std::int64_t>(below(random, 1ull << 33)) -
                                     (std::int64_t{1} << 30);
  for (std::int32_t& step : model.step) {
    const std::uint64_t slope = below(random, 5);
    step = slope == 0 ? std::numeric_limits<std::int32_t>::max()
           : slope == 1
               ? std::numeric_limits<std::int32_t>::min()
               : static_cast<std::int32_t>(below(random, 1u << 26)) - (1 << 25);
  }
  return model;
}

TEST_P(PayloadCoding, OddFramesComeBackWithADepthModel)
{
  CodingWorkspace work;
  for (const unsigned int depth : {1u, 2u, 3u, 9u, 21u})
    for (const unsigned int bits : {1u, 8u, 13u, 16u}) {
      SCOPED_TRACE("depth " + std::to_string(depth) + ", " + std::to_string(bits));
      Ends ends(GetParam(), work);
      std::mt19937_64 random(depth + bits);
      const std::vector<VoxelFrame> frames = oddFrames(depth, bits);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        VoxelFrame frame = frames[i];
        frame.depth_model =
            i % 3 == 0
                ? roomDepthModel(depth, bits, static_cast<std::uint8_t>(1 + i / 8 % 2))
                : anyDepthModel(random);
        ASSERT_NO_FATAL_FAILURE(ends.expectRoundTrip(frame, i % 20 == 0)) << i;
      }
    }
}

TEST_P(PayloadCoding, TrackedVoxelsAreCounted)
{
  CodingWorkspace work;
  PayloadCoders coders;
  PayloadCoder& coder = coders.of(GetParam());
  VoxelFrame frame = emptyFrame(4);
  frame.keys = {0, 1, 64, 200, 4095};
  frame.intensities.assign(5, 1);
  EXPECT_EQ(coder.match(work, frame), 0u);
  EXPECT_EQ(coder.trackedVoxels(), 0u);
  Bytes payload;
  encodePayload(coder, work, frame, true, payload);
  EXPECT_EQ(coder.match(work, frame), 5u);
  EXPECT_EQ(coder.trackedVoxels(), 5u);
  frame.keys = {1, 2, 65, 200, 4094};
  EXPECT_EQ(coder.match(work, frame), 2u);
  frame.keys.clear();
  EXPECT_EQ(coder.match(work, frame), 0u);
}

TEST_P(PayloadCoding, VoxelsThatStayAwayAreForgotten)
{
  CodingWorkspace work;
  std::mt19937_64 random(9);
  Ends ends(GetParam(), work);
  const VoxelFrame frame = randomFrame(random, 4, 300);
  ends.expectRoundTrip(frame, true);
  EXPECT_EQ(ends.trackedVoxels(frame), 300u);
  VoxelFrame single = emptyFrame(4);
  single.keys = {frame.keys[7]};
  single.intensities = {1};
  for (int i = 0; i < (GetParam() == Effort::Fast ? 6 : 60); ++i)
    ends.expectRoundTrip(single, false);
  EXPECT_EQ(ends.trackedVoxels(frame), 1u);
  EXPECT_EQ(ends.trackedVoxels(single), 1u);
}

TEST(PayloadCoder, EffortsShareNoState)
{
  CodingWorkspace work;
  // A new effort begins with an I-frame, and what the other one learnt is not in it.
  RoomStream room({});
  PayloadCoders encoder;
  const Effort order[] = {
      Effort::Balanced, Effort::Small, Effort::Fast, Effort::Small, Effort::Balanced};
  for (const Effort effort : order) {
    PayloadCoders fresh;
    for (int i = 0; i < 4; ++i) {
      const VoxelFrame frame = room.next();
      Bytes payload;
      encodePayload(encoder.of(effort), work, frame, i == 0, payload);
      ASSERT_NO_FATAL_FAILURE(
          expectDecoded(fresh.of(effort), work, payload, frame, i == 0));
      fresh.of(effort).learn();
    }
  }
}

} // namespace
