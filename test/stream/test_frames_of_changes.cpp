// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief P-frames that have only what changed.
 */
#include <pcl_ext/compression/frame_description.h>

#include "support/changing_frames.h"
#include "support/forged_frames.h"
#include "support/supplement_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr unsigned int few_changes = 40; // of a frame

struct Kind {
  std::string name;
  unsigned int bits;
  bool has_depth_model;
  bool is_fine;

  ChangingFrames
  frames() const
  {
    return ChangingFrames(bits, has_depth_model, is_fine);
  }
};

class FramesOfChanges : public testing::TestWithParam<Kind> {};

INSTANTIATE_TEST_SUITE_P(Kinds,
                         FramesOfChanges,
                         testing::Values(Kind{"Counts", 8, false, false},
                                         Kind{"Depths", 16, true, false},
                                         Kind{"OneBit", 1, false, false},
                                         Kind{"NoIntensities", 0, false, false},
                                         Kind{"Fine", 8, false, true},
                                         Kind{"FineNoIntensities", 0, false, true}),
                         [](const auto& kind) { return kind.param.name; });

TEST_P(FramesOfChanges, DecodeToTheirVoxelsInAllEfforts)
{
  for (const Effort effort : all_efforts) {
    ChangingFrames frames = GetParam().frames();
    FrameEncoder encoder(StreamFormat::Version1, 25, effort);
    FrameDecoder decoder;
    for (unsigned int i = 0; i < 40; ++i) {
      const VoxelFrame frame = frames.next(i % 11 == 10 ? 0 : few_changes);
      const Bytes bytes = encoded(encoder, frame);
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok) << i;
      expectSameFrame(back, frame);
      const bool is_i_frame = i % 25 == 0;
      EXPECT_EQ(encoder.statistics().is_of_changes, !is_i_frame);
      EXPECT_EQ(decoder.statistics().is_of_changes, !is_i_frame);
      EXPECT_EQ(describeFrame(bytes.data(), bytes.size()).is_of_changes, !is_i_frame);
    }
  }
}

char
kindOf(const FrameEncoder& encoder)
{
  const auto& last = encoder.statistics();
  return last.is_i_frame ? 'I' : last.is_of_changes ? 'c' : 'P';
}

TEST_P(FramesOfChanges, AreOneOfSeveralKindsInAStream)
{
  for (const Effort effort : all_efforts) {
    ChangingFrames frames = GetParam().frames();
    FrameEncoder encoder(StreamFormat::Version1, 100, effort);
    FrameDecoder decoder;
    std::string kinds;
    for (const unsigned int changes :
         {0u, few_changes, 3000u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, few_changes}) {
      const VoxelFrame frame = frames.next(changes);
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
      expectSameFrame(back, frame);
      kinds += kindOf(encoder);
    }
    // With many changes there is none, but at once after such a P-frame.
    EXPECT_EQ(kinds, "IcPccccccccc");
  }
}

TEST(FramesOfChanges, TakeLessThanOtherFrames)
{
  ChangingFrames frames(8);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  const std::size_t i_frame = encoded(encoder, frames.next(0)).size();
  encoded(encoder, frames.next(few_changes));
  // Nothing changes: one nibble for each of about a hundred blocks.
  EXPECT_LT(encoded(encoder, frames.next(0)).size(), std::size_t{80});
  EXPECT_LT(encoded(encoder, frames.next(few_changes)).size(), i_frame / 4);
}

TEST(FramesOfChanges, FollowPFramesOfManyBytes)
{
  // All intensities change once: then they stay, and are not sent again.
  ChangingFrames frames(16);
  VoxelFrame frame = frames.next(0);
  for (const Effort effort : all_efforts) {
    FrameEncoder encoder(StreamFormat::Version1, 100, effort);
    std::string kinds;
    for (unsigned int i = 0; i < 4; ++i) {
      if (i == 1)
        for (std::uint16_t& intensity : frame.intensities)
          intensity = static_cast<std::uint16_t>(intensity * 40503u + 1u);
      encoded(encoder, frame);
      kinds += kindOf(encoder);
    }
    EXPECT_EQ(kinds, "IPcc");
    EXPECT_LT(encoder.statistics().bytes, std::size_t{80});
  }
}

TEST(FramesOfChanges, AreFollowedByAPFrameThatHasFewBytes)
{
  ChangingFrames frames(0);
  const VoxelFrame first = frames.next(0);
  const VoxelFrame second = frames.next(260);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  std::string kinds;
  for (unsigned int i = 0; i < 24; ++i) {
    encoded(encoder, i / 3 % 2 == 0 ? first : second);
    kinds += kindOf(encoder);
  }
  // The history has both after a few turns.
  EXPECT_EQ(kinds.substr(12).find('I'), std::string::npos) << kinds;
  EXPECT_NE(kinds.substr(12).find('c'), std::string::npos) << kinds;
}

/** \brief A stream: an I-frame, a frame of changes, and two more. */
class ForgedFramesOfChanges : public testing::Test {
protected:
  void
  SetUp() override
  {
    ChangingFrames frames(8);
    FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
    for (unsigned int i = 0; i < 4; ++i) {
      frames_.push_back(frames.next(few_changes));
      bytes_.push_back(encoded(encoder, frames_.back()));
    }
    reference_ = takeApart(bytes_[0]).checksum;
    parts_ = takeApart(bytes_[1]);
    ASSERT_TRUE(parts_.header.is_of_changes);
  }

  /** \brief The answer to other bytes in the place of the second frame; refused, they
   * must leave the stream as it was. */
  CompressionCode
  answer(const Bytes& forged) const
  {
    return answerTo(forged,
                    bytes_[0],
                    {bytes_.begin() + 1, bytes_.end()},
                    {frames_.begin() + 1, frames_.end()});
  }

  std::vector<VoxelFrame> frames_;
  std::vector<Bytes> bytes_;
  std::uint32_t reference_ = 0;
  Parts parts_;
};

TEST_F(ForgedFramesOfChanges, HaveNeitherDepthModelNorContent)
{
  for (const unsigned int flag : {2u, 128u}) {
    Bytes forged = bytes_[1];
    forged[flags_offset] = static_cast<std::uint8_t>(forged[flags_offset] | flag);
    EXPECT_EQ(answer(withChecksum(forged, reference_)), CompressionCode::Corrupt);
  }
}

TEST_F(ForgedFramesOfChanges, DoNotFollowAFrameWithColours)
{
  std::mt19937_64 random(3);
  ChangingFrames frames(8);
  VoxelFrame frame = frames.next(0);
  addColours(random, 5, frame);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  const Bytes first = encoded(encoder, frame);
  ASSERT_EQ(decoded(decoder, first, back), CompressionCode::Ok);
  parts_.header.frame_number = 2;
  const Bytes forged = putTogether(parts_, takeApart(first).checksum);
  const CompressionStatus status = decoder.decode(forged.data(), forged.size(), back);
  EXPECT_EQ(status.code(), CompressionCode::Corrupt);
  EXPECT_NE(status.message().find("cannot refer to"), std::string::npos)
      << status.message();
  EXPECT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
  expectSameFrame(back, frame);
}

} // namespace
