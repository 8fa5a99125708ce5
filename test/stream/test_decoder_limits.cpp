// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/frame_limits.h"
#include "support/forged_frames.h"
#include "support/payload_frames.h"
#include "support/scan_frames.h"
#include "support/scripted_context_payloads.h"
#include "support/supplement_frames.h"
#include "support/test_memory.h"
#include "support/text_parts.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::hasPart;
using pcl_ext::test::MemoryUse;

TEST(DecoderLimits, AreReachedExactly)
{
  std::mt19937_64 random(5);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 10, Effort::Balanced);
    const Bytes i_frame = encoded(encoder, randomFrame(random, 4, 60));
    VoxelFrame frame = randomFrame(random, 4, 61);
    const Bytes p_frame = encoded(encoder, frame);
    const auto code = [&](const DecoderLimits& limits, const Bytes& bytes) {
      FrameDecoder decoder(limits);
      VoxelFrame back;
      decoded(decoder, i_frame, back);
      return decoded(decoder, bytes, back);
    };
    DecoderLimits limits;
    limits.max_voxels = 61;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    EXPECT_EQ(code(limits, p_frame), CompressionCode::Ok);
    limits.max_voxels = 60;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    EXPECT_EQ(code(limits, p_frame), CompressionCode::LimitExceeded);
    limits.max_voxels = 59;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::LimitExceeded);

    limits = DecoderLimits();
    limits.max_frame_bytes = i_frame.size();
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    limits.max_frame_bytes = i_frame.size() - 1;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::LimitExceeded);
    for (std::size_t bytes = 1; bytes < 12; ++bytes) {
      limits.max_frame_bytes = bytes;
      EXPECT_NE(code(limits, i_frame), CompressionCode::Ok);
    }
  }
}

/** \brief A frame, and the least limit that takes it. */
struct LimitedFrame {
  std::string counted;
  Bytes bytes;
  std::size_t DecoderLimits::*limit;
  std::size_t least;
};

TEST(DecoderLimits, OfPointsAndValuesAreReachedExactly)
{
  std::mt19937_64 random(3);
  VoxelFrame points = randomFrame(random, 4, 10);
  points.has_point_counts = true;
  points.point_counts.assign(points.size(), 2000000);
  VoxelFrame fields = randomFrame(random, 4, 10);
  addFields(random, fields);
  scan::ScanFrame scan = makeCamera();
  addPoints(scan, 1);
  FrameEncoder encoder(StreamFormat::Version1, 1);
  const LimitedFrame frames[] = {{"points",
                                  encoded(encoder, points),
                                  &DecoderLimits::max_points,
                                  points.pointCount()},
                                 {"points in order",
                                  encoded(encoder, scan),
                                  &DecoderLimits::max_voxels,
                                  scan.pixels.size()},
                                 {"values of fields",
                                  encoded(encoder, fields),
                                  &DecoderLimits::max_field_values,
                                  fields.fieldValueCount()}};
  for (const auto& [counted, bytes, limit, least] : frames) {
    SCOPED_TRACE(counted);
    DecoderLimits limits;
    limits.*limit = least;
    VoxelFrame back;
    EXPECT_TRUE(FrameDecoder(limits).decode(bytes.data(), bytes.size(), back).ok());
    --(limits.*limit);
    const CompressionStatus status =
        FrameDecoder(limits).decode(bytes.data(), bytes.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::LimitExceeded);
    EXPECT_TRUE(hasPart(status.message(),
                        std::to_string(least) + ' ' + counted +
                            " exceed the limit of " + std::to_string(least - 1)));
    EXPECT_EQ(back.pointCount() + back.fieldValueCount(), 0u);
  }
}

TEST(DecoderLimits, FramesBehindGarbageAreFoundAtAnyOffset)
{
  std::mt19937_64 random(6);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 1, Effort::Balanced);
    const VoxelFrame frame = randomFrame(random, 3, 10);
    const Bytes bytes = encoded(encoder, frame);
    DecoderLimits limits;
    limits.max_frame_bytes = bytes.size() + 10;
    for (std::size_t before = 0; before < 3 * limits.max_frame_bytes; ++before) {
      Bytes stream(before, 0);
      append(bytes, stream);
      std::stringbuf buffer = bufferOf(stream);
      FrameDecoder decoder(limits);
      VoxelFrame back;
      CompressionCode code = CompressionCode::NoFrame;
      for (int calls = 0; calls < 5 && code == CompressionCode::NoFrame; ++calls)
        code = decoder.decode(buffer, back).code();
      ASSERT_EQ(code, CompressionCode::Ok) << before << " bytes of garbage";
      expectSameVoxels(back, frame);
    }
  }
}

// With each voxel in a block of its own, as DecoderLimits::max_voxels has them.
constexpr std::size_t bytes_per_voxel = bytes_of_voxel + bytes_of_block;
constexpr std::size_t hostile_bytes_per_voxel = 2000;
constexpr std::size_t hostile_bytes = std::size_t{1} << 24;

TEST(DecoderLimits, MemoryStaysWithinTheDocumentedLimit)
{
  std::mt19937_64 random(7);
  DecoderLimits limits;
  limits.max_voxels = std::size_t{1} << 15;
  for (const StreamFormat format : all_formats)
    for (const unsigned int depth : {5u, 8u, 21u}) {
      FrameEncoder encoder(format, 100, Effort::Balanced);
      VoxelFrame frame = randomFrame(random, depth, 0);
      if (depth == 5) // all of the grid
        for (std::uint64_t key = 0; key < limits.max_voxels; ++key) {
          frame.keys.push_back(key);
          frame.intensities.push_back(static_cast<std::uint16_t>(key % 256));
        }
      else
        frame = randomFrame(random, depth, limits.max_voxels);
      std::vector<Bytes> stream;
      for (int i = 0; i < 5; ++i) {
        stream.push_back(encoded(encoder, frame));
        if (depth != 5)
          walk(random, static_cast<unsigned int>(limits.max_voxels / 50), frame);
      }
      FrameDecoder decoder(limits);
      VoxelFrame back;
      const MemoryUse memory_use;
      for (const Bytes& bytes : stream)
        ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
      const std::size_t taken = memory_use.peak();
      EXPECT_LE(taken, bytes_per_voxel * limits.max_voxels + stream[0].size())
          << "depth " << depth << ": " << taken / limits.max_voxels << " bytes a voxel";
    }
}

TEST(DecoderLimits, StreamsThatFillTheHistoryAreRefused)
{
  // Every frame has other voxels, none of which is forgotten so soon.
  DecoderLimits limits;
  limits.max_voxels = std::size_t{1} << 15;
  FrameDecoder decoder(limits);
  VoxelFrame back;
  ContextState hostile; // without the encoder's rules
  Parts frame;
  frame.header.grid = emptyFrame(21).grid;
  frame.header.voxel_count = limits.max_voxels;
  frame.header.effort = Effort::Balanced;
  std::uint32_t checksum = 0;
  std::size_t good_frames = 0;
  std::size_t kept = 0; // by the decoder
  std::size_t peak = 0;
  CompressionCode code = CompressionCode::Ok;
  while (code == CompressionCode::Ok && good_frames < 20) {
    VoxelFrame voxels = emptyFrame(21);
    // Voxels a block apart, which take the most memory.
    const std::uint64_t first = good_frames * limits.max_voxels;
    for (std::uint64_t i = 0; i < limits.max_voxels; ++i)
      voxels.keys.push_back((first + i) << block_key_bits);
    voxels.intensities.assign(limits.max_voxels, 1);
    frame.header.is_i_frame = good_frames == 0;
    ++frame.header.frame_number;
    const BlockList blocks = blocksOf(voxels.keys);
    ContextScript script(hostile, voxels);
    script.occupancy(blocks);
    script.numbers(blocks, voxels.intensities);
    frame.payload = script.finish(blocks, voxels.intensities);
    hostile = script.state;
    const Bytes bytes = putTogetherSized(frame, checksum);
    checksum = takeApart(bytes).checksum;
    const MemoryUse memory_use;
    code = decoded(decoder, bytes, back);
    peak = std::max(peak, kept + memory_use.peak());
    kept += memory_use.live();
    good_frames += code == CompressionCode::Ok ? 1 : 0;
  }
  EXPECT_EQ(code, CompressionCode::LimitExceeded);
  EXPECT_GE(good_frames, 3u); // no honest stream is refused so soon
  EXPECT_LE(peak, hostile_bytes_per_voxel * limits.max_voxels + hostile_bytes)
      << peak / limits.max_voxels << " bytes a voxel";
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  EXPECT_EQ(decoded(decoder, encoded(encoder, emptyFrame(3)), back),
            CompressionCode::Ok);
}

} // namespace
