// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/forged_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(FrameStreams, GarbageIsSkippedAndCounted)
{
  std::mt19937_64 random(4);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    FrameDecoder decoder;
    VoxelFrame back;
    Bytes stream;
    std::vector<VoxelFrame> frames;
    // Parts of the magic words, also right in front of a frame.
    const std::vector<std::string> garbage{
        "", "x", "PCX", "<HEA", "PPCXPCX", "<<HEAD<HEAD", std::string(300, '\0')};
    for (const std::string& text : garbage) {
      frames.push_back(randomFrame(random, 4, 20));
      stream.insert(stream.end(), text.begin(), text.end());
      append(encoded(encoder, frames.back()), stream);
    }
    stream.push_back('P');
    std::stringbuf buffer = bufferOf(stream);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      ASSERT_TRUE(decoder.decode(buffer, back).ok());
      expectSameVoxels(back, frames[i]);
      EXPECT_EQ(decoder.statistics().skipped_bytes, garbage[i].size());
    }
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::NoFrame);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::EndOfStream);
  }
}

TEST(FrameStreams, AFrameWithoutItsReferenceIsConsumed)
{
  std::mt19937_64 random(41);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const EncodedFrames sent =
        encodedWalk(encoder, random, randomFrame(random, 5, 100), 4, 20);
    Bytes stream;
    for (std::size_t i = 1; i < 4; ++i) // the first I-frame is lost
      append(sent.bytes[i], stream);
    std::stringbuf buffer = bufferOf(stream);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::MissingReference);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::MissingReference);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().skipped_bytes, 0u);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::EndOfStream);
  }
}

TEST(FrameStreams, ADamagedSizeBehindALossHidesNoIFrame)
{
  std::mt19937_64 random(42);
  for (const Effort effort : all_efforts) {
    FrameEncoder encoder(StreamFormat::Version1, 3, effort);
    EncodedFrames sent =
        encodedWalk(encoder, random, randomFrame(random, 5, 100), 5, 20);
    // Its payload seems to reach into the I-frame after it.
    sent.bytes[2].resize(sent.bytes[2].size() - 20);
    Bytes stream;
    for (const std::size_t i : {0u, 2u, 3u, 4u}) // 1 is lost
      append(sent.bytes[i], stream);
    std::stringbuf buffer = bufferOf(stream);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::Ok);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::MissingReference);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::Ok);
    EXPECT_TRUE(decoder.statistics().is_i_frame);
    EXPECT_EQ(decoder.statistics().frame_number, 4u);
    EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::Ok);
  }
}

TEST(FrameStreams, AGoodIFrameBehindADamagedOneIsFound)
{
  std::mt19937_64 random(43);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const EncodedFrames sent =
        encodedWalk(encoder, random, randomFrame(random, 4, 40), 2, 10);
    for (std::size_t bit = 0; bit < 8 * sent.bytes[0].size(); bit += 3) {
      Bytes bytes = flipped(sent.bytes[0], bit);
      append(sent.bytes[0], bytes);
      append(sent.bytes[1], bytes);
      std::stringbuf buffer = bufferOf(bytes);
      FrameDecoder decoder;
      VoxelFrame back;
      std::vector<VoxelFrame> frames;
      CompressionCode code = CompressionCode::Ok;
      for (int i = 0; i < 8 && code != CompressionCode::EndOfStream &&
                      code != CompressionCode::NoFrame;
           ++i) {
        code = decoder.decode(buffer, back).code();
        if (code == CompressionCode::Ok)
          frames.push_back(back);
      }
      ASSERT_GE(frames.size(), 2u) << "bit " << bit;
      expectSameVoxels(frames[frames.size() - 2], sent.frames[0]);
      expectSameVoxels(frames[frames.size() - 1], sent.frames[1]);
    }
  }
}

TEST(FrameStreams, BothFormatsShareAStream)
{
  std::mt19937_64 random(5);
  FrameEncoder version1(StreamFormat::Version1, 4, Effort::Balanced);
  FrameEncoder published(StreamFormat::Published, 3);
  FrameDecoder decoder;
  VoxelFrame back;
  VoxelFrame frame = randomFrame(random, 5, 100);
  for (int i = 0; i < 20; ++i) {
    FrameEncoder& encoder = below(random, 2) == 0 ? version1 : published;
    ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
    expectSameVoxels(back, frame);
    walk(random, 20, frame);
  }
}

// ---------------------------------------------------------------- loss

TEST(FrameStreams, ALostFrameAffectsOnlyThePFramesBehindIt)
{
  constexpr unsigned int rate = 5;
  std::mt19937_64 random(6);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, rate, Effort::Balanced);
    const auto [frames, stream] =
        encodedWalk(encoder, random, randomFrame(random, 5, 100), 12, 20);
    for (std::size_t lost = 0; lost < stream.size(); ++lost) {
      FrameDecoder decoder;
      VoxelFrame back;
      for (std::size_t i = 0; i < stream.size(); ++i) {
        if (i == lost)
          continue;
        const bool is_behind = i > lost && i / rate == lost / rate;
        ASSERT_EQ(decoded(decoder, stream[i], back),
                  is_behind ? CompressionCode::MissingReference : CompressionCode::Ok);
        if (!is_behind) {
          expectSameVoxels(back, frames[i]);
        }
      }
    }
    for (std::size_t lost = 0; lost + 1 < stream.size(); ++lost) { // and sent again
      if (lost % rate == rate - 1)
        continue;
      FrameDecoder decoder;
      VoxelFrame back;
      for (std::size_t i = 0; i < lost; ++i)
        ASSERT_EQ(decoded(decoder, stream[i], back), CompressionCode::Ok);
      EXPECT_EQ(decoded(decoder, stream[lost + 1], back),
                CompressionCode::MissingReference);
      for (std::size_t i = lost; i < stream.size(); ++i) {
        ASSERT_EQ(decoded(decoder, stream[i], back), CompressionCode::Ok);
        expectSameVoxels(back, frames[i]);
      }
    }
  }
}

TEST(FrameStreams, AReceiverMayJoinAtAnEmptyIFrame)
{
  // Also an I-frame without voxels forgets all that was learnt before.
  std::mt19937_64 random(61);
  for (const Effort effort : all_efforts)
    for (const bool has_depth_model : {false, true}) {
      FrameEncoder encoder(StreamFormat::Version1, 100, effort);
      VoxelFrame frame = randomFrame(random, 5, 2000);
      VoxelFrame empty = emptyFrame(5);
      if (has_depth_model) {
        frame.depth_model.emplace();
        frame.depth_model->full_symbol = 1 << 16;
        frame.depth_model->origin = std::int64_t{1} << 31;
        empty.depth_model = frame.depth_model;
      }
      for (int i = 0; i < 5; ++i) {
        encoded(encoder, frame);
        walk(random, 20, frame);
      }
      FrameDecoder late;
      VoxelFrame back;
      encoder.requestIFrame();
      ASSERT_EQ(decoded(late, encoded(encoder, empty), back), CompressionCode::Ok);
      EXPECT_TRUE(back.keys.empty());
      for (int i = 0; i < 3; ++i) {
        // Fewer than 64 voxels do not make an I-frame by themselves.
        frame.keys.resize(60);
        frame.intensities.resize(60);
        ASSERT_EQ(decoded(late, encoded(encoder, frame), back), CompressionCode::Ok);
        EXPECT_FALSE(encoder.statistics().is_i_frame);
        expectSameFrame(back, frame);
      }
    }
}

TEST(FrameStreams, APFrameOfAnotherStreamIsRefused)
{
  std::mt19937_64 random(7);
  FrameEncoder one(StreamFormat::Version1, 10, Effort::Balanced);
  FrameEncoder other(StreamFormat::Version1, 10, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  VoxelFrame frame = randomFrame(random, 5, 100);
  encoded(other, frame);
  walk(random, 20, frame); // the same voxels except for some, so that P-frames follow
  ASSERT_EQ(decoded(decoder, encoded(one, frame), back), CompressionCode::Ok);
  const Bytes of_other = encoded(other, frame);
  ASSERT_FALSE(other.statistics().is_i_frame);
  const CompressionStatus status =
      decoder.decode(of_other.data(), of_other.size(), back);
  EXPECT_EQ(status.code(), CompressionCode::Corrupt);
  EXPECT_NE(status.message().find("belongs to another stream"), std::string::npos);
  EXPECT_EQ(decoded(decoder, encoded(one, frame), back), CompressionCode::Ok);
  expectSameFrame(back, frame);
  encoded(other, frame);
  const Bytes later = encoded(other, frame);
  const CompressionStatus gap = decoder.decode(later.data(), later.size(), back);
  EXPECT_EQ(gap.code(), CompressionCode::MissingReference);
  EXPECT_NE(gap.message().find("belongs to another stream"), std::string::npos);
}

// ---------------------------------------------------------------- cloud headers

TEST(FrameStreams, StampsAreCarried)
{
  std::mt19937_64 random(8);
  FrameEncoder encoder(StreamFormat::Version1, 4, Effort::Balanced);
  FrameEncoder plain(StreamFormat::Version1, 4, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  const std::string longest(1024, 'x');
  const std::vector<std::string> names{
      "map", "map", "lidar", "lidar", "lidar", "", "", "a", longest, longest};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const VoxelFrame frame = randomFrame(random, 4, 30);
    const FrameStamp stamp{std::uint64_t{0xfedcba9876543210} + 100 * i, names[i]};
    const Bytes bytes = encoded(encoder, frame, stamp);
    const std::size_t plain_size = encoded(plain, frame).size();
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    ASSERT_TRUE(decoder.stamp().has_value());
    EXPECT_EQ(decoder.stamp()->stamp, stamp.stamp);
    EXPECT_EQ(decoder.stamp()->frame_id, names[i]);
    const bool is_i_frame = i % 4 == 0;
    ASSERT_EQ(encoder.statistics().is_i_frame, is_i_frame);
    const bool is_sent = is_i_frame || names[i] != names[i - 1];
    const std::size_t name_size = names[i].size() + (names[i].size() < 128 ? 1 : 2);
    // A stamp is whole on I-frames, a change on P-frames; 100 is a varint of two bytes.
    const std::size_t stamp_size = is_i_frame ? 8 : 2;
    EXPECT_EQ(bytes.size(), plain_size + stamp_size + (is_sent ? name_size : 0)) << i;
  }
}

TEST(FrameStreams, StampsMayBeAnywhere)
{
  // Differences of unsigned stamps, which wrap round; those that a P-frame's header has
  // no room for make an I-frame.
  constexpr std::uint64_t far = std::uint64_t{1} << 27;
  constexpr std::uint64_t half = std::uint64_t{1} << 63;
  constexpr std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  std::mt19937_64 random(81);
  const VoxelFrame frame = randomFrame(random, 4, 30);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  std::uint64_t before = 0;
  std::size_t i_frames = 0;
  for (const std::uint64_t stamp : {std::uint64_t{7},
                                    std::uint64_t{0},
                                    last,
                                    std::uint64_t{0},
                                    half,
                                    half - 1,
                                    std::uint64_t{5},
                                    half + 5,
                                    half + 5,
                                    last,
                                    half - 1,
                                    std::uint64_t{1}}) {
    const Bytes bytes = encoded(encoder, frame, FrameStamp{stamp, "a"});
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    ASSERT_TRUE(decoder.stamp().has_value());
    EXPECT_EQ(decoder.stamp()->stamp, stamp);
    EXPECT_EQ(decoder.statistics().is_i_frame,
              decoder.statistics().frame_number == 1 ||
                  (stamp - before >= far && before - stamp > far));
    i_frames += decoder.statistics().is_i_frame ? 1 : 0;
    before = stamp;
  }
  EXPECT_EQ(i_frames, 7u);
}

TEST(FrameStreams, StampsMayComeAndGo)
{
  const std::optional<FrameStamp> stamps[] = {FrameStamp{1, "map"},
                                              std::nullopt,
                                              FrameStamp{2, "map"},
                                              FrameStamp{3, "odom"},
                                              std::nullopt,
                                              FrameStamp{4, "odom"},
                                              FrameStamp{5, "map"}};
  for (unsigned int rate = 1; rate < 7; ++rate) {
    FrameEncoder encoder(StreamFormat::Version1, rate, Effort::Balanced);
    FrameDecoder decoder;
    VoxelFrame back;
    for (const std::optional<FrameStamp>& stamp : stamps) {
      ASSERT_EQ(decoded(decoder, encoded(encoder, emptyFrame(4), stamp), back),
                CompressionCode::Ok);
      ASSERT_EQ(decoder.stamp().has_value(), stamp.has_value());
      EXPECT_EQ(decoder.stamp().value_or(FrameStamp()).stamp,
                stamp.value_or(FrameStamp()).stamp);
      EXPECT_EQ(decoder.stamp().value_or(FrameStamp()).frame_id,
                stamp.value_or(FrameStamp()).frame_id)
          << "an I-frame every " << rate << " frames";
    }
  }
}

// ---------------------------------------------------------------- frame headers

TEST(FrameHeader, DepthModelsComeAndGoWithIFramesOnly)
{
  VoxelFrame frame = emptyFrame(4);
  FrameEncoder encoder(StreamFormat::Version1, 9, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  std::string kinds;
  for (const std::uint32_t full_symbol : {1u, 1u, 2u, 0u, 3u}) {
    frame.depth_model.reset();
    if (full_symbol > 0)
      frame.depth_model.emplace().full_symbol = full_symbol;
    ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
    EXPECT_TRUE(back.depth_model == frame.depth_model);
    kinds += encoder.statistics().is_i_frame ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPPII");
}

TEST(FrameHeader, AnIFrameWithoutFrameIdClearsIt)
{
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  const Bytes named = encoded(encoder, emptyFrame(4), FrameStamp{5, "sensor"});
  Parts parts = takeApart(encoded(encoder, emptyFrame(4), FrameStamp{6, "sensor"}));
  parts.header.has_frame_id = false;
  FrameDecoder decoder;
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, named, back), CompressionCode::Ok);
  EXPECT_EQ(decoder.stamp()->frame_id, "sensor");
  ASSERT_EQ(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
  EXPECT_EQ(decoder.stamp()->frame_id, "");
  EXPECT_EQ(decoder.stamp()->stamp, 6u);
}

TEST(FrameHeader, HeadersAreShortWithAllFields)
{
  std::mt19937_64 random(10);
  for (const std::size_t count : {0u, 1u, 50u, 20000u}) {
    FrameEncoder encoder(StreamFormat::Version1, 10);
    VoxelFrame frame = randomFrame(random, 21, count, 16);
    frame.depth_model.emplace();
    FrameStamp stamp{1700000000000000, std::string(16, 'x')};
    encoded(encoder, frame, stamp);
    EXPECT_LE(encoder.statistics().header_bytes, 96u) << count;
    // 20 Hz and 1 Hz in microseconds, two minutes of nothing, and a minute back.
    for (const std::int64_t change : {50000, 1000000, 120000000, -60000000}) {
      stamp.stamp += static_cast<std::uint64_t>(change);
      encoded(encoder, frame, stamp);
      EXPECT_FALSE(encoder.statistics().is_i_frame);
      EXPECT_LE(encoder.statistics().header_bytes, 24u) << count << ", " << change;
    }
  }
}

} // namespace
