// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "bytes/byte_writer.h"
#include "codec/published/entropy_coder.h"
#include "codec/published/frame.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using namespace pcl_ext::io::test;

struct IFrame {
  unsigned int depth = 4;
  double resolution = 0.5;
  std::array<double, 3> min{-1.0, 2.0, 30.0};
  std::array<double, 3> max{7.0, 10.0, 38.0};
  std::uint64_t leaf_count = 1;
  Bytes occupancy; // empty: of the voxel alone

  /** \brief Puts the box where the octree's cube begins at a coordinate. */
  void
  fitBox(double begin)
  {
    min.fill(begin);
    max.fill(begin + std::ldexp(resolution, static_cast<int>(depth)));
  }

  Bytes
  bytes() const
  {
    Bytes bytes{'<', 'H', 'E', 'A', 'D', '>'};
    ByteWriter writer(bytes);
    writer.u32(1);
    writer.u8(1);
    writer.u64(leaf_count);
    writer.f64(resolution);
    for (const double coordinate : min)
      writer.f64(coordinate);
    for (const double coordinate : max)
      writer.f64(coordinate);
    const Bytes symbols = occupancy.empty() ? Bytes(depth, 0x80) : occupancy;
    writer.u64(symbols.size());
    encodeStaticRange(symbols, bytes);
    writer.u64(1);
    encodeStaticRange({9}, bytes);
    return bytes;
  }
};

CompressionCode
codeOf(const IFrame& frame, const DecoderLimits& limits = DecoderLimits())
{
  FrameDecoder decoder(limits);
  VoxelFrame back;
  const CompressionCode code = decoded(decoder, frame.bytes(), back);
  if (code == CompressionCode::Ok) {
    EXPECT_EQ(back.grid.depth, frame.depth);
    EXPECT_EQ(back.grid.resolution, frame.resolution);
    EXPECT_EQ(back.grid.origin, frame.min);
    EXPECT_EQ(back.keys[0], (std::uint64_t{1} << (3 * frame.depth)) - 1);
  }
  return code;
}

TEST(PublishedBoxes, HaveDepthsEdgesAndCornersWithinTheirRanges)
{
  const auto expect = [](bool is_good,
                         unsigned int depth,
                         double resolution,
                         double begin) {
    IFrame frame;
    frame.depth = depth;
    frame.resolution = resolution;
    frame.fitBox(begin);
    EXPECT_EQ(codeOf(frame), is_good ? CompressionCode::Ok : CompressionCode::Corrupt)
        << depth << ", " << resolution << ", " << begin;
  };
  for (unsigned int depth = 0; depth <= 30; ++depth)
    expect(depth >= 1 && depth <= 21, depth, 0.5, -3.0);
  // From a micrometre to a thousand kilometres.
  for (const double resolution : {1e-6, 1.0, 1e6})
    expect(true, 4, resolution, 0.0);
  for (const double resolution : {0.999e-6, 1.001e6})
    expect(false, 4, resolution, 0.0);
  const double end = 1e6 * 0x1p21; // of the largest lattice
  for (const double begin : {-0.99 * end, 0.99 * end})
    expect(true, 4, 1e6, begin);
  for (const double begin : {-end, end - 16e6, end, 1e200, -1e200})
    expect(false, 4, 1e6, begin);
}

TEST(PublishedBoxes, CubesWithinPclsTolerance)
{
  // PCL leaves out an epsilon where it enlarges a box, and leaves a box alone that is
  // off by less than one at either end.
  constexpr double epsilon = std::numeric_limits<float>::epsilon();
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      IFrame frame;
      for (const double share : {1.0, 1.99}) {
        frame.max[axis] = IFrame().max[axis] + sign * share * epsilon;
        EXPECT_EQ(codeOf(frame), CompressionCode::Ok) << axis << ", " << sign * share;
      }
      for (const double share : {2.01, 100.0, 1e6}) {
        frame.max[axis] = IFrame().max[axis] + sign * share * epsilon;
        EXPECT_EQ(codeOf(frame), CompressionCode::Corrupt)
            << axis << ", " << sign * share;
      }
    }
  // Far out, doubles are coarser than that.
  for (const double begin : {-1e8, 1e8}) {
    IFrame frame;
    frame.fitBox(begin);
    frame.max[1] += 9e-5;
    EXPECT_EQ(codeOf(frame), CompressionCode::Ok) << begin;
    frame.max[1] += 2e-5;
    EXPECT_EQ(codeOf(frame), CompressionCode::Corrupt) << begin;
  }
}

TEST(PublishedBoxes, LeafCountsAreThoseOfTheVoxelsAndWithinTheLimit)
{
  DecoderLimits limits;
  limits.max_voxels = 3;
  IFrame frame;
  EXPECT_EQ(codeOf(frame, limits), CompressionCode::Ok);
  for (const std::uint64_t count : {0u, 2u, 3u}) {
    frame.leaf_count = count;
    EXPECT_EQ(codeOf(frame, limits), CompressionCode::Corrupt) << count;
  }
  frame.leaf_count = 4;
  EXPECT_EQ(codeOf(frame, limits), CompressionCode::LimitExceeded);
  limits.max_voxels = 0;
  frame.leaf_count = 0;
  EXPECT_EQ(codeOf(frame, limits), CompressionCode::LimitExceeded);
}

TEST(PublishedBoxes, BranchesWithoutVoxelsAreWithinTheLimit)
{
  DecoderLimits limits;
  limits.max_voxels = 1;
  IFrame frame;
  frame.occupancy = {0xf8, 0, 0, 0, 0, 0x80, 0x80, 0x80}; // two ways of four levels
  EXPECT_EQ(codeOf(frame, limits), CompressionCode::Ok);
  frame.occupancy = {0xfc, 0, 0, 0, 0, 0, 0x80, 0x80, 0x80};
  EXPECT_EQ(codeOf(frame, limits), CompressionCode::LimitExceeded);
  EXPECT_EQ(codeOf(frame), CompressionCode::Ok);
}

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
