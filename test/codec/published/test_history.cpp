// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Which frame of the published layout a P-frame may follow.
 */
#include "codec/published/frame.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using namespace pcl_ext::io::test;

/** \brief A stream of the published layout: an I-frame and P-frames. */
EncodedFrames
stream(std::size_t count)
{
  std::mt19937_64 random(count);
  FrameEncoder encoder(StreamFormat::Published, static_cast<unsigned int>(count));
  return encodedWalk(encoder, random, randomFrame(random, 4, 50), count, 5);
}

void
setNumber(std::uint32_t number, Bytes& frame)
{
  std::memcpy(frame.data() + published::magic_size, &number, sizeof(number));
}

TEST(PublishedHistory, APFrameFollowsOnlyTheFrameBeforeIt)
{
  const EncodedFrames sent = stream(5);
  FrameDecoder decoder;
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, sent.bytes[1], back), CompressionCode::MissingReference);
  for (std::size_t last = 0; last < sent.bytes.size(); ++last) {
    ASSERT_EQ(decoded(decoder, sent.bytes[last], back), CompressionCode::Ok);
    expectSameVoxels(back, sent.frames[last]);
    for (std::size_t next = 1; next < sent.bytes.size(); ++next)
      if (next != last + 1) {
        EXPECT_EQ(decoded(decoder, sent.bytes[next], back),
                  next <= last ? CompressionCode::OldFrame
                               : CompressionCode::MissingReference)
            << "frame " << next + 1 << " behind frame " << last + 1;
      }
  }
}

TEST(PublishedHistory, FrameNumbersWrapRound)
{
  EncodedFrames sent = stream(3);
  const std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
  setNumber(last - 1, sent.bytes[0]);
  setNumber(last, sent.bytes[1]);
  setNumber(0, sent.bytes[2]);
  FrameDecoder decoder;
  VoxelFrame back;
  for (std::size_t i = 0; i < sent.bytes.size(); ++i) {
    ASSERT_EQ(decoded(decoder, sent.bytes[i], back), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().frame_number,
              static_cast<std::uint32_t>(last - 1 + i));
    expectSameVoxels(back, sent.frames[i]);
  }
}

TEST(PublishedHistory, AFrameIsAppendedAndCountedAlone)
{
  const EncodedFrames sent = stream(2);
  published::History history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    Bytes bytes(5, 0xaa);
    CodedFrameStatistics statistics;
    published::encodeFrame(sent.frames[i], i == 0, history, bytes, statistics);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 5), Bytes(5, 0xaa));
    EXPECT_EQ(Bytes(bytes.begin() + 5, bytes.end()), sent.bytes[i]);
    EXPECT_EQ(statistics.frame_number, i + 1);
    EXPECT_EQ(statistics.bytes, sent.bytes[i].size());
    EXPECT_EQ(statistics.header_bytes, i == 0 ? 75u : 11u);
    EXPECT_EQ(statistics.header_bytes + statistics.occupancy_bytes +
                  statistics.intensity_bytes,
              statistics.bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    for (std::size_t j = 0; j <= i; ++j)
      ASSERT_EQ(decoded(decoder, sent.bytes[j], back), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().bytes, statistics.bytes);
    EXPECT_EQ(decoder.statistics().header_bytes, statistics.header_bytes);
    EXPECT_EQ(decoder.statistics().occupancy_bytes, statistics.occupancy_bytes);
    EXPECT_EQ(decoder.statistics().intensity_bytes, statistics.intensity_bytes);
    // Each row of symbols has its count and table.
    EXPECT_GT(statistics.occupancy_bytes, 1036u);
    EXPECT_GT(statistics.intensity_bytes, 1036u + sent.frames[i].size() / 4);
  }
}

} // namespace
