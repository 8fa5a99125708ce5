// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/frame_order.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <sstream>
#include <string>
#include <utility>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

EncodedFrames
sent(StreamFormat format,
     std::size_t count,
     unsigned int i_frame_rate,
     std::uint64_t seed = 1,
     std::uint32_t first_number = 1)
{
  std::mt19937_64 random(seed);
  FrameEncoder encoder(format, i_frame_rate, Effort::Balanced, first_number);
  return encodedWalk(encoder, random, randomFrame(random, 4, 40), count, 3);
}

/** \brief Decodes a frame, which must be this one if it is Ok. */
CompressionCode
received(FrameDecoder& decoder, const EncodedFrames& stream, std::size_t index)
{
  VoxelFrame back;
  const CompressionCode code = decoded(decoder, stream.bytes[index], back);
  if (code == CompressionCode::Ok)
    expectSameVoxels(back, stream.frames[index]);
  return code;
}

/** \brief Expects a code for each frame from the first one on and before the end. */
void
expectReceived(FrameDecoder& decoder,
               const EncodedFrames& stream,
               std::size_t first,
               std::size_t end,
               CompressionCode code = CompressionCode::Ok)
{
  for (std::size_t i = first; i < end; ++i)
    ASSERT_EQ(received(decoder, stream, i), code) << i;
}

class FrameOrders : public testing::TestWithParam<StreamFormat> {};

INSTANTIATE_TEST_SUITE_P(BothFormats,
                         FrameOrders,
                         testing::ValuesIn(all_formats),
                         [](const auto& format) { return nameOf(format.param); });

TEST_P(FrameOrders, CopiesAreDroppedAndCostNothing)
{
  const EncodedFrames stream = sent(GetParam(), 90, 10);
  for (std::size_t delay = 0; delay < 60; ++delay) {
    FrameDecoder decoder;
    for (std::size_t i = 0; i < stream.bytes.size(); ++i) {
      SCOPED_TRACE("frame " + std::to_string(i) + ", delay " + std::to_string(delay));
      ASSERT_EQ(received(decoder, stream, i), CompressionCode::Ok);
      if (i < delay)
        continue;
      // An I-frame right after itself may be that of a sender that begins again.
      const bool is_decoded_again = delay == 0 && i % 10 == 0;
      ASSERT_EQ(received(decoder, stream, i - delay),
                is_decoded_again ? CompressionCode::Ok : CompressionCode::OldFrame);
    }
  }
}

TEST_P(FrameOrders, SomeCopiesInARowCostNothing)
{
  const EncodedFrames stream = sent(GetParam(), 60, 10);
  FrameDecoder decoder;
  expectReceived(decoder, stream, 0, 40);
  // An I-frame among them.
  expectReceived(decoder, stream, 25, 33, CompressionCode::OldFrame);
  expectReceived(decoder, stream, 40, 60);
}

TEST_P(FrameOrders, ASenderThatBeginsAgainIsFollowedAtOnce)
{
  FrameDecoder decoder;
  expectReceived(decoder, sent(GetParam(), 50, 10), 0, 50);
  expectReceived(decoder, sent(GetParam(), 50, 10, 2), 0, 50);
}

TEST_P(FrameOrders, ASenderThatSendsTheSameAgainIsFollowedBehindManyCopies)
{
  const EncodedFrames stream = sent(GetParam(), 50, 10);
  FrameDecoder decoder;
  expectReceived(decoder, stream, 0, 50);
  expectReceived(decoder, stream, 0, 30, CompressionCode::OldFrame);
  expectReceived(decoder, stream, 30, 50);
}

TEST_P(FrameOrders, AFileIsReadAgainAndAgain)
{
  const EncodedFrames stream = sent(GetParam(), 25, 30);
  Bytes bytes;
  for (const Bytes& frame : stream.bytes)
    append(frame, bytes);
  std::stringbuf file = bufferOf(bytes);
  FrameDecoder decoder;
  VoxelFrame back;
  for (int pass = 0; pass < 3; ++pass) {
    for (const VoxelFrame& frame : stream.frames) {
      ASSERT_EQ(decoder.decode(file, back).code(), CompressionCode::Ok) << pass;
      expectSameVoxels(back, frame);
    }
    ASSERT_EQ(decoder.decode(file, back).code(), CompressionCode::EndOfStream);
    file.pubseekpos(0, std::ios_base::in);
  }
}

TEST_P(FrameOrders, ASenderThatBeginsAgainWithoutVoxelsIsFollowedAtOnce)
{
  // Its first frame is the same to the byte.
  FrameDecoder decoder;
  for (std::uint64_t seed = 1; seed < 4; ++seed) {
    std::mt19937_64 random(seed);
    FrameEncoder encoder(GetParam(), 30);
    VoxelFrame frame = emptyFrame(4);
    for (std::size_t i = 0; i < 20; ++i) {
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok)
          << i;
      expectSameVoxels(back, frame);
      frame = randomFrame(random, 4, 20);
    }
  }
}

TEST(FrameOrder, ASenderWhoseFirstFrameIsLostIsFollowedFromALaterIFrame)
{
  // From the third frame of I-frames alone, or from the second I-frame.
  for (const auto& [rate, followed_from] : {std::pair(1u, 3u), std::pair(10u, 10u)}) {
    const EncodedFrames second = sent(StreamFormat::Version1, 30, rate, 2);
    FrameDecoder decoder;
    expectReceived(decoder, sent(StreamFormat::Version1, 50, rate), 0, 50);
    expectReceived(decoder, second, 1, followed_from, CompressionCode::OldFrame);
    expectReceived(decoder, second, followed_from, 30);
  }
}

TEST(FrameOrder, AnEncoderThatGoesOnWithTheNumbersIsFollowedAtOnce)
{
  // Also if its clouds are those of the frames before, and after numbers that are
  // missing.
  FrameDecoder decoder;
  for (const std::uint32_t number : {1u, 31u, 65u}) {
    expectReceived(decoder, sent(StreamFormat::Version1, 30, 10, 1, number), 0, 30);
    EXPECT_EQ(decoder.statistics().frame_number, number + 29);
  }
}

TEST(FrameOrder, HalfOfAllNumbersAreAboveTheLastOne)
{
  constexpr std::uint32_t half = std::uint32_t{1} << 31;
  for (const std::uint32_t last : {5u, 0xfffffff0u}) {
    FrameOrder order(true);
    order.decoded(last, 1, true);
    EXPECT_FALSE(order.isOld(last + half - 1, 2, false));
    EXPECT_TRUE(order.isOld(last + half, 2, false));
    EXPECT_TRUE(order.isOld(last - 1, 2, false));
  }
}

TEST(FrameOrder, CopiesOfFramesBeforeARestartAreOld)
{
  FrameOrder order(true);
  order.decoded(100, 7, true);
  ASSERT_FALSE(order.isOld(1, 8, true)); // the sender was restarted
  order.decoded(1, 8, true);
  EXPECT_TRUE(order.isOld(100, 7, true));
  EXPECT_FALSE(order.isOld(100, 9, true)); // another frame of that number
}

TEST(FrameOrder, OvertakenIFramesAreDropped)
{
  // Frame 11 comes after frame 23: decoding it would cost the frames up to 31.
  const EncodedFrames stream = sent(StreamFormat::Version1, 40, 10);
  FrameDecoder decoder;
  expectReceived(decoder, stream, 0, 10);
  expectReceived(decoder, stream, 20, 23);
  expectReceived(decoder, stream, 10, 11, CompressionCode::OldFrame);
  expectReceived(decoder, stream, 23, 40);
}

TEST(FrameOrder, OfTwoStreamsTheOneWithHigherNumbersIsKept)
{
  const EncodedFrames high = sent(StreamFormat::Version1, 60, 5);
  const EncodedFrames low = sent(StreamFormat::Version1, 60, 5, 2);
  FrameDecoder decoder;
  expectReceived(decoder, high, 0, 30);
  for (std::size_t i = 30; i < 60; ++i) {
    expectReceived(decoder, high, i, i + 1);
    expectReceived(decoder, low, i - 28, i - 27, CompressionCode::OldFrame);
  }
}

} // namespace
