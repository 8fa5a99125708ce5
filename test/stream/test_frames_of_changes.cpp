// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief P-frames that have only what changed.
 */
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/compression/voxel_changes.h>

#include "support/changing_frames.h"
#include "support/forged_frames.h"
#include "support/supplement_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <tuple>
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

char
kindOf(const CodedFrameStatistics& frame)
{
  return frame.is_i_frame ? 'I' : frame.is_of_changes ? 'c' : 'P';
}

TEST_P(FramesOfChanges, DecodeToTheirVoxelsAndAreOneOfSeveralKinds)
{
  for (const Effort effort : all_efforts) {
    ChangingFrames frames = GetParam().frames();
    FrameEncoder encoder(StreamFormat::Version1, 26, effort);
    FrameDecoder decoder;
    std::string kinds;
    for (unsigned int i = 0; i < 40; ++i) {
      const VoxelFrame frame = frames.next(i == 2             ? 3000
                                           : i == 1 || i > 10 ? few_changes
                                                              : 0);
      const Bytes bytes = encoded(encoder, frame);
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok) << i;
      expectSameFrame(back, frame);
      kinds += kindOf(encoder.statistics());
      EXPECT_EQ(kindOf(decoder.statistics()), kinds.back());
      EXPECT_EQ(describeFrame(bytes.data(), bytes.size()).is_of_changes,
                kinds.back() == 'c');
    }
    // With many changes there is none, but at once after such a P-frame.
    EXPECT_EQ(kinds, "IcP" + std::string(23, 'c') + 'I' + std::string(13, 'c'));
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
      kinds += kindOf(encoder.statistics());
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
    kinds += kindOf(encoder.statistics());
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

// ---------------------------------------------------------------- encoding changes

class EncodingChanges
: public ::testing::TestWithParam<std::tuple<Effort, unsigned int>> {
protected:
  static FrameEncoder
  encoder()
  {
    constexpr unsigned int i_frame_rate = 20;
    return {StreamFormat::Version1, i_frame_rate, std::get<0>(GetParam())};
  }

  /** \brief Whether the next frame is encoded by its changes; all bytes are compared. */
  bool
  encodeNext(unsigned int changes_of_frame)
  {
    const VoxelFrame frame = frames_.next(changes_of_frame);
    findChanges(last_, frame, changes_);
    changes_.is_from_nothing = last_.keys.empty();
    Bytes bytes;
    const auto status = by_changes_.encode(changes_, std::nullopt, bytes);
    if (status)
      EXPECT_TRUE(status->ok());
    else
      EXPECT_TRUE(by_changes_.encode(frame, std::nullopt, bytes).ok());
    EXPECT_EQ(bytes, encoded(whole_, frame));
    EXPECT_EQ(by_changes_.statistics().voxels, frame.size());
    EXPECT_EQ(status.has_value(), whole_.statistics().is_of_changes);
    last_ = frame;
    return status.has_value();
  }

  ChangingFrames frames_{std::get<1>(GetParam())};
  VoxelFrame last_;
  VoxelChanges changes_;
  FrameEncoder by_changes_ = encoder();
  FrameEncoder whole_ = encoder();
};

TEST_P(EncodingChanges, HasTheBytesOfAllVoxels)
{
  std::size_t by_changes = 0;
  for (std::size_t i = 0; i < 60; ++i)
    by_changes += encodeNext(i % 7 == 6 ? 900 : 12) ? 1 : 0;
  EXPECT_GT(by_changes, 10u);
  EXPECT_LT(by_changes, 57u);
}

TEST_P(EncodingChanges, OfAnotherFrameAreRefused)
{
  while (!encodeNext(12)) {
  }
  const VoxelFrame none = emptyFrame(ChangingFrames::depth, std::get<1>(GetParam()));
  VoxelFrame one = none;
  one.keys = {last_.keys[7]};
  one.intensities.assign(std::get<1>(GetParam()) > 0 ? 1 : 0, 0);
  VoxelFrame other = one;
  other.keys = {last_.keys.back() + 1};
  Bytes bytes;
  const auto is_refused = [&](const VoxelFrame& gone, const VoxelFrame& came) {
    return !by_changes_.encode(VoxelChanges{gone, came}, std::nullopt, bytes) &&
           bytes.empty();
  };
  EXPECT_TRUE(is_refused(other, none)); // is not there
  EXPECT_TRUE(is_refused(none, one));   // is there
  if (one.hasIntensities())
    one.intensities[0] = last_.intensities[7];
  EXPECT_TRUE(is_refused(one, one)); // stays as it is
  other.grid.first_index[0] += 1;
  EXPECT_TRUE(is_refused(other, other)); // of another grid
  // The stream goes on as if they had not been there.
  EXPECT_TRUE(encodeNext(12));
}

INSTANTIATE_TEST_SUITE_P(
    Of,
    EncodingChanges,
    ::testing::Combine(::testing::Values(Effort::Fast, Effort::Balanced, Effort::Small),
                       ::testing::Values(0u, 8u)));

} // namespace
